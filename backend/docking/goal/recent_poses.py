"""Keeps where the dock was believed to be over the last way."""

from collections import deque
from collections.abc import Iterator

from docking.core.geometry import Pose
from docking.goal.plan import KnownPoses

WAY, STRIDE = 0.3, 0.03
"""The way, in m, over which the dock's poses are remembered, and how often."""


class RecentPoses:
    """Remembers the dock's poses: a marker that seems to move with the robot moves the dock on."""

    def __init__(self) -> None:
        """Know no dock."""
        self._robot: Pose | None = None
        self._way = 0.0  # in m, by odometry
        self._poses: deque[tuple[float, KnownPoses]] = deque()  # at which way; the last one is the newest

    def __iter__(self) -> Iterator[KnownPoses]:
        """All that are remembered."""
        return (poses for _, poses in self._poses)

    def add(self, robot: Pose, poses: KnownPoses) -> None:
        """Take in the newest ones; where the dock is not known, all are forgotten.

        Args:
            robot: base_link in odom.
            poses: Poses of the dock.
        """
        self._way += 0.0 if self._robot is None else robot.distance_to(self._robot)
        self._robot = robot
        if poses.filtered_dock is None:
            self._poses.clear()
            return
        if len(self._poses) > 1 and self._way - self._poses[-2][0] < STRIDE:
            self._poses.pop()
        self._poses.append((self._way, poses))
        while self._way - self._poses[0][0] > WAY:
            self._poses.popleft()
