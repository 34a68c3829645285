"""Undocking: reached when the robot has backed out and its battery charges no longer."""

from docking.core.battery import FULL, BatteryReading, PowerSupplyStatus
from docking.core.errors import Blocked, DockedUnknown, DockingError, FailedToUndock, Stage
from docking.core.observation import Observation
from docking.goal.charging import current_in, describe_charging, is_full, tells_charging
from docking.goal.dock_memory import DockMemory
from docking.goal.objective import Deadline, Objective, Progress
from docking.parameters import ChargingSettings, ChargingSource, UndockTimeouts
from docking.parameters.timeouts import at_least

PAUSES_ABOVE = 0.7
"""State of charge down to which a charger may wait after the battery was full."""
OUT = 0.1
"""Current out of the battery, in A, with which nothing else supplies the robot."""


class Undocking(Objective):
    """The objective of an undocking goal, which leads away from the dock.

    A robot whose battery charges is docked. Without that, what earlier goals have left behind counts. Where
    nothing tells, the goal fails: it is no success to be on the dock, and nothing is behind a robot that is not.

    Odometry does not notice that a robot is lifted off its dock. So where only odometry says that it stands where it
    was docked, the robot drives at its slowest, and where the battery says the contrary, not at all. A battery that was
    full on the dock may discharge there, until the charger goes on.
    """

    docks = False

    def __init__(
        self,
        timeouts: UndockTimeouts,
        memory: DockMemory | None = None,
        *,
        charging: ChargingSettings | None = None,
        assume_docked: bool = False,
        slowest: float = 0.0,
    ) -> None:
        """Begin without knowing whether the robot is docked.

        Args:
            timeouts: The time limits.
            memory: Knowledge from earlier goals.
            charging: How charging is detected; None uses the battery's status.
            assume_docked: What counts where nothing tells: that it is docked.
            slowest: Seconds that the way takes at the lowest speed: the time limit is longer then.
        """
        super().__init__(timeouts, memory, charging)
        self._undocking_timeout = timeouts.undocking_timeout
        self._slowest = at_least(self._undocking_timeout, slowest) if slowest else self._undocking_timeout
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
            self.memory.note(True, pose, observation.now)
            self._docked, self.unsure = True, ""
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
        if known and not self._assume_docked:
            self._check(battery)
        self._docked = known is not False
        return known is False

    def _check(self, battery: BatteryReading | None) -> None:
        """Ask the battery of a robot that was docked and, by its odometry, has not moved since.

        Raises:
            DockedUnknown: It contradicts.
        """
        if battery is not None and self._is_off(battery) and not self._may_pause(battery):
            raise DockedUnknown(
                f"the robot was docked and has not driven since, but {describe_charging(battery, self._charging)} at"
                f" {100.0 * battery.percentage:.0f} %: it was lifted off its dock, or the dock has no power. Nothing is"
                " driven, as nothing sees behind the robot. If it is on the dock, drive it off by hand, or set"
                " assume_docked to true and send the goal again; if it is not, there is nothing to do"
            )
        if battery is None or not self._is_at_charger(battery):
            self.unsure = (
                f"only odometry tells that the robot is on its dock, and {describe_charging(battery, self._charging)}:"
                " it drove at v_linear_min, as it may have been lifted off. With use_collision_detection and a scanner"
                " that sees where it drives, it is faster"
            )

    def _is_at_charger(self, battery: BatteryReading) -> bool:
        """Whether the status tells that a charger is there, though it does not charge."""
        by_status = self._charging.charging_source is ChargingSource.STATUS
        return is_full(battery) or (by_status and battery.status == PowerSupplyStatus.NOT_CHARGING)

    def _is_off(self, battery: BatteryReading) -> bool:
        """Whether a battery that is not full tells that it is at no charger; where the pose is the judge, never."""
        if self._charging.charging_source is ChargingSource.STATUS:
            discharges = battery.status == PowerSupplyStatus.DISCHARGING
        elif self._charging.charging_source is ChargingSource.CURRENT:
            discharges = current_in(battery, self._charging) < -OUT
        else:
            return False
        return discharges and battery.percentage < FULL

    def _may_pause(self, battery: BatteryReading) -> bool:
        """Whether the charger may wait until the battery is low enough: it was full since the robot has docked."""
        return battery.percentage >= PAUSES_ABOVE and battery.full_at >= self.memory.since

    def limit(self, stage: Stage) -> float:
        """The longest that it may take: what earlier goals have left behind is known in the first step."""
        return self._slowest

    def deadline(self, stage: Stage, finished: bool) -> Deadline | None:
        """The time limit of backing out until the battery charges no longer."""
        message = "the battery is still charging" if finished else "the robot did not get away from the dock"
        seconds = self._slowest if self.unsure else self._undocking_timeout
        return Deadline("undocking_timeout", seconds, FailedToUndock, message)

    def reword(self, failure: DockingError) -> DockingError:
        """A robot that is blocked has failed to undock."""
        if isinstance(failure, Blocked):
            return FailedToUndock(f"the robot did not get away from the dock: {failure}")
        return failure
