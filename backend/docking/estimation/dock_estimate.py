"""Estimates the marker's pose from detections that are noisy, wrong, late or rare."""

import math
from collections import deque
from dataclasses import dataclass
from statistics import median

import numpy as np
import numpy.typing as npt

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import MarkerDetection, Observation
from docking.estimation.detection_noise import DetectionNoise, most
from docking.estimation.flat_marker import FlatMarker
from docking.estimation.marker_selection import MarkerSelection
from docking.estimation.poses import difference, median_pose, squared_distance
from docking.estimation.seen_motion import SeenMotion

DRIFT = 0.01
"""How far odometry is off after 1 m, in m."""
TURN_DRIFT = 0.02
"""How much its heading is off after 1 m, or 2 rad of turning, in rad."""
YAW_BIAS = 0.2
"""How much odometry may misjudge the curvature of a way, in rad for each m: wheels that are not alike."""
TURN_SCALE = 0.05
"""How much it may misjudge a turn, as a fraction."""
CREEP = 0.002
"""How far, in m, and how much, in rad, a robot that stands still may move within 1 s without odometry noticing."""

GATE = 16.3
"""Squared distance, in standard deviations, of an outlier: one good detection in 1,000 (chi-square, 3 degrees)."""
BEGINNING = 5
"""Detections that the estimate begins with; most of them must agree."""
FEWEST, BEGINNING_TIME = 3, 2.0
"""FEWEST are enough once they span BEGINNING_TIME, in s."""
RECENT, AGREEING = 8, 6
"""If AGREEING of the last RECENT detections agree on another pose, the robot or the dock was moved."""
FARTHEST = 30.0
"""In m; no marker is seen from farther away."""
DISPUTING = 2
"""Detections in a row that were left out and agree with each other: the robot or the dock may have been moved."""
LONGEST_PERIOD = 3.0
"""In s; a longer pause between two detections is a gap, not the camera's period."""

X, Y, THETA, YAW, SCALE = range(5)
POSITION, POSE = (X, Y), (X, Y, THETA)
Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations of the docked pose, as seen from the robot.

    Attributes:
        lateral: To the side of it, in m.
        heading: Of its direction, in rad.
    """

    lateral: float = math.inf
    heading: float = math.inf

    def within(self, limit: "Spread") -> bool:
        """Whether neither is more than that of `limit`."""
        return self.lateral <= limit.lateral and self.heading <= limit.heading


class DockEstimate:
    """An extended Kalman filter for the marker in base_link, and for the errors of odometry.

    The state has the marker's pose, and two errors that show only while the robot moves: `YAW`, the curvature that
    odometry does not see, in rad/m, and `SCALE`, the fraction by which it misjudges a turn. Between detections,
    odometry says how the robot moved, and the marker becomes less certain. The noise of detections is estimated from
    how far they are from the prediction. Detections that are too far off are left out.

    Attributes:
        raw: The last detection in odom, even if it was left out.
        count: Detections that agreed, since the estimate began.
        seen_at: When the last of them was made.
        noticed_at: When the last detection was made, even if it was left out.
        period: Seconds between two detections, usually.
        selection: Which detections are of the dock's marker.
        flat: Whether their headings are mirrored.
        motion: Whether the marker is seen to move as the robot drives.
    """

    def __init__(self, memory: float) -> None:
        """Start without a detection.

        Args:
            memory: How old a detection may be, in s.
        """
        self.raw: Pose | None = None
        self.count = 0
        self.seen_at = self.noticed_at = -math.inf
        self.period = 0.0
        self.selection = MarkerSelection()
        self.flat = FlatMarker()
        self.motion = SeenMotion()
        self._memory = memory
        self._newest = -math.inf
        self._at_newest: list[Pose] = []  # detections with that stamp
        self._robot: Pose | None = None
        self._now = 0.0
        self._state: Array | None = None
        self._covariance: Array = np.zeros((5, 5))
        self._errors: tuple[float, float] = (0.0, 0.0)  # YAW and SCALE, which outlast a new beginning
        self._beginning: deque[tuple[float, Pose]] = deque(maxlen=BEGINNING)
        self._recent: deque[Pose] = deque(maxlen=RECENT)  # how far from the estimate, turned into odom
        self._left_out: deque[Pose] = deque(maxlen=DISPUTING)  # since the last detection that agreed, as `_recent`
        self._periods: deque[float] = deque(maxlen=7)
        self._noise = DetectionNoise()

    @property
    def pose(self) -> Pose | None:
        """Of the marker in odom; None before it is known."""
        if self._state is None or self._robot is None:
            return None
        x, y, theta = self._state[:3].tolist()
        return self._robot.compose(Pose(x, y, normalize_angle(theta)))

    @property
    def yaw_bias(self) -> float:
        """The curvature of the way, in rad/m, that odometry does not see."""
        return self._errors[0] if self._state is None else float(self._state[YAW])

    @property
    def disputed(self) -> bool:
        """Whether the last detections were left out, but agree with each other."""
        if len(self._left_out) < DISPUTING or self._state is None:
            return False
        position, angle = self._noise.variances(math.hypot(*self._state[:2].tolist()))
        first, *others = self._left_out
        return all(squared_distance(difference(one, first), (2.0 * position, 2.0 * angle)) < GATE for one in others)

    def spread(self, docked: Pose) -> Spread:
        """Return the spread of the docked pose.

        Args:
            docked: base_link in the marker's frame.
        """
        if self._state is None:
            return Spread()
        p, heading = self._covariance[:3, :3], float(self._state[THETA])
        across = np.array((-math.sin(heading), math.cos(heading), docked.x))
        return Spread(math.sqrt(max(0.0, float(across @ p @ across))), math.sqrt(p[THETA, THETA]))

    def update(self, observation: Observation) -> None:
        """Update with the motion since the last time, and with a detection."""
        odometry = observation.odometry
        if odometry is None or not odometry.pose.finite:
            return
        self._predict(odometry.pose, observation.now)
        self.motion.drive(odometry.stamp, odometry.pose)
        for marker in (*observation.other_markers, observation.marker):
            if marker is not None and self._is_new(marker, odometry.pose, observation.now):
                self._take(marker, odometry.pose)

    def _is_new(self, marker: MarkerDetection, robot: Pose, now: float) -> bool:
        """Whether a detection makes sense and was not taken before; several may have one stamp."""
        if (
            not marker.pose.finite
            or robot.distance_to(marker.pose) >= FARTHEST
            or not abs(now - marker.stamp) <= self._memory
        ):
            return False
        if marker.stamp > self._newest:
            self._newest, self._at_newest = marker.stamp, []
        elif marker.stamp < self._newest or marker.pose in self._at_newest:
            return False
        self._at_newest.append(marker.pose)
        return True

    def _take(self, marker: MarkerDetection, robot: Pose) -> None:
        placed = self.motion.place(marker.pose, marker.stamp)
        if not self.selection.takes(placed, robot, self.pose):
            return
        if not self.motion.believes(marker.pose, marker.stamp):
            self.forget()
            return
        self._learn_period(marker.stamp)
        self.raw, changed = self.flat.correct(placed, marker.camera or robot, robot, self.pose)
        if changed:
            self._start_again()
        if self._state is None:
            self._begin(self.raw, robot, marker.stamp)
        else:
            self._correct(self._state, self.raw, robot, marker.stamp)

    def _learn_period(self, stamp: float) -> None:
        pause, self.noticed_at = stamp - self.noticed_at, stamp
        if 0.0 < pause < LONGEST_PERIOD:
            self._periods.append(pause)
            self.period = median(self._periods)

    def forget(self) -> None:
        """Begin again with the next detections; what was learned of odometry and noise is kept."""
        self._let_go()
        self.count = 0
        self.selection.forget()

    def _let_go(self) -> None:
        if self._state is not None:
            self._errors = (float(self._state[YAW]), float(self._state[SCALE]))
        self._state = None
        self._beginning.clear()
        self._left_out.clear()

    def _start_again(self) -> None:
        """The headings of earlier detections were wrong, and so are the estimate and the noise."""
        self._let_go()
        self._noise.forget()

    # The robot moves.

    def _predict(self, robot: Pose, now: float) -> None:
        last, dt = self._robot, max(0.0, now - self._now)
        self._robot, self._now = robot, now
        state = self._state
        if last is None or state is None:
            return
        moved = robot.relative_to(last)
        way = math.hypot(moved.x, moved.y)
        if way > 0.0 or moved.theta != 0.0:
            turn = (1.0 + state[SCALE]) * moved.theta + state[YAW] * moved.x
            cos, sin = math.cos(turn), math.sin(turn)
            change = np.eye(5)
            change[:2, :2] = (cos, sin), (-sin, cos)
            state[:2] = change[:2, :2] @ (state[X] - moved.x, state[Y] - moved.y)
            state[THETA] -= turn
            by_turn = np.array((state[Y], -state[X], -1.0))  # d pose / d turn that odometry missed
            change[:3, YAW], change[:3, SCALE] = by_turn * moved.x, by_turn * moved.theta
            p = self._covariance = change @ self._covariance @ change.T
            p[:3, :3] += np.outer(by_turn, by_turn) * TURN_DRIFT**2 * (way + 0.5 * abs(moved.theta))
            p[POSITION, POSITION] += DRIFT**2 * way
        self._covariance[POSE, POSE] += CREEP**2 * dt

    # The marker is seen.

    def _begin(self, seen: Pose, robot: Pose, stamp: float) -> None:
        """Collect detections, until enough of them agree."""
        self._beginning.append((stamp, seen))
        known, first = [one for _, one in self._beginning], self._beginning[0][0]
        if len(known) < BEGINNING and (len(known) < FEWEST or stamp - first < BEGINNING_TIME):
            return
        middle = median_pose(known)
        noise = most(robot.distance_to(middle))
        agreeing = [one for one in known if squared_distance(difference(one, middle), noise) < 0.5 * GATE]
        if 2 * len(agreeing) <= len(known):
            return
        middle = median_pose(agreeing)
        for one in agreeing:
            self._learn_noise(difference(one, middle), robot.distance_to(middle))
        self._beginning.clear()
        self._restart(middle, robot, len(agreeing), stamp)

    def _restart(self, marker: Pose, robot: Pose, agreed: int, stamp: float) -> None:
        seen = marker.relative_to(robot)
        if self._state is not None:
            self._errors = (float(self._state[YAW]), float(self._state[SCALE]))
        self._state = np.array((seen.x, seen.y, seen.theta, *self._errors))
        position, angle = (1.6 * noise / agreed for noise in self._noise.variances(robot.distance_to(marker)))
        self._covariance = np.diag((position, position, angle, YAW_BIAS**2, TURN_SCALE**2))
        self._noise.begin()
        self._recent.clear()
        self._left_out.clear()
        self.count = agreed
        self.seen_at = stamp

    def _correct(self, state: Array, marker: Pose, robot: Pose, stamp: float) -> None:
        seen, p = marker.relative_to(robot), self._covariance
        distance = math.hypot(seen.x, seen.y)
        off = difference(seen, Pose(*state[:3].tolist()))
        innovation = np.array((off.x, off.y, off.theta))
        position, angle = self._noise.variances(distance)
        noise = np.array((position, position, angle))
        spread = p.diagonal()[:3] + noise
        share = np.sqrt(noise / spread)  # the part of the difference that is due to noise
        self._learn_noise(Pose(*(share * innovation).tolist()), distance)
        turned = Pose(0.0, 0.0, robot.theta).compose(Pose(off.x, off.y))
        self._recent.append(Pose(turned.x, turned.y, off.theta))
        error = self._moved((position, angle), (float(max(spread[:2])), float(spread[THETA])))
        here = self.pose
        if error is not None and here is not None:
            moved = Pose(here.x + error.x, here.y + error.y, normalize_angle(here.theta + error.theta))
            self._restart(moved, robot, AGREEING, stamp)
            return
        if float(innovation**2 @ (1.0 / spread)) > GATE:
            self._left_out.append(self._recent[-1])
            return
        self._left_out.clear()
        gain = np.linalg.solve(p[:3, :3] + np.diag(noise), p[:3]).T
        state += gain @ innovation
        self._covariance = p - gain @ p[:3]
        self.count += 1
        self.seen_at = stamp

    def _moved(self, noise: tuple[float, float], spread: tuple[float, float]) -> Pose | None:
        """Return how far the marker has been moved; None if it has not."""
        if len(self._recent) < RECENT:
            return None
        error = median_pose(self._recent)
        share = math.pi / 2.0 / AGREEING  # variance of the median of n values: π/2n of that of one
        if squared_distance(error, (share * spread[0], share * spread[1])) < GATE:
            return None
        agreeing = sum(squared_distance(difference(one, error), noise) < GATE for one in self._recent)
        return error if agreeing >= AGREEING else None

    def _learn_noise(self, off: Pose, distance: float) -> None:
        growth = self._noise.learn(off, distance)
        if self._state is not None and max(growth) > 1.0:
            factors = np.sqrt((growth[0], growth[0], growth[1], 1.0, 1.0))
            self._covariance *= np.outer(factors, factors)
