import pytest

from docking.core.errors import ErrorCode, Stage
from docking.core.observation import Velocity
from docking.goal.admission import Rejection
from docking.goal.outcome import Command, End, Outcome
from docking.goal.report import Level, Report, report_on


@pytest.mark.parametrize(
    ("event", "stage", "level"),
    [
        (Command(Stage.CONTROLLING, Velocity(0.0, 0.15)), "CONTROLLING", Level.OK),
        (
            Command(Stage.WAIT_FOR_BATTERY, Velocity(), ErrorCode.BATTERY_STALE, "silent"),
            "WAIT_FOR_BATTERY",
            Level.WARN,
        ),
        (Outcome(End.SUCCEEDED), "SUCCEEDED", Level.OK),
        (Outcome(End.CANCELED), "CANCELED", Level.OK),
        (Outcome(End.ABORTED, ErrorCode.TIMEOUT, "too late"), "ABORTED", Level.ERROR),
        (Rejection(ErrorCode.DOCK_BUSY, "busy"), "REJECTED", Level.WARN),
    ],
)
def test_what_becomes_of_a_goal_is_told(event: Command | Outcome | Rejection, stage: str, level: Level) -> None:
    report = report_on(event, "the-goal")
    assert report.level is level
    assert report.values() == {
        "stage": stage,
        "error_code": event.error_code.value,
        "error_msg": event.error_msg,
        "goal_id": "the-goal",
        "error_number": str(event.error_code.number),
        "retries": "0",
        "doubts": "",
    }


def test_before_the_first_goal_nothing_is_wrong() -> None:
    assert Report().values() == {
        "stage": "IDLE",
        "error_code": "NONE",
        "error_msg": "",
        "goal_id": "",
        "error_number": "0",
        "retries": "0",
        "doubts": "",
    }
    assert Report().message == "idle"


def test_the_message_is_the_reason_if_there_is_one() -> None:
    assert report_on(Rejection(ErrorCode.DOCK_BUSY, "busy"), "x").message == "busy"
    assert report_on(Command(Stage.WAIT_FOR_BATTERY, Velocity()), "x").message == "wait for battery"


def test_the_report_on_the_end_of_a_goal_names_what_seemed_wrong_on_the_way() -> None:
    docked = report_on(Outcome(End.SUCCEEDED, doubts=("another marker was seen", "it was hit twice")), "x")
    assert docked.values()["doubts"] == "another marker was seen; it was hit twice"
    assert docked.message == "succeeded", "it is no error"
