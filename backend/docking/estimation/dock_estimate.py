"""Where the marker is, out of detections that are noisy, wrong, late or rare."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import Observation

POSITION_NOISE = 0.01
"""Standard deviation of a detection, in m, until it has been measured."""
DISTANCE_NOISE = 0.5
"""How much more it is for each m that the marker is away, as a fraction."""
ANGLE_NOISE = math.radians(1.5)
"""Standard deviation of a detection, in rad, until it has been measured."""
NOISE_LIMITS = (0.5, 8.0)
"""How many times these the measured noise may be."""
TRUST = 5
"""How many measurements of the noise the assumption counts as."""
MEASURED = 60
"""Detections from which the noise is measured: their median, since a third may be wrong."""
MEDIAN_2, MEDIAN_1 = 1.386, 0.455
"""Median of the sum of two squared standard normal variables, and of one."""

DRIFT = 0.01
"""How far odometry is off after 1 m, in m."""
TURN_DRIFT = 0.02
"""How much its heading is off after 1 m, or 2 rad of turning, in rad."""
YAW_BIAS = 0.2
"""How much odometry may misjudge the curvature of a way, in rad for each m: wheels that are not alike."""
TURN_SCALE = 0.05
"""How much it may misjudge a turn, as a fraction."""
CREEP = 0.002
"""How far, in m, and how much, in rad, a robot that stands still may be moved within 1 s, and nobody notices."""

GATE = 16.3
"""Squared distance, in standard deviations, of an outlier: one good detection in 1,000 (chi-square, 3 degrees)."""
BEGINNING = 5
"""Detections that the estimate begins with; most of them must agree."""
FEWEST, BEGINNING_TIME = 3, 2.0
"""So many are enough where they take more than so long, in s."""
RECENT, AGREEING = 8, 6
"""So many of the recent detections that agree on another pose prove that the robot, or the dock, was moved."""
FARTHEST = 30.0
"""In m; no marker is seen from farther away."""
LONGEST_PERIOD = 3.0
"""In s; a longer pause between two detections says nothing of the camera."""

X, Y, THETA, YAW, SCALE = range(5)
Matrix = list[list[float]]


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations of the docked pose, as seen from the robot.

    Attributes:
        lateral: To the side of it, in m.
        heading: Of its direction, in rad.
    """

    lateral: float = math.inf
    heading: float = math.inf


class DockEstimate:
    """An extended Kalman filter for the marker in base_link, and for the errors of odometry.

    The state has the marker's pose, and two errors that one can see only over a way: `YAW`, the curvature that odometry
    does not see, in rad/m, and `SCALE`, the fraction by which it misjudges a turn. Between detections, odometry says
    how the robot moved, and the marker becomes less certain. How noisy detections are is measured, from what they
    differ from the prediction by. Detections that are too far off are left out.

    Attributes:
        raw: The last detection in odom, whatever became of it.
        count: Detections that agreed, since the estimate began.
        seen_at: When the last of them was made.
        noticed_at: When the last detection was made, whatever became of it.
        period: Seconds between two detections, usually.
    """

    def __init__(self, memory: float) -> None:
        """Begin without a detection.

        Args:
            memory: How old a detection may be, in s.
        """
        self.raw: Pose | None = None
        self.count = 0
        self.seen_at = self.noticed_at = -math.inf
        self.period = 0.0
        self._memory = memory
        self._robot: Pose | None = None
        self._now = 0.0
        self._state: list[float] | None = None
        self._covariance: Matrix = []
        self._errors: tuple[float, float] = (0.0, 0.0)  # YAW and SCALE, which outlast a new beginning
        self._beginning: deque[tuple[float, Pose]] = deque(maxlen=BEGINNING)
        self._recent: deque[Pose] = deque(maxlen=RECENT)  # in odom: what they were off by
        self._periods: deque[float] = deque(maxlen=7)
        self._position_noise: deque[float] = deque(maxlen=MEASURED)
        self._angle_noise: deque[float] = deque(maxlen=MEASURED)
        self._scales = self._assumed = (1.0, 1.0)  # measured variances, in assumed ones; largest since the beginning

    @property
    def pose(self) -> Pose | None:
        """Of the marker in odom; None before it is known."""
        if self._state is None or self._robot is None:
            return None
        return self._robot.compose(Pose(self._state[X], self._state[Y], normalize_angle(self._state[THETA])))

    @property
    def yaw_bias(self) -> float:
        """The curvature of the way, in rad/m, that odometry does not see."""
        return self._errors[0] if self._state is None else self._state[YAW]

    def spread(self, docked: Pose) -> Spread:
        """How well the docked pose is known.

        Args:
            docked: base_link in the marker's frame.
        """
        if self._state is None:
            return Spread()
        p, heading = self._covariance, self._state[THETA]
        sin, cos, lever = math.sin(heading), math.cos(heading), docked.x
        across = sin * sin * p[X][X] - 2.0 * sin * cos * p[X][Y] + cos * cos * p[Y][Y]
        lateral = across + 2.0 * lever * (cos * p[Y][THETA] - sin * p[X][THETA]) + lever * lever * p[THETA][THETA]
        return Spread(math.sqrt(max(0.0, lateral)), math.sqrt(p[THETA][THETA]))

    def update(self, observation: Observation) -> None:
        """Take over what is new: the way since the last time, and a detection."""
        odometry, marker = observation.odometry, observation.marker
        if odometry is None or not odometry.pose.finite:
            return
        self._predict(odometry.pose, observation.now)
        if (
            marker is not None
            and marker.pose.finite
            and odometry.pose.distance_to(marker.pose) < FARTHEST
            and marker.stamp > self.noticed_at
            and abs(observation.now - marker.stamp) <= self._memory
        ):
            self._learn_period(marker.stamp)
            self.raw = marker.pose
            if self._state is None:
                self._begin(marker.pose, odometry.pose, marker.stamp)
            else:
                self._correct(self._state, marker.pose, odometry.pose, marker.stamp)

    def _learn_period(self, stamp: float) -> None:
        pause, self.noticed_at = stamp - self.noticed_at, stamp
        if pause < LONGEST_PERIOD:
            self._periods.append(pause)
            self.period = median(self._periods)

    def forget(self) -> None:
        """Begin again with the next detections; what was learned of odometry and noise is kept."""
        if self._state is not None:
            self._errors = (self._state[YAW], self._state[SCALE])
        self._state = None
        self.count = 0
        self._beginning.clear()

    # The robot moves.

    def _predict(self, robot: Pose, now: float) -> None:
        last, dt = self._robot, max(0.0, now - self._now)
        self._robot, self._now = robot, now
        state = self._state
        if last is None or state is None:
            return
        p = self._covariance
        moved = robot.relative_to(last)
        way = math.hypot(moved.x, moved.y)
        if way > 0.0 or moved.theta != 0.0:
            turn = (1.0 + state[SCALE]) * moved.theta + state[YAW] * moved.x
            cos, sin = math.cos(turn), math.sin(turn)
            x, y = state[X] - moved.x, state[Y] - moved.y
            state[X], state[Y], state[THETA] = cos * x + sin * y, cos * y - sin * x, state[THETA] - turn
            by_turn = (state[Y], -state[X], -1.0)  # what a turn that odometry did not see does
            change = [
                [cos, sin, 0.0, by_turn[X] * moved.x, by_turn[X] * moved.theta],
                [-sin, cos, 0.0, by_turn[Y] * moved.x, by_turn[Y] * moved.theta],
                [0.0, 0.0, 1.0, -moved.x, -moved.theta],
                [0.0, 0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 0.0, 1.0],
            ]
            p = _times(_times(change, p), [list(column) for column in zip(*change, strict=True)])
            turned = TURN_DRIFT**2 * (way + 0.5 * abs(moved.theta))
            for row in (X, Y, THETA):
                for column in (X, Y, THETA):
                    p[row][column] += by_turn[row] * by_turn[column] * turned
            p[X][X] += DRIFT**2 * way
            p[Y][Y] += DRIFT**2 * way
            self._covariance = p
        for axis in (X, Y, THETA):
            p[axis][axis] += CREEP**2 * dt

    # The marker is seen.

    def _noise(self, distance: float) -> tuple[float, float]:
        """Variances of a coordinate and of the angle."""
        usual = POSITION_NOISE * (1.0 + DISTANCE_NOISE * distance)
        return usual**2 * self._scales[0], ANGLE_NOISE**2 * self._scales[1]

    def _begin(self, seen: Pose, robot: Pose, stamp: float) -> None:
        """Collect detections, until enough of them agree."""
        self._beginning.append((stamp, seen))
        known, first = [one for _, one in self._beginning], self._beginning[0][0]
        if len(known) < BEGINNING and (len(known) < FEWEST or stamp - first < BEGINNING_TIME):
            return
        middle = _median(known)
        self._scales = (NOISE_LIMITS[1] ** 2,) * 2
        noise = self._noise(robot.distance_to(middle))
        agreeing = [one for one in known if _distance(_off(one, middle), noise) < 0.5 * GATE]
        self._scales = (1.0, 1.0)
        if 2 * len(agreeing) <= len(known):
            return
        middle = _median(agreeing)
        for one in agreeing:
            self._learn_noise(_off(one, middle), robot.distance_to(middle))
        self._beginning.clear()
        self._restart(middle, robot, len(agreeing), stamp)

    def _restart(self, marker: Pose, robot: Pose, agreed: int, stamp: float) -> None:
        seen = marker.relative_to(robot)
        if self._state is not None:
            self._errors = (self._state[YAW], self._state[SCALE])
        self._state = [seen.x, seen.y, seen.theta, *self._errors]
        position, angle = (1.6 * noise / agreed for noise in self._noise(robot.distance_to(marker)))
        variances = (position, position, angle, YAW_BIAS**2, TURN_SCALE**2)
        self._covariance = [
            [value if row == column else 0.0 for column in range(5)] for row, value in enumerate(variances)
        ]
        self._assumed = self._scales
        self._recent.clear()
        self.count = agreed
        self.seen_at = stamp

    def _correct(self, state: list[float], marker: Pose, robot: Pose, stamp: float) -> None:
        seen, p = marker.relative_to(robot), self._covariance
        distance = math.hypot(seen.x, seen.y)
        off = (seen.x - state[X], seen.y - state[Y], normalize_angle(seen.theta - state[THETA]))
        position, angle = self._noise(distance)
        spread = (p[X][X] + position, p[Y][Y] + position, p[THETA][THETA] + angle)
        known = (position / spread[X], position / spread[Y], angle / spread[THETA])
        self._learn_noise(Pose(*(one * math.sqrt(part) for one, part in zip(off, known, strict=True))), distance)
        turned = Pose(0.0, 0.0, robot.theta).compose(Pose(off[X], off[Y]))
        self._recent.append(Pose(turned.x, turned.y, off[THETA]))
        error = self._moved((position, angle), (max(spread[:2]), spread[THETA]))
        here = self.pose
        if error is not None and here is not None:
            moved = Pose(here.x + error.x, here.y + error.y, normalize_angle(here.theta + error.theta))
            self._restart(moved, robot, AGREEING, stamp)
            return
        if sum(one * one / variance for one, variance in zip(off, spread, strict=True)) > GATE:
            return
        for axis, noise in ((X, position), (Y, position), (THETA, angle)):
            _take(state, p, axis, (seen.x, seen.y, seen.theta)[axis], noise)
        self.count += 1
        self.seen_at = stamp

    def _moved(self, noise: tuple[float, float], spread: tuple[float, float]) -> Pose | None:
        """How far the marker has been moved; None if it has not."""
        if len(self._recent) < RECENT:
            return None
        error = _median(self._recent)
        share = math.pi / 2.0 / AGREEING  # the variance of a median, as a part of that of one
        if _distance(error, (share * spread[0], share * spread[1])) < GATE:
            return None
        agreeing = sum(_distance(_off(one, error), noise) < GATE for one in self._recent)
        return error if agreeing >= AGREEING else None

    def _learn_noise(self, off: Pose, distance: float) -> None:
        usual = POSITION_NOISE * (1.0 + DISTANCE_NOISE * distance)
        self._position_noise.append((off.x**2 + off.y**2) / usual**2 / MEDIAN_2)
        self._angle_noise.append((off.theta / ANGLE_NOISE) ** 2 / MEDIAN_1)
        low, high = NOISE_LIMITS[0] ** 2, NOISE_LIMITS[1] ** 2
        number = len(self._position_noise)
        position, angle = (
            min(high, max(low, (TRUST + number * median(measured)) / (TRUST + number)))
            for measured in (self._position_noise, self._angle_noise)
        )
        self._scales = (position, angle)
        self._doubt()

    def _doubt(self) -> None:
        """Be less certain where detections are noisier than was assumed: so are the earlier ones."""
        growth = [max(1.0, now / assumed) for now, assumed in zip(self._scales, self._assumed, strict=True)]
        self._assumed = (self._assumed[0] * growth[0], self._assumed[1] * growth[1])
        if self._state is not None and max(growth) > 1.0:
            factors = (math.sqrt(growth[0]), math.sqrt(growth[0]), math.sqrt(growth[1]), 1.0, 1.0)
            for factor, row in zip(factors, self._covariance, strict=True):
                row[:] = [factor * other * value for other, value in zip(factors, row, strict=True)]


def _take(state: list[float], p: Matrix, axis: int, measured: float, noise: float) -> None:
    """Take over one measured coordinate."""
    error = measured - state[axis]
    if axis == THETA:
        error = normalize_angle(error)
    spread = p[axis][axis] + noise
    gains, row = [line[axis] / spread for line in p], list(p[axis])
    for index, gain in enumerate(gains):
        state[index] += gain * error
        line = p[index]
        for column in range(5):
            line[column] -= gain * row[column]


def _times(left: Matrix, right: Matrix) -> Matrix:
    columns = list(zip(*right, strict=True))
    return [[sum(a * b for a, b in zip(row, column, strict=True)) for column in columns] for row in left]


def _off(one: Pose, other: Pose) -> Pose:
    return Pose(one.x - other.x, one.y - other.y, normalize_angle(one.theta - other.theta))


def _distance(off: Pose, noise: tuple[float, float]) -> float:
    """Squared, in standard deviations."""
    return (off.x**2 + off.y**2) / noise[0] + off.theta**2 / noise[1]


def _median(poses: Sequence[Pose]) -> Pose:
    """Of each coordinate."""
    first = poses[0].theta
    theta = first + median(normalize_angle(pose.theta - first) for pose in poses)
    return Pose(median(pose.x for pose in poses), median(pose.y for pose in poses), normalize_angle(theta))
