"""The plan of undocking: straight back, as far as the staging pose."""

from docking.behaviors.back_out import BackOut
from docking.core.errors import FailedToUndock, Stage
from docking.core.observation import Observation
from docking.goal.plan import KnownPoses
from docking.parameters import MotionLimits


class UndockPlan:
    """Backs out, then stands still until the battery charges no longer; see `Plan`."""

    stages = (Stage.UNDOCKING,)
    lost = FailedToUndock
    poses = KnownPoses()

    def __init__(self, distance: float, motion: MotionLimits) -> None:
        """Begin where the robot is.

        Args:
            distance: How far to back out, in m.
            motion: What the robot may do.
        """
        self.motion = motion
        self._distance = distance

    def observe(self, observation: Observation) -> None:
        """Nothing to remember."""

    def controller(self, stage: Stage) -> BackOut:
        """The only one."""
        return BackOut(self._distance, self.motion)
