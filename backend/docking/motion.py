"""Whether the robot moves as it is told, by its own reckoning."""

import math
from collections import deque

from docking.failures import Blocked, OdometryLost
from docking.geometry import Pose, normalize_angle
from docking.observation import STANDSTILL, Observation, Odometry, Velocity

DELAY = 0.3
"""How old odometry may be, in s, for the robot to go on driving."""
TOLERANCE = 0.35
"""The part of a commanded way that may be missing: slip, delays, acceleration."""
LEAST_WAY = 0.02
"""In m; a shorter way missing says nothing."""
LEAST_TURN = 0.12
"""In rad; a smaller turn missing says nothing."""


class MotionWatch:
    """Compares what the wheels were told with what odometry says.

    Attributes:
        commanded: The velocity since the last look.
    """

    def __init__(self, odometry_timeout: float, blocked_after: float, started_at: float) -> None:
        """Begin at a standstill.

        Args:
            odometry_timeout: Silence of odometry, in s, that is an error.
            blocked_after: How long, in s, the robot may not move although it was told to.
            started_at: Seconds of the monotonic clock.
        """
        self.commanded = STANDSTILL
        self._odometry_timeout = odometry_timeout
        self._blocked_after = blocked_after
        self._started_at = started_at
        self._told: deque[tuple[float, float, float]] = deque()  # until when, m forward, rad
        self._seen: deque[tuple[float, Pose]] = deque()

    def rest(self) -> None:
        """The robot was told to stand still: what was before no longer counts."""
        self.commanded = STANDSTILL
        self._told.clear()
        self._seen.clear()

    def sees(self, observation: Observation, dt: float) -> bool:
        """Whether the robot knows where it is, so that it may move.

        Args:
            observation: What is known now.
            dt: Seconds since the last look, in which `commanded` held.

        Raises:
            OdometryLost: Odometry has been silent for too long.
            Blocked: The robot did not move as it was told.
        """
        now, odometry = observation.now, observation.odometry
        if odometry is None or not odometry.pose.finite or now - odometry.stamp > DELAY:
            heard_at = self._started_at if odometry is None else max(self._started_at, odometry.stamp)
            if now - heard_at > self._odometry_timeout:
                raise OdometryLost(f"no odometry for {self._odometry_timeout:g} s (odometry_timeout)")
            return False
        self._remember(now, dt, odometry)
        self._compare(now)
        return True

    def _remember(self, now: float, dt: float, odometry: Odometry) -> None:
        velocity: Velocity = self.commanded
        self._told.append((now, velocity.linear_x * dt, velocity.angular_z * dt))
        self._seen.append((now, odometry.pose))
        while len(self._seen) > 1 and now - self._seen[1][0] >= self._blocked_after:
            self._seen.popleft()
            self._told.popleft()

    def _compare(self, now: float) -> None:
        if now - self._seen[0][0] < self._blocked_after:
            return
        told_way = math.fsum(way for _, way, _ in self._told) - self._told[0][1]
        told_turn = math.fsum(turn for _, _, turn in self._told) - self._told[0][2]
        way = turn = 0.0
        for (_, before), (_, after) in zip(self._seen, list(self._seen)[1:], strict=False):
            moved = after.relative_to(before)
            way += moved.x
            turn += normalize_angle(moved.theta)
        if abs(told_way) - abs(way) > max(LEAST_WAY, TOLERANCE * abs(told_way)) or abs(told_turn - turn) > max(
            LEAST_TURN, TOLERANCE * abs(told_turn)
        ):
            raise Blocked(
                f"told to drive {told_way:.2f} m and turn {told_turn:.2f} rad within {self._blocked_after:g} s"
                f" (blocked_after), the robot drove {way:.2f} m and turned {turn:.2f} rad"
            )
