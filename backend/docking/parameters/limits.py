"""Parameters that limit the robot's motion."""

import enum
import math
from dataclasses import dataclass, replace

from docking.core.observation import UNLIMITED, Deceleration
from docking.core.parameter import choice, number

BACKWARDS = 0.6
"""The part of v_linear_max that the robot backs with where it does not see what is behind it."""
RESERVE = 0.6
"""The part of the highest deceleration that is planned with."""
RESPONSE = 2.5
"""The most that is corrected at once, in 1/s."""


def braked(error: float, acceleration: float) -> float:
    """Return the highest speed from which the robot can still brake to a standstill within a distance.

    Args:
        error: Remaining distance, in m or rad.
        acceleration: Maximum acceleration, in m/s² or rad/s².
    """
    most = min(math.sqrt(2.0 * RESERVE * acceleration * abs(error)), RESPONSE * abs(error))
    return math.copysign(most, error)


class DriveModel(enum.StrEnum):
    """The kinds of bases, with nav2's names."""

    DIFF_DRIVE = "DiffDrive"
    OMNI = "Omni"
    ACKERMANN = "Ackermann"


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Limits of the robot's motion. It stands still or moves between the minimum and the maximum velocities."""

    v_linear_max: float = number(
        0.26, 0.01, 2.0, "m/s", "Maximum linear velocity, forwards and backwards (linear.x). Not below v_linear_min."
    )
    v_linear_min: float = number(
        0.04,
        0.005,
        0.5,
        "m/s",
        "Minimum linear velocity: slower commands may not move the base. Also used for the last part before contact, "
        "where a base with a dead zone may be faster by 0.02 m/s at most.",
    )
    v_angular_max: float = number(
        1.0, 0.05, 4.0, "rad/s", "Maximum angular velocity, in both directions (angular.z). Not below v_angular_min."
    )
    v_angular_min: float = number(
        0.0, 0.0, 1.0, "rad/s", "Minimum angular velocity of a turn on the spot: slower commands may not move the base."
    )
    a_linear_max: float = number(0.5, 0.05, 5.0, "m/s²", "Maximum linear acceleration; does not apply to a stop.")
    a_angular_max: float = number(2.0, 0.1, 20.0, "rad/s²", "Maximum angular acceleration; does not apply to a stop.")

    motion_model: DriveModel = choice(
        DriveModel.DIFF_DRIVE,
        "How the base moves. `Omni`: also sideways (linear.y), so that dock_pose corrects lateral errors before the "
        "dock without a retry. `Ackermann`: docking is refused.",
    )

    @property
    def v_lateral_max(self) -> float:
        """Maximum velocity sideways, in m/s; 0 where the base cannot drive so."""
        return self.v_linear_max if self.motion_model is DriveModel.OMNI else 0.0

    @property
    def v_linear_back(self) -> float:
        """Maximum linear velocity backwards where nothing sees behind the robot, in m/s."""
        return max(self.v_linear_min, BACKWARDS * self.v_linear_max)

    def with_braking(self, braking: Deceleration) -> "MotionLimits":
        """The limits for a base that slows down no faster than this."""
        if braking == UNLIMITED:
            return self
        return replace(
            self,
            a_linear_max=min(self.a_linear_max, braking.linear_x),
            a_angular_max=min(self.a_angular_max, braking.angular_z),
        )
