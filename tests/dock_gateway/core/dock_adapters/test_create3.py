"""The Create 3's docking actions: no goal fields, and the result says whether the robot is docked."""

from typing import Any

import pytest

from dock_gateway.core.dock_adapters.create3 import DOCK, UNDOCK
from dock_gateway.core.errors import InvalidField
from dock_gateway.core.goal import GoalStatus

S = GoalStatus


def test_goals_have_no_fields() -> None:
    assert DOCK.goal(DOCK.default, "home") == {}, "the default dock is for others"
    assert DOCK.goal({"desired_battery_state": {"power_supply_status": 1, "location": ""}}) == {}
    assert UNDOCK.goal({"desired_battery_state": {"power_supply_status": 3}}) == {}
    assert DOCK.goal({"typo": 1}) == {"typo": 1}, "the codec refuses it"


@pytest.mark.parametrize(
    "request_",
    [
        {"dock_id": "home"},
        {"desired_battery_state": {"power_supply_status": 0, "location": "home"}},
        {"desired_battery_state": {"power_supply_status": 2}},
    ],
)
def test_requests_that_it_cannot_take(request_: dict[str, Any]) -> None:
    with pytest.raises(InvalidField):
        DOCK.goal(request_)


def test_the_stage_is_whether_it_sees_the_dock() -> None:
    assert DOCK.progress({"sees_dock": False}).stage == "INITIAL_PERCEPTION"
    assert DOCK.progress({"sees_dock": True}).stage == "CONTROLLING"
    assert not UNDOCK.tells_stage


@pytest.mark.parametrize(
    ("adapter", "status", "docked", "ended", "code"),
    [
        (DOCK, S.SUCCEEDED, True, S.SUCCEEDED, None),
        (DOCK, S.SUCCEEDED, False, S.ABORTED, "failed_to_dock"),
        (DOCK, S.ABORTED, False, S.ABORTED, "failed_to_dock"),
        (DOCK, S.CANCELED, False, S.CANCELED, None),
        (UNDOCK, S.SUCCEEDED, False, S.SUCCEEDED, None),
        (UNDOCK, S.SUCCEEDED, True, S.ABORTED, "failed_to_undock"),
        (UNDOCK, S.ABORTED, True, S.ABORTED, "failed_to_undock"),
    ],
)
def test_outcomes(adapter: Any, status: GoalStatus, docked: bool, ended: GoalStatus, code: str | None) -> None:
    outcome = adapter.outcome(status, {"is_docked": docked})
    assert (outcome.status, outcome.error and outcome.error.code) == (ended, code)
