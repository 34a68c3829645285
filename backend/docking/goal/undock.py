"""Undocking: reached when the robot has backed out and its battery charges no longer."""

from docking.core.battery import BatteryReading, PowerSupplyStatus
from docking.core.errors import Blocked, DockedUnknown, DockingError, FailedToUndock, Stage
from docking.core.observation import Observation
from docking.goal.charging import FULL, describe_charging, tells_charging
from docking.goal.dock_memory import DockMemory
from docking.goal.objective import Deadline, Objective, Progress
from docking.parameters import ChargingSettings, ChargingSource, UndockTimeouts


class Undocking(Objective):
    """The objective of an undocking goal, which leads away from the dock.

    A robot whose battery charges is docked. Without that, what earlier goals have left behind counts. Where
    nothing tells, the goal fails: it is no success to be on the dock, and nothing is behind a robot that is not.
    """

    docks = False

    def __init__(
        self,
        timeouts: UndockTimeouts,
        memory: DockMemory | None = None,
        *,
        charging: ChargingSettings | None = None,
        assume_docked: bool = False,
    ) -> None:
        """Begin without knowing whether the robot is docked.

        Args:
            timeouts: The time limits.
            memory: Knowledge from earlier goals.
            charging: How charging is detected; None uses the battery's status.
            assume_docked: What counts where nothing tells: that it is docked.
        """
        super().__init__(timeouts, memory, charging)
        self._undocking_timeout = timeouts.undocking_timeout
        self._assume_docked = assume_docked
        self._docked = False  # for certain

    def is_reached(self, observation: Observation, battery: BatteryReading | None, progress: Progress) -> bool:
        """Whether the robot is off the dock.

        Raises:
            DockedUnknown: Nothing tells whether the robot is docked, or what tells it disagrees.
        """
        if battery is None and self.needs_battery:
            return False
        pose = None if observation.odometry is None else observation.odometry.pose
        charges = battery is not None and tells_charging(battery, self._charging)
        if self._docked:
            return progress.finished and not charges
        if charges:
            self.memory.note(True, pose)
            self._docked = True
            return False
        if pose is None and self.memory.at is not None:
            return False  # odometry will tell, or be missed
        known = self.memory.recall(pose)
        if known is None and not self._assume_docked:
            raise DockedUnknown(
                f"it is not known whether the robot is docked: {describe_charging(battery, self._charging)}, and no"
                " earlier goal tells. If it is on the dock, switch the charger on, drive it off by hand, or set"
                " assume_docked to true and send the goal again; if it is not, there is nothing to do"
            )
        if known and battery is not None and not self._assume_docked and self._is_off(battery):
            raise DockedUnknown(
                f"the robot was docked and has not driven since, but {describe_charging(battery, self._charging)} at"
                f" {100.0 * battery.percentage:.0f} %: it was lifted off its dock, or the dock has no power. Nothing is"
                " driven, as nothing sees behind the robot. If it is on the dock, drive it off by hand, or set"
                " assume_docked to true and send the goal again; if it is not, there is nothing to do"
            )
        self._docked = known is not False
        return known is False

    def _is_off(self, battery: BatteryReading) -> bool:
        """Whether a battery tells that it is at no charger; a full one may be, where the charger has switched off."""
        by_status = self._charging.charging_source is ChargingSource.STATUS
        return by_status and battery.status == PowerSupplyStatus.DISCHARGING and battery.percentage < FULL

    def deadline(self, stage: Stage, finished: bool) -> Deadline | None:
        """The time limit of backing out until the battery charges no longer."""
        message = "the battery is still charging" if finished else "the robot did not get away from the dock"
        return Deadline("undocking_timeout", self._undocking_timeout, FailedToUndock, message)

    def reword(self, failure: DockingError) -> DockingError:
        """A robot that is blocked has failed to undock."""
        if isinstance(failure, Blocked):
            return FailedToUndock(f"the robot did not get away from the dock: {failure}")
        return failure
