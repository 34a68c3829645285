"""Chooses what follows a failure: another press on the contacts, a retry, the way back to staging, or the end."""

from docking.core.errors import (
    DockingError,
    FailedToCharge,
    FailedToDetectDock,
    Obstructed,
    OdometryLost,
    ScanLost,
    Stage,
)
from docking.goal.doubts import Doubts
from docking.goal.objective import Objective
from docking.goal.plan import NothingLeftToTry, Plan, RecoveringPlan
from docking.parameters import RecoverySettings

BEYOND_RETRY = (OdometryLost, ScanLost, Obstructed)
"""What ends a goal for its own reason, also while the robot backs off for another one."""
MEANWHILE = {
    Stage.RETRY: "while backing off",
    Stage.CORRECTING: "while pressing again",
    Stage.RETURN_TO_STAGING: "on the way back to the staging pose",
}
"""By stage: when something else failed."""
BEFORE_DOCK = frozenset({Stage.INITIAL_PERCEPTION, Stage.NAV_TO_STAGING_POSE})
"""Where the robot has not left its staging pose towards the dock."""


class Recovery:
    """Decides what comes after each failure of a goal.

    Attributes:
        retries: Number of retries.
        corrections: Number of corrective moves, in all attempts.
        reason: What the running retry, correction or way back is about; None while there is none.
    """

    def __init__(self, plan: Plan, objective: Objective, doubts: Doubts) -> None:
        """Begin with no failure.

        Args:
            plan: The stages. Without odometry, as with `rotate`, nothing is tried again.
            objective: How often to try again.
            doubts: Where each failure is noted that something comes after.
        """
        self.retries = self.corrections = 0
        self.reason: DockingError | None = None
        self._plan = plan
        self._objective = objective
        self._doubts = doubts

    @property
    def _settings(self) -> RecoverySettings | None:
        """None where the plan or the objective knows no moves after a failure."""
        return self._objective.recovery if isinstance(self._plan, RecoveringPlan) else None

    def after(self, failure: DockingError, stage: Stage) -> Stage | DockingError:
        """The stage that comes next, or the error that the goal ends with.

        Args:
            failure: What has failed.
            stage: Where.
        """
        ends_for_itself = isinstance(failure, BEYOND_RETRY) and stage is not Stage.RETURN_TO_STAGING
        if self.reason is not None and stage in MEANWHILE and not ends_for_itself:
            both = self.meanwhile(stage, str(failure))
            nothing_left = isinstance(failure, NothingLeftToTry)
            if nothing_left or stage is not Stage.CORRECTING:
                return self._leave(both, stage) if nothing_left else both
            failure = both
        if isinstance(failure, FailedToDetectDock):
            return self._not_found(failure)
        if not failure.worth_a_retry or self._plan.motion is None:
            return failure
        if not self._corrects(failure, stage) and self.retries >= self._objective.max_retries:
            return self._leave(failure, stage)
        self.reason = failure
        self._doubts.count(failure.error_code, str(failure))
        if self._corrects(failure, stage):
            self.corrections += 1
            return Stage.CORRECTING
        self.retries += 1
        return Stage.RETRY

    def _corrects(self, failure: DockingError, stage: Stage) -> bool:
        """Whether it is worth to press again."""
        on_contacts = stage is self._plan.stages[-1] and isinstance(failure, FailedToCharge)
        return on_contacts and self._settings is not None and self.corrections < self._settings.max_corrections

    def _not_found(self, failure: FailedToDetectDock) -> DockingError:
        return self._plan.lost(f"{failure}, although it was seen before") if self.retries else failure

    def meanwhile(self, stage: Stage, sentence: str) -> DockingError:
        """The first reason, with what has failed since."""
        reason = self.reason
        if reason is None:
            raise ValueError(f"nothing had failed before {stage}")
        return type(reason)(f"{reason}; then, {MEANWHILE[stage]}: {sentence}")

    def over(self) -> None:
        """The retry or the correction is done: the attempt goes on as if nothing had happened."""
        self.reason = None

    def _leave(self, failure: DockingError, stage: Stage) -> Stage | DockingError:
        """The way back, where the robot is in front of the dock and may move; else the end."""
        settings = self._settings
        if settings is None or not settings.return_to_staging or stage in BEFORE_DOCK:
            return failure
        self.reason = failure
        return Stage.RETURN_TO_STAGING
