"""Tells by odometry whether the robot moves."""

from docking.core.observation import Odometry

LINEAR, ANGULAR = 0.005, 0.02
"""Velocities, in m/s and rad/s, from which a robot moves."""
SHIFT, TURN = 0.0005, 0.002
"""Changes of the pose between two readings, in m and rad, from which it does: some odometry tells no velocity."""


class Standstill:
    """Compares each reading with the one before."""

    def __init__(self) -> None:
        self._before: Odometry | None = None
        self._moved = True

    def moves(self, odometry: Odometry | None) -> bool:
        """Whether the robot moves.

        Args:
            odometry: The newest reading; None where there is none, and nothing says that it moves.
        """
        if odometry is None:
            return False
        before, self._before = self._before, odometry
        if odometry is not before:
            self._moved = before is None or _differs(before, odometry)
        return self._moved


def _differs(before: Odometry, after: Odometry) -> bool:
    velocity, moved = after.velocity, after.pose.relative_to(before.pose)
    return (
        max(abs(velocity.linear_x), abs(velocity.linear_y)) > LINEAR
        or abs(velocity.angular_z) > ANGULAR
        or max(abs(moved.x), abs(moved.y)) > SHIFT
        or abs(moved.theta) > TURN
    )
