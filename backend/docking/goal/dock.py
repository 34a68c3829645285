"""Docking: reached when the battery charges, and goes on charging."""

from dataclasses import replace

from docking.core.battery import BatteryReading, PowerSupplyStatus, describe_status
from docking.core.errors import (
    DockingError,
    FailedToCharge,
    FailedToControl,
    FailedToDetectDock,
    FailedToStage,
    Stage,
)
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.estimation.motion_model import MotionModel
from docking.goal.charger_doubt import ChargerDoubt
from docking.goal.charging import FLICKERS, ChargeRecord, is_full, stands_docked, tells_charging
from docking.goal.dock_memory import DockMemory, LastDocking
from docking.goal.motion_watch import makes_sense
from docking.goal.objective import Deadline, Objective, Progress
from docking.parameters import ChargingSettings, ChargingSource, DockTimeouts, RecoverySettings, SearchSettings, Staging

DEADLINES: dict[Stage, tuple[str, type[DockingError], str]] = {
    Stage.INITIAL_PERCEPTION: ("initial_perception_timeout", FailedToDetectDock, "the dock was not found"),
    Stage.NAV_TO_STAGING_POSE: ("staging_timeout", FailedToStage, "the staging pose was not reached"),
    Stage.CONTROLLING: ("dock_approach_timeout", FailedToControl, "the dock was not reached"),
    Stage.WAIT_FOR_CHARGE: ("wait_charge_timeout", FailedToCharge, "the battery on the dock did not charge"),
    Stage.RETRY: ("retry_timeout", FailedToControl, "the robot did not back off"),
    Stage.RETURN_TO_STAGING: ("retry_timeout", FailedToControl, "the staging pose was not reached"),
}
"""By stage: the parameter that limits its time, and what has happened when that is over."""


class Docking(Objective):
    """The objective of a docking goal.

    While the battery charges, the robot stands still, but presses on where it approaches the dock: the first contact
    may be a few millimetres before the docked pose, and may bounce.
    """

    docks = True

    def __init__(
        self,
        timeouts: DockTimeouts,
        memory: DockMemory | None = None,
        *,
        charging: ChargingSettings | None = None,
        docking_threshold: float = 0.05,
        slowdown_radius: float = 0.1,
        recovery: RecoverySettings | None = None,
        staging: Staging | None = None,
        dock_type: str = "",
        dock_name: str = "",
        search: SearchSettings | None = None,
    ) -> None:
        """Begin with a battery that does not charge.

        Args:
            timeouts: The time limits.
            memory: Where it is noted that the robot is docked.
            charging: How charging is detected; None uses the battery's status.
            docking_threshold: How far from the docked pose the robot may stand, in m, where the pose tells it.
            slowdown_radius: The last part of the way to the docked pose, in m, that is driven slowly.
            recovery: Moves on the contacts and after the last attempt; None without any.
            staging: Of the dock, to be remembered; None is the usual one.
            dock_type: Of the dock, to be remembered.
            dock_name: Of the dock, to be remembered.
            search: How long the robot may drive about to find the dock, at each attempt; None is the usual time.
        """
        super().__init__(timeouts, memory, charging)
        self.max_retries = timeouts.max_retries
        self.recovery = recovery
        self.slowdown_radius = slowdown_radius
        self._threshold = docking_threshold
        self._staging = staging or Staging()
        self._dock_type = dock_type
        self._dock_name = dock_name
        self._status: int | None = None
        self._stable_for = timeouts.charge_stable_for
        self._record = ChargeRecord(timeouts.charge_stable_for)
        self._charger = ChargerDoubt()
        self._read: tuple[float, int] | None = None
        self._motion = MotionModel()  # for the velocity, measured from poses
        self._deadlines = {
            stage: Deadline(parameter, getattr(timeouts, parameter), error, message)
            for stage, (parameter, error, message) in DEADLINES.items()
        }
        if not self._charging.charges:
            self._deadlines[Stage.WAIT_FOR_CHARGE] = Deadline(
                "wait_charge_timeout",
                timeouts.wait_charge_timeout,
                FailedToControl,
                f"the robot did not stay within {docking_threshold:g} m (docking_threshold) of the docked pose",
            )
        search_timeout = (search or SearchSettings()).search_timeout
        self._search = Deadline("search_timeout", search_timeout, FailedToDetectDock, "the dock was not found")
        if recovery is not None:
            self._deadlines[Stage.CORRECTING] = Deadline(
                "correction_timeout", recovery.correction_timeout, FailedToControl, "the robot did not press again"
            )

    def is_reached(self, observation: Observation, battery: BatteryReading | None, progress: Progress) -> bool:
        """Whether the battery has been charging, or the robot docked, for charge_stable_for."""
        odometry = observation.odometry
        robot = odometry.pose if odometry is not None and makes_sense(odometry.pose) else None
        if robot is not None:
            self._motion.update(observation.now, robot)
        self.memory.heads_for(self._staging, self._dock_type, robot, charges=self._charging.charges)
        if battery is not None or not self.needs_battery:
            self._hear(observation.now, robot, battery, progress)
            if self._record.is_stable:
                docking = LastDocking(self._staging, robot, progress.turn, progress.camera)
                self.memory.docked_at(self._dock_name, docking)
                return True
        return False

    def _hear(self, now: float, robot: Pose | None, battery: BatteryReading | None, progress: Progress) -> None:
        """Take notice of what tells the charge: each message of the battery once, or the pose at each step."""
        if battery is not None:
            self._status = battery.status
        if self._charging.by_pose or battery is None:
            # Before the robot has arrived, it may still be where it was docked last.
            docked = progress.docked if progress.arrived else self.memory.at if self.memory.docked else None
            charges = stands_docked(robot, docked, self._charging, self._threshold)
            self._record.hear(now, battery, charges=charges)
        elif (read := (battery.received_at, battery.status)) != self._read:
            self._read = read
            says = tells_charging(battery, self._charging, self._motion.history.velocity)
            charges = self._charger.believes(robot, self._motion.history.velocity, progress.docked, charges=says)
            full = not charges and self._is_full(robot, battery, progress)
            self.doubt = _describe_full(battery) if full else self._charger.reason or self.doubt
            self._record.hear(battery.received_at, battery, charges=charges or full)

    def _is_full(self, robot: Pose | None, battery: BatteryReading, progress: Progress) -> bool:
        """Whether the robot stands on its dock with a battery that takes no more: its driver may say NOT_CHARGING."""
        if not progress.arrived or robot is None or progress.docked is None:
            return False
        return is_full(battery) and robot.distance_to(progress.docked) <= self._threshold

    def holds(self, stage: Stage) -> bool:
        """Whether the battery charges and the robot is not pressing on.

        Where the pose alone tells that it is docked, the plan goes on to watch that.
        """
        if not self._charging.charges and stage is Stage.WAIT_FOR_CHARGE:
            return False
        return self._record.charges and stage is not Stage.CONTROLLING

    @property
    def flickers(self) -> bool:
        """Whether the charge comes and goes."""
        return self._record.flickers

    @property
    def search(self) -> Deadline | None:
        """The time limit of driving about to find the dock."""
        return self._search

    def limit(self, stage: Stage) -> float:
        """The longest that a stage may take, but for waiting and for a charge that is not stable yet."""
        return super().limit(stage) + (0.0 if self._charging.charges else self._stable_for)

    def held(self, failures: int) -> float:
        """The longest that the robot stands for a charge that breaks off, beyond the limits of its stages."""
        return (FLICKERS + failures) * self._record.longest(self.timeouts.battery_stale_after)

    def deadline(self, stage: Stage, finished: bool) -> Deadline | None:
        """The time limit of a stage."""
        deadline = self._deadlines.get(stage)
        if deadline is not None and not self._charging.charges and self._record.charges:
            return replace(deadline, seconds=deadline.seconds + self._stable_for)  # in a moment it is docked
        if deadline is not None and stage is Stage.WAIT_FOR_CHARGE and self._record.breaks:
            return replace(deadline, message="the charge did not become stable")
        return deadline

    def reword(self, failure: DockingError) -> DockingError:
        """Return a failure with a hint where the charge broke off, or the battery's status is never set."""
        if isinstance(failure, FailedToCharge) and (story := self._record.describe()):
            return FailedToCharge(f"{failure}: {story}")
        if (
            isinstance(failure, FailedToCharge)
            and self._charging.charging_source is ChargingSource.STATUS
            and self._status == PowerSupplyStatus.UNKNOWN
        ):
            status = describe_status(self._status)
            return FailedToCharge(f"{failure}: its status is {status}; charging_source may be current or pose")
        return failure


def _describe_full(battery: BatteryReading) -> str:
    return (
        f"the battery is full ({100.0 * battery.percentage:.0f} %) and its status is {describe_status(battery.status)}:"
        " a charger may wait until it takes some again. That the robot is docked is known by its pose alone"
    )
