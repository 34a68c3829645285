"""The status on /diagnostics: one report at a time, as REP-107 demands."""

import enum
from dataclasses import dataclass, field

from docking.core.errors import ErrorCode, Stage
from docking.goal.admission import Rejection
from docking.goal.outcome import Command, Outcome


class Level(enum.IntEnum):
    """`level` of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


LEVELS = dict.fromkeys(Stage, Level.OK) | {
    Stage.RETRY: Level.WARN,
    Stage.CORRECTING: Level.WARN,
    Stage.RETURN_TO_STAGING: Level.WARN,
    Stage.WAIT_FOR_CLEARANCE: Level.WARN,
    Stage.WAIT_FOR_BATTERY: Level.WARN,
    Stage.WAIT_FOR_ODOMETRY: Level.WARN,
    Stage.ABORTED: Level.ERROR,
    Stage.REJECTED: Level.WARN,
}


@dataclass(frozen=True)
class Report:
    """The state of docking, or the fate of one goal.

    Attributes:
        stage: The current stage, or how the goal ended.
        error_code: The error, or NONE.
        error_msg: The same as a sentence, empty with NONE.
        goal_id: The goal it is about as a canonical UUID; empty before the first goal.
        retries: Number of retries.
        doubts: What seemed wrong on the way of a goal that has ended, as sentences.
        memory: What was known from earlier goals as this one began, as JSON; only in the first report on a goal.
    """

    stage: Stage = Stage.IDLE
    error_code: ErrorCode = ErrorCode.NONE
    error_msg: str = ""
    goal_id: str = ""
    retries: int = 0
    doubts: str = ""
    memory: str = field(default="", compare=False)

    @property
    def level(self) -> Level:
        """The severity."""
        return LEVELS[self.stage]

    @property
    def message(self) -> str:
        """One line for a person: the sentence if something is wrong, else the stage."""
        return self.error_msg or self.stage.value.lower().replace("_", " ")

    def values(self) -> dict[str, str]:
        """The key values, in their order."""
        values = {
            "stage": self.stage.value,
            "error_code": self.error_code.value,
            "error_msg": self.error_msg,
            "goal_id": self.goal_id,
            "error_number": str(self.error_code.number),
            "retries": str(self.retries),
            "doubts": self.doubts,
        }
        return values | {"memory": self.memory} if self.memory else values


def report_on(event: Command | Outcome | Rejection, goal_id: str) -> Report:
    """Return the report on a step, an outcome or a rejection of a goal."""
    if isinstance(event, Rejection):
        return Report(Stage.REJECTED, event.error_code, event.error_msg, goal_id)
    if isinstance(event, Command):
        return Report(event.stage, event.error_code, event.error_msg, goal_id, event.retries)
    doubts = "; ".join(event.doubts)
    return Report(event.end.stage, event.error_code, event.error_msg, goal_id, event.retries, doubts)
