"""Where the infrared beacon is and which way it shines, out of what three receivers see.

An extended Kalman filter (Thrun, Burgard and Fox, Probabilistic Robotics, 2005, section 3.3) for the robot's pose as
seen from the beacon, for the errors of odometry, and for the dock's axis.
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import InfraredReading, Observation
from docking.estimation.receivers import Change, Sight, find_sector, ranges_of
from docking.estimation.track import Track
from docking.parameters import Receivers

Vector = npt.NDArray[np.float64]

FRESH = 0.3
"""How old a reading may be, in s."""
WELL_INSIDE = 0.05
"""How far from the edge of what the receivers see, beyond a standard deviation, in rad, the beacon must be in sight."""
NEAREST = 0.1
"""From the receivers to the beacon, in m: nearer than that, a bearing says little and the receivers see differently."""
AGREEING = 5
"""Readings out of the last `REMEMBERED` that must agree on a distance for the beacon to be where they say."""
REMEMBERED = 8
SAME = 0.08
"""How much distances may differ that agree, in m."""

RANGE_GATE = 0.1
"""Beyond 4 standard deviations of the estimate, in m: what is farther off is no distance to the beacon."""
BEARING_NOISE = 0.012
"""Standard deviation of the direction of the edge of a receiver's view, in rad."""
BEARING_GATE = 0.15
"""Beyond 3 standard deviations of the estimate, in rad: a receiver does not see that far beyond its view."""
SECTOR_NOISE = 0.05
"""Standard deviation of a bearing, in rad, that is known only by the receivers which see the beacon."""
EDGE_NOISE = 0.012
"""Standard deviation of the direction of an edge of the light, in rad."""
ANGLE_NOISE = 0.02
"""Standard deviation of infrared_beacon_angle, in rad."""
GATE = 16.0
"""Squared, in standard deviations: what is less likely is not believed."""

WAY_NOISE, DRIVING_NOISE, TURNING_NOISE = 0.01, 0.025, 0.01
"""Standard deviations of odometry's random errors: in m after 1 m, in rad after 1 m, and in rad after 1 rad."""
UNKNOWN = 2.0
"""Standard deviation of an axis that is not known, in rad."""

X, Y, THETA, WAY, TURN, CURVE, AXIS, ANGLE = range(8)
"""The state: base_link as seen from the beacon; by what to multiply ways and turns of odometry, and how much the robot
turns on each m, unnoticed; the way into the dock; and how far from that the light reaches to each side."""


@dataclass(frozen=True, slots=True)
class Crossing:
    """The receivers left the beacon's light, or came back into it.

    Attributes:
        lit: Whether they came into it.
        line_of_sight: The direction to the beacon there, in rad in the filter's frame.
        stamp: When.
    """

    lit: bool
    line_of_sight: float
    stamp: float


class BeaconFilter:
    """Follows the beacon, which stands still.

    A receiver sees the beacon within its field of view. So its bearing is known exactly where a receiver begins or
    ceases to see it, and roughly everywhere else. Together with the distances this also shows how wrong odometry is:
    wheels that slip or differ.

    How far the robot is off the dock's axis cannot be told from the beacon alone: it looks the same from all sides.
    But it shines only so far to each side. Where the robot crosses an edge of its light, the axis is known.

    Readings that fit neither the estimate nor each other (ghosts) are ignored; `AGREEING` that fit each other, but not
    the estimate, mean that the robot or the dock was moved.

    Attributes:
        seen_at: When the beacon was seen last.
        heard_at: When the last reading was made, whatever it saw.
        count: Readings that saw the beacon.
        crossings: Of the edges of its light, the latest ones, in their order.
        edges: On which sides the edge of its light is known: 1 is the right one, as seen from a robot that looks at the
            dock, -1 the left one.
    """

    def __init__(self, receivers: Receivers) -> None:
        self.receivers = receivers
        self.seen_at = -math.inf
        self.heard_at = -math.inf
        self.count = 0
        self.crossings: deque[Crossing] = deque(maxlen=4)
        self.edges: set[int] = set()
        self._track = Track()
        self._odometry: Pose | None = None
        self._state: Vector | None = None
        self._covariance: Vector = np.zeros((8, 8))
        self._strange: deque[tuple[float, tuple[float, float, float]]] = deque(maxlen=REMEMBERED)
        self._clear_sights()

    # What is known.

    @property
    def known(self) -> bool:
        """Whether the beacon was found."""
        return self._state is not None

    @property
    def position(self) -> Pose | None:
        """Of the beacon in odom, not turned; None before it was seen."""
        if self._state is None or self._odometry is None:
            return None
        seen = self._odometry.compose(self._pose.inverse())
        return Pose(seen.x, seen.y)

    @property
    def axis(self) -> float | None:
        """The way into the dock, in rad in odom; None before an edge is known."""
        if self._state is None or self._odometry is None or not self.edges:
            return None
        return normalize_angle(float(self._state[AXIS] - self._state[THETA]) + self._odometry.theta)

    @property
    def axis_error(self) -> float:
        """Standard deviation of the robot's angle off the dock's axis, in rad."""
        if self._state is None or not self.edges:
            return UNKNOWN
        gradient = self._view(self.heard_at).of_line_of_sight()
        gradient[AXIS] -= 1.0
        return math.sqrt(max(0.0, float(gradient @ self._covariance @ gradient)))

    def line_of_sight(self, receivers: Pose) -> float:
        """The direction to the beacon, in rad in odom."""
        position = self.position
        assert position is not None
        return math.atan2(position.y - receivers.y, position.x - receivers.x)

    def bearing(self, robot: Pose) -> float:
        """How far to the left of straight ahead the beacon is, in rad."""
        return normalize_angle(self.line_of_sight(self.receivers.position(robot)) - robot.theta)

    def distance(self, robot: Pose) -> float:
        """From the receivers to the beacon, in m."""
        position = self.position
        assert position is not None
        return self.receivers.position(robot).distance_to(position)

    @property
    def angle(self) -> float:
        """The direction to the beacon, in rad in the filter's frame: it does not drift as odometry does."""
        return self._view(self.heard_at).line_of_sight

    @property
    def lit(self) -> bool:
        """Whether the receivers are in the light."""
        return self._light.seen is True

    # What comes in.

    def update(self, observation: Observation) -> None:
        """Take over odometry and a new reading."""
        odometry, reading = observation.odometry, observation.infrared
        if odometry is None or not odometry.pose.finite:
            return
        self._track.add(odometry.stamp, odometry)
        self._move(odometry.pose)
        if reading is None or math.isnan(reading.left + reading.center + reading.right):
            return
        if not (reading.stamp > self.heard_at and abs(observation.now - reading.stamp) <= FRESH):
            return
        if reading.stamp - self.heard_at > FRESH:
            self._clear_sights()
        self.heard_at = reading.stamp
        self._read(reading)

    def confirm_edge(self, side: int, line_of_sight: float) -> None:
        """An edge of the light was crossed.

        Args:
            side: Which one, as in `edges`.
            line_of_sight: The direction to the beacon there, in rad in the filter's frame, some moments ago.
        """
        assert self._state is not None
        view = self._view(self.heard_at)
        gradient = view.of_line_of_sight()
        gradient[AXIS] -= 1.0
        gradient[ANGLE] -= side
        innovation = normalize_angle(float(self._state[AXIS] + side * self._state[ANGLE]) - line_of_sight)
        if self._innovate(gradient, innovation, EDGE_NOISE**2):
            self.edges.add(side)
            return
        # One of the two was no edge. This one has just been looked at more than once.
        self.forget_axis()
        self._innovate(gradient, normalize_angle(innovation), EDGE_NOISE**2, gate=math.inf)
        self.edges.add(side)

    def forget_axis(self) -> None:
        """What was taken for an edge of the light cannot have been one."""
        self.edges.clear()
        for unknown, deviation in ((AXIS, UNKNOWN), (ANGLE, ANGLE_NOISE)):
            self._covariance[unknown, :] = self._covariance[:, unknown] = 0.0
            self._covariance[unknown, unknown] = deviation**2
        if self._state is not None:
            self._state[ANGLE] = self.receivers.infrared_beacon_angle

    # How the robot moves.

    @property
    def _pose(self) -> Pose:
        assert self._state is not None
        return Pose(float(self._state[X]), float(self._state[Y]), float(self._state[THETA]))

    def _move(self, odometry: Pose) -> None:
        last, self._odometry = self._odometry, odometry
        if last is None or self._state is None:
            return
        moved = odometry.relative_to(last)
        if moved.x == 0.0 == moved.theta:
            return
        state = self._state
        way = float(state[WAY]) * moved.x
        turn = float(state[TURN]) * moved.theta + float(state[CURVE]) * moved.x
        heading = float(state[THETA]) + 0.5 * turn
        cos, sin = math.cos(heading), math.sin(heading)
        change = np.eye(8)
        change[THETA, [TURN, CURVE]] = moved.theta, moved.x
        change[X] += -way * sin * (0.5 * (change[THETA] + np.eye(8)[THETA]))
        change[Y] += way * cos * (0.5 * (change[THETA] + np.eye(8)[THETA]))
        change[X, WAY], change[Y, WAY] = moved.x * cos, moved.x * sin
        state[X] += way * cos
        state[Y] += way * sin
        state[THETA] = normalize_angle(float(state[THETA]) + turn)
        covariance = change @ self._covariance @ change.T
        driven, turned = abs(moved.x), abs(moved.theta)
        covariance[X, X] += WAY_NOISE**2 * driven
        covariance[Y, Y] += WAY_NOISE**2 * driven
        covariance[THETA, THETA] += DRIVING_NOISE**2 * driven + TURNING_NOISE**2 * turned
        self._covariance = covariance

    # What the receivers see.

    def _clear_sights(self) -> None:
        self._sights = (Sight(), Sight(), Sight())
        self._light = Sight()

    def _read(self, reading: InfraredReading) -> None:
        ranges, stamp = ranges_of(reading), reading.stamp
        if self._state is None:
            self._consider(ranges, stamp)
            return
        view = self._view(stamp)
        seen = self._seen(ranges, view)
        if any(seen):
            self._strange.clear()
            self.seen_at = stamp
            self.count += 1
        elif self._consider(ranges, stamp) or None in seen:
            return  # the beacon may be in sight or not
        self._see_light(any(seen), stamp)
        if not any(seen) or view.distance < NEAREST:
            self._sights = (Sight(), Sight(), Sight())  # a light that goes out or on is no edge of a receiver's view
            return
        changes = [
            None if sees is None else sight.update(sees, stamp) for sight, sees in zip(self._sights, seen, strict=True)
        ]
        self._correct_distance([distance for distance, sees in zip(ranges, seen, strict=True) if sees], stamp)
        for direction, change in zip(self.receivers.directions, changes, strict=True):
            if change is not None and change.gap < FRESH:
                self._correct_edge(direction, change)
        settled = [sees if sees is sight.seen else None for sees, sight in zip(seen, self._sights, strict=True)]
        sector = find_sector(settled, self.receivers)
        if sector is not None:
            self._correct_sector(sector, stamp)

    def _seen(self, ranges: tuple[float, float, float], view: "_View") -> list[bool | None]:
        """Which receivers see the beacon; None if they see something else, so that nothing is known of the beacon."""
        far = RANGE_GATE + 4.0 * self._deviation(view.of_distance())
        aside = self.receivers.half + BEARING_GATE + 3.0 * self._deviation(view.of_bearing())
        seen: list[bool | None] = []
        for distance, direction in zip(ranges, self.receivers.directions, strict=True):
            if distance == math.inf:
                seen.append(False)
            elif abs(distance - view.distance) <= far and (
                view.distance < NEAREST or abs(normalize_angle(view.bearing - direction)) <= aside
            ):
                seen.append(True)
            else:
                seen.append(None)
        return seen

    def _see_light(self, lit: bool, stamp: float) -> None:
        view = self._view(stamp)
        outermost = self.receivers.infrared_receiver_angle + self.receivers.half
        if not lit and abs(view.bearing) > outermost - WELL_INSIDE - self._deviation(view.of_bearing()):
            return  # no wonder
        change = self._light.update(lit, stamp)
        if change is not None:
            self.crossings.append(Crossing(change.seen, self._view(change.stamp).line_of_sight, change.stamp))

    def _correct_distance(self, distances: list[float], stamp: float) -> None:
        view = self._view(stamp)
        mean = math.fsum(distances) / len(distances)
        self._innovate(view.of_distance(), mean - view.distance, self.receivers.infrared_range_noise**2, gate=math.inf)

    def _correct_edge(self, direction: float, change: Change) -> None:
        """A receiver has begun or ceased to see the beacon: its bearing was that of an edge of the receiver's view."""
        view = self._view(change.stamp)
        half = self.receivers.half
        error = normalize_angle(view.bearing - direction)
        innovation = math.copysign(half, error) - error
        before, after = self._view(change.before).bearing, self._view(change.after).bearing
        variance = BEARING_NOISE**2 + normalize_angle(after - before) ** 2 / 12.0
        self._innovate(view.of_bearing(), innovation, variance)

    def _correct_sector(self, sector: tuple[float, float], stamp: float) -> None:
        view = self._view(stamp)
        nearest = min(max(view.bearing, sector[0]), sector[1])
        innovation = normalize_angle(nearest - view.bearing)
        if abs(innovation) > SECTOR_NOISE:
            self._innovate(view.of_bearing(), innovation, SECTOR_NOISE**2, gate=math.inf)

    # Where the beacon was found, or found again.

    def _consider(self, ranges: tuple[float, float, float], stamp: float) -> bool:
        """Believe readings that agree among each other; says whether they do."""
        self._strange.append((stamp, ranges))
        recent = [seen for at, seen in self._strange if stamp - at <= 1.0]
        for distance in sorted(distance for distance in ranges if distance < math.inf):
            agreeing = [[abs(other - distance) <= SAME for other in seen] for seen in recent]
            if sum(map(any, agreeing)) >= AGREEING:
                sector = find_sector(agreeing[-1], self.receivers)  # the robot may turn: only the last one is of now
                if sector is not None:
                    self._begin(distance, sector, stamp)
                    return True
        return False

    def _begin(self, distance: float, sector: tuple[float, float], stamp: float) -> None:
        assert self._odometry is not None
        then = self._then(stamp)
        bearing, width = 0.5 * (sector[0] + sector[1]), sector[1] - sector[0]
        direction = then.theta + bearing
        receivers = Pose(-distance * math.cos(direction), -distance * math.sin(direction), then.theta)
        robot = receivers.compose(Pose(-self.receivers.infrared_receiver_x))
        now = robot.compose(self._odometry.relative_to(then))
        self._state = np.array(
            [now.x, now.y, now.theta, 1.0, 1.0, 0.0, direction, self.receivers.infrared_beacon_angle]
        )
        scale, curve = self.receivers.infrared_scale_error, self.receivers.infrared_curve_error
        self._covariance = np.diag([0.0, 0.0, 0.0, scale, scale, curve, 0.0, 0.0]) ** 2
        along = np.array([math.cos(direction), math.sin(direction)])
        across = np.array([-along[1], along[0]])
        deviation = distance * (width / math.sqrt(12.0) + SECTOR_NOISE)
        self._covariance[:2, :2] = self.receivers.infrared_range_noise**2 * np.outer(
            along, along
        ) + deviation**2 * np.outer(across, across)
        self.forget_axis()
        self._strange.clear()
        self.crossings.clear()
        self._clear_sights()
        self.count = 1
        self.seen_at = stamp

    # The filter.

    def _then(self, stamp: float) -> Pose:
        """The robot in odom at a moment."""
        assert self._odometry is not None
        try:
            return self._track.at(stamp).pose
        except LookupError:
            return self._odometry

    def _view(self, stamp: float) -> "_View":
        assert self._odometry is not None
        robot, then = self._pose, self._then(stamp).relative_to(self._odometry)
        seen_from = robot.compose(self.receivers.position(then))
        return _View(seen_from, seen_from.x - robot.x, seen_from.y - robot.y)

    def _deviation(self, gradient: Vector) -> float:
        return math.sqrt(max(0.0, float(gradient @ self._covariance @ gradient)))

    def _innovate(self, gradient: Vector, innovation: float, variance: float, gate: float = GATE) -> bool:
        """Correct the state by a measurement; says whether it was believed."""
        assert self._state is not None
        spread = self._covariance @ gradient
        total = float(gradient @ spread) + variance
        if innovation * innovation > gate * total:
            return False
        gain = spread / total
        self._state = self._state + gain * innovation
        self._covariance = self._covariance - np.outer(gain, spread)
        return True


class _View:
    """The beacon as the receivers see it, and how that depends on the state."""

    def __init__(self, receivers: Pose, lever_x: float, lever_y: float) -> None:
        self._x, self._y = receivers.x, receivers.y
        self._lever_x, self._lever_y = lever_x, lever_y
        self.distance = max(math.hypot(receivers.x, receivers.y), 1e-3)
        self.line_of_sight = math.atan2(-receivers.y, -receivers.x)
        self.bearing = normalize_angle(self.line_of_sight - receivers.theta)

    def of_distance(self) -> Vector:
        """The gradient of the distance."""
        return self._gradient(self._x / self.distance, self._y / self.distance)

    def of_line_of_sight(self) -> Vector:
        """The gradient of the direction to the beacon."""
        return self._gradient(-self._y / self.distance**2, self._x / self.distance**2)

    def of_bearing(self) -> Vector:
        """The gradient of the bearing."""
        gradient = self.of_line_of_sight()
        gradient[THETA] -= 1.0
        return gradient

    def _gradient(self, x: float, y: float) -> Vector:
        gradient = np.zeros(8)
        gradient[:3] = x, y, y * self._lever_x - x * self._lever_y
        return gradient
