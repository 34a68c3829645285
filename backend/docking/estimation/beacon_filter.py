"""Estimates the pose of the infrared beacon from the readings of three receivers."""

import math
from collections import deque
from dataclasses import dataclass

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import InfraredReading, Observation
from docking.estimation.beacon_state import UNKNOWN, BeaconState, View
from docking.estimation.receivers import Change, Sight, find_sector, ranges_of
from docking.estimation.repetition import RepeatedRanges
from docking.estimation.track import Track
from docking.parameters import Receivers

FRESH = 0.3
"""How old a reading may be when it arrives, in s."""
WELL_INSIDE = 0.05
"""How far from the edge of what the receivers see, beyond a standard deviation, in rad, the beacon must be in sight."""
NEAREST = 0.1
"""From the receivers to the beacon, in m: nearer than that, a bearing says little and the receivers see differently."""
AGREEING = 5
"""Readings out of the last `REMEMBERED` that must agree on a distance for the beacon to be where they say."""
REMEMBERED = 8
LATEST = 3
"""The last ones of them, which say in which direction it is: the robot may turn."""
SAME = 0.08
"""How much distances may differ that agree, in m."""

RANGE_GATE = 0.1
"""Beyond 4 standard deviations of the estimate, in m: a reading farther off is no distance to the beacon."""
BEARING_NOISE = 0.012
"""Standard deviation of the direction of the edge of a receiver's view, in rad."""
BEARING_GATE = 0.15
"""Beyond 3 standard deviations of the estimate, in rad: a receiver does not see that far beyond its view."""
SECTOR_NOISE = 0.05
"""Standard deviation of a bearing, in rad, that is known only by the receivers which see the beacon."""


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

    The lateral error to the dock's axis cannot be measured from the beacon alone: it looks the same from all sides.
    But it shines only so far to each side. Where the robot crosses an edge of its light, the axis is known.

    Readings that fit neither the estimate nor each other (ghosts) are ignored; `AGREEING` that fit each other, but not
    the estimate, mean that the robot or the dock was moved.

    Attributes:
        seen_at: When the beacon was seen last.
        heard_at: When the last reading that was used was made, whatever it saw.
        count: Readings that saw the beacon.
        repeated: Whether the receivers repeat a reading: it is not used.
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
        self.repeated = RepeatedRanges()
        self._track = Track()
        self._waiting: deque[InfraredReading] = deque()  # until odometry of their moments has arrived
        self._odometry: Pose | None = None
        self._state: BeaconState | None = None
        self._strange: deque[tuple[float, tuple[float, float, float]]] = deque(maxlen=REMEMBERED)
        self._off = 0  # readings in a row whose distance is another one than expected
        self._clear_sights()

    # The estimate.

    @property
    def known(self) -> bool:
        """Whether the beacon was found."""
        return self._state is not None

    @property
    def position(self) -> Pose | None:
        """Of the beacon in odom, not turned; None before it was seen."""
        if self._state is None or self._odometry is None:
            return None
        seen = self._odometry.compose(self._state.robot.inverse())
        return Pose(seen.x, seen.y)

    @property
    def axis(self) -> float | None:
        """The way into the dock, in rad in odom; None before an edge is known."""
        if self._state is None or self._odometry is None or not self.edges:
            return None
        return normalize_angle(self._odometry.theta + self._state.axis)

    @property
    def axis_error(self) -> float:
        """Standard deviation of the robot's angle off the dock's axis, in rad."""
        if self._state is None or not self.edges:
            return UNKNOWN
        return self._state.axis_error(self._view(self._state, self.heard_at))

    def line_of_sight(self, receivers: Pose) -> float:
        """The direction to the beacon, in rad in odom."""
        position = self.position
        assert position is not None
        return math.atan2(position.y - receivers.y, position.x - receivers.x)

    def bearing(self, robot: Pose) -> float:
        """Return how far to the left of straight ahead the beacon is, in rad."""
        return normalize_angle(self.line_of_sight(self.receivers.position(robot)) - robot.theta)

    def distance(self, robot: Pose) -> float:
        """From the receivers to the beacon, in m."""
        position = self.position
        assert position is not None
        return self.receivers.position(robot).distance_to(position)

    @property
    def angle(self) -> float:
        """The direction to the beacon, in rad in the filter's frame: it does not drift as odometry does."""
        assert self._state is not None
        return self._view(self._state, self.heard_at).line_of_sight

    @property
    def lit(self) -> bool:
        """Whether the receivers are in the light."""
        return self._light.seen is True

    # What comes in.

    def update(self, observation: Observation) -> None:
        """Update with odometry and a new reading."""
        odometry, reading = observation.odometry, observation.infrared
        if odometry is None or not odometry.pose.finite:
            return
        self._track.add(odometry.stamp, odometry)
        last, self._odometry = self._odometry, odometry.pose
        if self._state is not None and last is not None:
            self._state.move(odometry.pose.relative_to(last))
        if (
            reading is not None
            and self._is_new(reading, observation.now)
            and not self.repeated.check(reading, odometry.pose)
        ):
            self._waiting.append(reading)
        while self._waiting and self._waiting[0].stamp <= odometry.stamp:
            reading = self._waiting.popleft()
            self._take(ranges_of(reading), reading.stamp)

    def _is_new(self, reading: InfraredReading, now: float) -> bool:
        newest = self._waiting[-1].stamp if self._waiting else self.heard_at
        return (
            not math.isnan(reading.left + reading.center + reading.right)
            and reading.stamp > newest
            and abs(now - reading.stamp) <= FRESH
        )

    def _take(self, ranges: tuple[float, float, float], stamp: float) -> None:
        if stamp - self.heard_at > FRESH:
            self._clear_sights()
        self.heard_at = stamp
        if self._state is None:
            self._consider(ranges, stamp)
        else:
            self._read(self._state, ranges, stamp)

    def confirm_edge(self, side: int, line_of_sight: float) -> None:
        """An edge of the light was crossed.

        Args:
            side: Which one, as in `edges`.
            line_of_sight: The direction to the beacon there, in rad in the filter's frame, some moments ago.
        """
        assert self._state is not None
        view = self._view(self._state, self.heard_at)
        if not self._state.correct_axis(view, side, line_of_sight):
            # One of the two was no edge. This one has just been looked at more than once.
            self.forget_axis()
            self._state.correct_axis(view, side, line_of_sight, gate=math.inf)
        self.edges.add(side)

    def forget_axis(self) -> None:
        """Know no edge of the light, and so not the dock's axis."""
        assert self._state is not None
        self._state.forget_axis()
        self.edges.clear()

    # What the receivers see.

    def _clear_sights(self) -> None:
        self._sights = (Sight(), Sight(), Sight())
        self._light = Sight()

    def _read(self, state: BeaconState, ranges: tuple[float, float, float], stamp: float) -> None:
        view = self._view(state, stamp)
        seen = self._seen(state, ranges, view)
        if any(seen):
            self._strange.clear()
            self.seen_at = stamp
            self.count += 1
        elif self._consider(ranges, stamp) or None in seen:
            return  # the beacon may be in sight or not
        self._see_light(state, any(seen), stamp)
        if any(seen):
            distances = [distance for distance, sees in zip(ranges, seen, strict=True) if sees]
            self._correct_distance(state, math.fsum(distances) / len(distances), view)
        if not any(seen) or view.distance < NEAREST:
            self._sights = (Sight(), Sight(), Sight())  # a light that goes out or on is no edge of a receiver's view
            return
        changes = [
            None if sees is None else sight.update(sees, stamp) for sight, sees in zip(self._sights, seen, strict=True)
        ]
        for direction, change in zip(self.receivers.directions, changes, strict=True):
            if change is not None and change.gap < FRESH:
                self._correct_edge(state, direction, change)
        settled = [sees if sees is sight.seen else None for sees, sight in zip(seen, self._sights, strict=True)]
        sector = find_sector(settled, self.receivers)
        if sector is not None:
            self._correct_sector(state, sector, stamp)
        if not state.plausible:  # it began with a wrong bearing
            self._state = None
            self.edges.clear()

    def _seen(self, state: BeaconState, ranges: tuple[float, float, float], view: View) -> list[bool | None]:
        """Return which receivers see the beacon; None if they see something else, which says nothing of the beacon."""
        far = RANGE_GATE + 4.0 * state.deviation(view.of_distance())
        widest = self.receivers.half + BEARING_GATE + 3.0 * state.deviation(view.of_bearing())
        seen: list[bool | None] = []
        for distance, direction in zip(ranges, self.receivers.directions, strict=True):
            if distance == math.inf:
                seen.append(False)
            elif abs(distance - view.distance) <= far and (
                view.distance < NEAREST or abs(normalize_angle(view.bearing - direction)) <= widest
            ):
                seen.append(True)
            else:
                seen.append(None)
        return seen

    def _see_light(self, state: BeaconState, lit: bool, stamp: float) -> None:
        view = self._view(state, stamp)
        outermost = self.receivers.infrared_receiver_angle + self.receivers.half
        if not lit and abs(view.bearing) > outermost - WELL_INSIDE - state.deviation(view.of_bearing()):
            return  # no wonder
        change = self._light.update(lit, stamp)
        if change is not None:
            self.crossings.append(Crossing(change.seen, self._view(state, change.stamp).line_of_sight, change.stamp))

    def _correct_distance(self, state: BeaconState, distance: float, view: View) -> None:
        """Correct the distance. If it is not the expected one for some readings, the robot was pushed."""
        off = abs(distance - view.distance)
        self._off = self._off + 1 if off > 2.0 * self.receivers.infrared_range_noise else 0
        state.correct_distance(view, distance, pushed=off if self._off >= AGREEING else 0.0)

    def _correct_edge(self, state: BeaconState, direction: float, change: Change) -> None:
        """Correct by a change of a receiver: when it starts or stops seeing the beacon, that is at its edge of view."""
        view = self._view(state, change.stamp)
        half = self.receivers.half
        error = normalize_angle(view.bearing - direction)
        innovation = math.copysign(half, error) - error
        before, after = self._view(state, change.before).bearing, self._view(state, change.after).bearing
        variance = BEARING_NOISE**2 + normalize_angle(after - before) ** 2 / 12.0
        state.correct(view.of_bearing(), innovation, variance)

    def _correct_sector(self, state: BeaconState, sector: tuple[float, float], stamp: float) -> None:
        view = self._view(state, stamp)
        nearest = min(max(view.bearing, sector[0]), sector[1])
        innovation = normalize_angle(nearest - view.bearing)
        if abs(innovation) > SECTOR_NOISE:
            state.correct(view.of_bearing(), innovation, SECTOR_NOISE**2, gate=math.inf)

    # Where the beacon was found, or found again.

    def _consider(self, ranges: tuple[float, float, float], stamp: float) -> bool:
        """Believe readings that agree among each other; says whether they do."""
        self._strange.append((stamp, ranges))
        recent = [seen for at, seen in self._strange if stamp - at <= 1.0]
        for distance in sorted(distance for distance in ranges if distance < math.inf):
            agreeing = [[abs(other - distance) <= SAME for other in seen] for seen in recent]
            if sum(map(any, agreeing)) >= AGREEING:
                seen = [2 * sum(column) > LATEST for column in zip(*agreeing[-LATEST:], strict=True)]
                sector = find_sector(seen, self.receivers)
                if sector is not None:
                    self._begin(distance, sector, stamp)
                    return True
        return False

    def _begin(self, distance: float, sector: tuple[float, float], stamp: float) -> None:
        assert self._odometry is not None
        then = self._then(stamp)
        bearing, width = 0.5 * (sector[0] + sector[1]), sector[1] - sector[0]
        deviation = width / math.sqrt(12.0) + SECTOR_NOISE
        self._state = BeaconState(self.receivers, then.theta, bearing, deviation, distance)
        self._state.move(self._odometry.relative_to(then))
        self.edges.clear()
        self._strange.clear()
        self.crossings.clear()
        self._clear_sights()
        self.count = 1
        self.seen_at = stamp

    def _then(self, stamp: float) -> Pose:
        """The robot in odom at a moment."""
        assert self._odometry is not None
        try:
            return self._track.at(stamp).pose
        except LookupError:
            return self._odometry

    def _view(self, state: BeaconState, stamp: float) -> View:
        """The beacon as it was seen at a moment."""
        assert self._odometry is not None
        return state.view(self._then(stamp).relative_to(self._odometry))
