"""Where the infrared beacon is and which way it shines, out of what three receivers see."""

import math

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import InfraredReading, Observation
from docking.parameters import Receivers

RANGE_GAIN = 0.2
"""How much of a difference in distance is believed at once: the readings are noisy."""
BEARING_GAIN = 0.8
"""The same for a direction that cannot be."""
FARTHEST = 10.0
"""In m; no beacon is seen from farther away."""
FRESH = 0.3
"""How old a reading may be, in s."""


class BeaconFilter:
    """Follows the beacon, which stands still in odom.

    A distance is averaged. A direction is only known to lie in a sector, so it is moved just as far as it must be; a
    robot that turns to and fro past the sectors' edges learns it well.

    How far the robot is off the dock's axis cannot be told from the beacon alone: it looks the same from all sides.
    But it shines only so far to each side. Where the robot crosses an edge of its light, the axis is known.

    Attributes:
        position: Of the beacon in odom, not turned; None before it was seen.
        seen_at: When it was seen last.
        count: Readings that saw it.
        lit: Where the receivers were when they saw it last, in odom.
        dark: Readings since then, which saw nothing.
        heard_at: When the last reading was made, whatever it saw.
        edges: Where the receivers were at an edge of the light, in odom, by side: 1 is the right one, as seen from the
            robot when it looks at the dock, -1 the left one.
    """

    def __init__(self, receivers: Receivers) -> None:
        self.receivers = receivers
        self.position: Pose | None = None
        self.seen_at = -math.inf
        self.count = 0
        self.lit: Pose | None = None
        self.dark = 0
        self.heard_at = -math.inf
        self.edges: dict[int, Pose] = {}

    @property
    def axis(self) -> float | None:
        """The way into the dock, in rad in odom; None before an edge is known."""
        if self.position is None or not self.edges:
            return None
        ways = [
            self.line_of_sight(edge) - side * self.receivers.infrared_beacon_angle for side, edge in self.edges.items()
        ]
        return math.atan2(math.fsum(map(math.sin, ways)), math.fsum(map(math.cos, ways)))

    def line_of_sight(self, receivers: Pose) -> float:
        """The direction to the beacon, in rad in odom."""
        assert self.position is not None
        return math.atan2(self.position.y - receivers.y, self.position.x - receivers.x)

    def bearing(self, robot: Pose) -> float:
        """How far to the left of straight ahead the beacon is, in rad."""
        return normalize_angle(self.line_of_sight(self.receivers.position(robot)) - robot.theta)

    def update(self, observation: Observation) -> None:
        """Take over a new reading."""
        odometry, reading = observation.odometry, observation.infrared
        if odometry is None or reading is None or not odometry.pose.finite:
            return
        if not (reading.stamp > self.heard_at and abs(observation.now - reading.stamp) <= FRESH):
            return
        self.heard_at = reading.stamp
        sector = find_sector(reading, self.receivers)
        if sector is None:
            self.dark += 1
            return
        self.lit, self.dark = self.receivers.position(odometry.pose), 0
        self.seen_at = reading.stamp
        self.count += 1
        self._correct(odometry.pose, _distance(reading), sector)

    def _correct(self, robot: Pose, distance: float, sector: tuple[float, float]) -> None:
        receivers = self.receivers.position(robot)
        if self.position is None:
            bearing = 0.5 * (sector[0] + sector[1])
        else:
            bearing = self.bearing(robot)
            nearest = min(max(bearing, sector[0]), sector[1])
            bearing += BEARING_GAIN * (nearest - bearing)
            known = receivers.distance_to(self.position)
            distance = known + RANGE_GAIN * (distance - known)
        ahead = receivers.compose(Pose(distance * math.cos(bearing), distance * math.sin(bearing)))
        self.position = Pose(ahead.x, ahead.y)


def find_sector(reading: InfraredReading, receivers: Receivers) -> tuple[float, float] | None:
    """Between which bearings the beacon is, in rad to the left of straight ahead; None where it is not seen."""
    half, angle = 0.5 * receivers.infrared_field_of_view, receivers.infrared_receiver_angle
    lowest, highest = -math.pi, math.pi
    for distance, direction in ((reading.left, angle), (reading.center, 0.0), (reading.right, -angle)):
        if _sees(distance):
            lowest, highest = max(lowest, direction - half), min(highest, direction + half)
    if lowest == -math.pi or lowest > highest:
        return None
    # Where one sees it and its neighbour does not, the neighbour's view ends there.
    if not _sees(reading.center):
        if _sees(reading.left):
            lowest = max(lowest, half)
        else:
            highest = min(highest, -half)
    else:
        if not _sees(reading.left):
            highest = min(highest, angle - half)
        if not _sees(reading.right):
            lowest = max(lowest, half - angle)
    return lowest, highest


def _sees(distance: float) -> bool:
    """Whether a receiver sees the beacon: infinity is nothing seen, minus infinity too near to tell (REP-117)."""
    return distance < math.inf


def _distance(reading: InfraredReading) -> float:
    """The mean of those that see the beacon, in m; where it is too near to tell, it is 0."""
    seen = [
        min(max(distance, 0.0), FARTHEST)
        for distance in (reading.left, reading.center, reading.right)
        if _sees(distance)
    ]
    return math.fsum(seen) / len(seen)
