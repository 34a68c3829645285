"""The plan of undocking: straight off the dock, as far as the staging pose."""

from docking.behaviors.combined import Reversed
from docking.behaviors.straight import BackOut
from docking.core.errors import FailedToUndock, Stage
from docking.core.observation import Observation
from docking.goal.behavior import Behavior
from docking.goal.plan import KnownPoses
from docking.parameters import MotionLimits


class UndockPlan:
    """Backs out, then stands still until the battery charges no longer; see `Plan`."""

    stages = (Stage.UNDOCKING,)
    lost = FailedToUndock
    poses = KnownPoses()

    def __init__(self, distance: float, motion: MotionLimits, *, forwards: bool = False) -> None:
        """Start at the current pose of the robot.

        Args:
            distance: How far to back out, in m.
            motion: Limits of the robot's motion.
            forwards: Whether it docked backwards, so that it drives off forwards.
        """
        self._forwards = forwards
        self.motion = motion
        self._distance = distance

    def observe(self, observation: Observation) -> None:
        """Nothing to remember."""

    def controller(self, stage: Stage) -> Behavior:
        """The only one."""
        back_out = BackOut(self._distance, self.motion)
        return Reversed(back_out) if self._forwards else back_out
