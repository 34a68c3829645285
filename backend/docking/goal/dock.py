"""Docking: reached when the battery charges, and goes on charging."""

from docking.core.battery import BatteryReading
from docking.core.errors import (
    DockingError,
    FailedToCharge,
    FailedToControl,
    FailedToDetectDock,
    FailedToStage,
    Stage,
)
from docking.core.observation import Observation
from docking.goal.dock_memory import DockMemory
from docking.goal.objective import Deadline
from docking.parameters import DockTimeouts


class Docking:
    """The objective of a docking goal; see `Objective`.

    While the battery charges, the robot stands still, but presses on where it approaches the dock: the first contact
    may be a few millimetres before the docked pose, and may bounce.
    """

    docks = True

    def __init__(self, timeouts: DockTimeouts, memory: DockMemory | None = None, *, dock_type: str = "") -> None:
        """Begin with a battery that does not charge.

        Args:
            timeouts: The time limits.
            memory: Where it is noted that the robot is docked.
            dock_type: The type of its dock.
        """
        self.timeouts = timeouts
        self.max_retries = timeouts.max_retries
        self.memory = memory or DockMemory()
        self._dock_type = dock_type
        self._connected_since: float | None = None
        self._deadlines = {
            Stage.INITIAL_PERCEPTION: Deadline(
                "initial_perception_timeout",
                timeouts.initial_perception_timeout,
                FailedToDetectDock,
                "the dock was not found",
            ),
            Stage.NAV_TO_STAGING_POSE: Deadline(
                "staging_timeout", timeouts.staging_timeout, FailedToStage, "the staging pose was not reached"
            ),
            Stage.CONTROLLING: Deadline(
                "dock_approach_timeout", timeouts.dock_approach_timeout, FailedToControl, "the dock was not reached"
            ),
            Stage.WAIT_FOR_CHARGE: Deadline(
                "wait_charge_timeout",
                timeouts.wait_charge_timeout,
                FailedToCharge,
                "the battery on the dock did not charge",
            ),
            Stage.RETRY: Deadline(
                "retry_timeout", timeouts.retry_timeout, FailedToControl, "the robot did not back off"
            ),
        }

    def is_reached(self, observation: Observation, battery: BatteryReading | None, finished: bool) -> bool:
        """Whether the battery has been charging for charge_stable_for."""
        if battery is None or not battery.connected:
            self._connected_since = None
            return False
        if self._connected_since is None:
            self._connected_since = observation.now
        if observation.now - self._connected_since < self.timeouts.charge_stable_for:
            return False
        self.memory.dock_type = self._dock_type
        return True

    def holds(self, stage: Stage) -> bool:
        """Whether the battery charges and the robot is not pressing on."""
        return self._connected_since is not None and stage is not Stage.CONTROLLING

    def deadline(self, stage: Stage, finished: bool) -> Deadline | None:
        """The time limit of a stage."""
        return self._deadlines.get(stage)

    def reword(self, failure: DockingError) -> DockingError:
        """The same."""
        return failure
