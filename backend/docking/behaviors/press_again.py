"""A small move on the contacts of the dock: a little back, a little turn, and on again."""

from dataclasses import replace

from docking.behaviors.combined import Sequence
from docking.behaviors.moves import turn
from docking.behaviors.straight import BackOut
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits, RecoverySettings

STALLED = 0.5
"""How long the wheels must have stopped on the contacts, in s."""
CLOSE = 0.2
"""How near to its angle a turn must come, as a fraction of it."""


def press_again(number: int, settings: RecoverySettings, motion: MotionLimits, overshoot: float) -> Sequence:
    """One corrective move, all of it at the lowest speed.

    The first one looks to the left of where it began, the second to the right, and so on.

    Args:
        number: Of the move in this goal, from 1.
        settings: How far to back and to turn.
        motion: Limits of the robot's motion.
        overshoot: How much farther the robot may drive on than it has backed, in m.
    """
    slowly = replace(motion, v_linear_max=motion.v_linear_min)
    angle = settings.correction_angle * (1.0 if number == 1 else 2.0) * (1.0 if number % 2 else -1.0)
    return Sequence(
        lambda: BackOut(settings.correction_distance, slowly),
        lambda: TurnBy(angle, motion),
        lambda: PressOn(settings.correction_distance, overshoot, motion),
    )


class TurnBy:
    """Turns on the spot, by odometry."""

    def __init__(self, angle: float, motion: MotionLimits) -> None:
        """Turn from where the robot looks at the first step.

        Args:
            angle: In rad, to the left.
            motion: Limits of the robot's motion.
        """
        self._angle = angle
        self._motion = motion
        self._heading: float | None = None  # where it is to look

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Turn on; without odometry stand still."""
        if observation.odometry is None:
            return STANDSTILL
        heading = observation.odometry.pose.theta
        if self._heading is None:
            self._heading = heading + self._angle
        error = normalize_angle(self._heading - heading)
        if abs(error) <= CLOSE * abs(self._angle):
            return Done()
        return turn(error, self._motion.with_braking(observation.braking))


class PressOn:
    """Straight on, slowly, until the wheels stop at the dock."""

    def __init__(self, distance: float, overshoot: float, motion: MotionLimits) -> None:
        """Begin a little before the dock.

        Args:
            distance: To where the robot was on the contacts, in m.
            overshoot: How much farther it may drive, in m.
            motion: Limits of the robot's motion.
        """
        self._distance = distance
        self._overshoot = overshoot
        self._velocity = Velocity(motion.v_linear_min)
        self._start: Pose | None = None
        self._stalled = 0.0

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Drive on; without odometry stand still."""
        odometry = observation.odometry
        if odometry is None:
            return STANDSTILL
        self._start = self._start or odometry.pose
        moved = odometry.pose.relative_to(self._start).x
        stopped = odometry.velocity.linear_x < 0.25 * self._velocity.linear_x and moved > 0.5 * self._distance
        self._stalled = self._stalled + dt if stopped else 0.0
        return Done() if moved >= self._distance + self._overshoot or self._stalled > STALLED else self._velocity
