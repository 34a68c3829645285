"""Where the marker is, out of detections that are noisy, wrong or missing."""

import math

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import Observation

POSITION_NOISE = 0.01
"""Standard deviation of a detection, in m, and for each m that the marker is away, in m."""
DISTANCE_NOISE = 0.005
ANGLE_NOISE = math.radians(1.5)
"""Standard deviation of a detection, in rad."""
DRIFT = 0.01
"""How far odometry is off after 1 m, in m."""
TURN_DRIFT = 0.03
"""How much its heading is off after 1 m, or 2 rad of turning, in rad."""
GATE = 16.3
"""Squared distance, in standard deviations, of an outlier: one good detection in 1,000 (chi-square, 3 degrees)."""
FARTHEST = 30.0
"""In m; no marker is seen from farther away."""
PATIENCE = 5
"""Outliers one after another that prove the filter wrong: the robot, or the dock, was moved."""


class MarkerFilter:
    """A Kalman filter for a pose that stands still in odom, but for the drift of odometry.

    Between detections, odometry alone says where the robot is: the marker stays where it was in odom and becomes less
    certain with each metre driven. Detections that are too far off are left out, unless several follow each other.

    Attributes:
        pose: Of the marker in odom; None before the first detection.
        raw: The last detection's, whatever became of it.
        count: Detections that agreed, since the filter began.
        seen_at: When the last of them was made.
    """

    def __init__(self, memory: float) -> None:
        """Begin without a detection.

        Args:
            memory: How old a detection may be, in s.
        """
        self.pose: Pose | None = None
        self.raw: Pose | None = None
        self.count = 0
        self.seen_at = -math.inf
        self._memory = memory
        self._looked_at = -math.inf
        self._variance = self._angle_variance = 0.0
        self._outliers = 0
        self._last: Pose | None = None

    def update(self, observation: Observation) -> None:
        """Take over what is new: the way since the last time, and a detection."""
        odometry, marker = observation.odometry, observation.marker
        if odometry is None or not odometry.pose.finite:
            return
        self._predict(odometry.pose)
        if (
            marker is not None
            and marker.pose.finite
            and odometry.pose.distance_to(marker.pose) < FARTHEST
            and marker.stamp > self._looked_at
            and abs(observation.now - marker.stamp) <= self._memory
        ):
            self._looked_at = marker.stamp
            self._correct(marker.pose, odometry.pose.distance_to(marker.pose), marker.stamp)

    def _predict(self, robot: Pose) -> None:
        last, self._last = self._last, robot
        if last is None or self.pose is None:
            return
        way, turn = last.distance_to(robot), abs(normalize_angle(robot.theta - last.theta))
        self._angle_variance += TURN_DRIFT**2 * (way + 0.5 * turn)
        lever = DRIFT + TURN_DRIFT * robot.distance_to(self.pose)
        self._variance += lever**2 * (way + 0.5 * turn)

    def _correct(self, seen: Pose, distance: float, stamp: float) -> None:
        self.raw = seen
        noise = (POSITION_NOISE + DISTANCE_NOISE * distance) ** 2
        if self.pose is None:
            self._restart(seen, noise, stamp)
            return
        x, y, theta = seen.x - self.pose.x, seen.y - self.pose.y, normalize_angle(seen.theta - self.pose.theta)
        spread, angle_spread = self._variance + noise, self._angle_variance + ANGLE_NOISE**2
        if (x * x + y * y) / spread + theta * theta / angle_spread > GATE:
            self._outliers += 1
            if self._outliers >= PATIENCE:
                self._restart(seen, noise, stamp)
            return
        gain, angle_gain = self._variance / spread, self._angle_variance / angle_spread
        self.pose = Pose(
            self.pose.x + gain * x, self.pose.y + gain * y, normalize_angle(self.pose.theta + angle_gain * theta)
        )
        self._variance *= 1.0 - gain
        self._angle_variance *= 1.0 - angle_gain
        self._outliers = 0
        self.count += 1
        self.seen_at = stamp

    def _restart(self, seen: Pose, noise: float, stamp: float) -> None:
        self.pose = seen
        self._variance, self._angle_variance = noise, ANGLE_NOISE**2
        self._outliers = 0
        self.count = 1
        self.seen_at = stamp
