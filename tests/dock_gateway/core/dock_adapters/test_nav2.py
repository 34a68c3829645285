"""nav2's docking actions: goals, stages and outcomes."""

from typing import Any

import pytest

from dock_gateway.core.dock_adapters.nav2 import DOCK, DOCK_ERRORS, MAX_MESSAGE, UNDOCK, UNDOCK_ERRORS
from dock_gateway.core.errors import InvalidField
from dock_gateway.core.goal import GoalStatus

S = GoalStatus
POSE = {"header": {"frame_id": "map"}}
CHARGING = {"power_supply_status": 1, "location": ""}


@pytest.mark.parametrize(
    ("request_", "default_dock", "goal"),
    [
        ({}, "", {}),
        ({}, "home", {"dock_id": "home"}),
        ({"dock_id": "a"}, "home", {"dock_id": "a"}),
        ({"desired_battery_state": CHARGING}, "home", {"dock_id": "home"}),
        ({"desired_battery_state": {**CHARGING, "location": "a"}}, "home", {"dock_id": "a"}),
        ({"dock_pose": POSE}, "home", {"dock_pose": POSE, "use_dock_id": False}),
        ({"dock_pose": POSE, "use_dock_id": True}, "home", {"dock_pose": POSE, "use_dock_id": True, "dock_id": "home"}),
        ({"dock_pose": POSE, "dock_id": "a", "use_dock_id": False}, "", None),
        ({"max_staging_time": 5.0, "navigate_to_staging_pose": False}, "", None),
    ],
)
def test_goals(request_: dict[str, Any], default_dock: str, goal: dict[str, Any] | None) -> None:
    assert DOCK.goal(request_, default_dock) == (request_ if goal is None else goal)


@pytest.mark.parametrize(
    ("request_", "path"),
    [
        ({"dock_id": " "}, "dock_id"),
        ({"use_dock_id": False}, "dock_pose"),
        ({"dock_id": "a", "dock_pose": POSE}, "use_dock_id"),
        ({"dock_id": "a", "desired_battery_state": {"location": "b"}}, "desired_battery_state.location"),
        ({"desired_battery_state": {"power_supply_status": 3}}, "desired_battery_state.power_supply_status"),
    ],
)
def test_requests_that_nav2_cannot_take(request_: dict[str, Any], path: str) -> None:
    with pytest.raises(InvalidField) as refused:
        DOCK.goal(request_)
    assert refused.value.extra["errors"][0]["path"] == path


def test_undocking() -> None:
    assert UNDOCK.default == {}
    assert UNDOCK.goal({"dock_type": "a", "desired_battery_state": {"power_supply_status": 2}}) == {"dock_type": "a"}
    for request in ({"dock_id": "a"}, {"desired_battery_state": {"power_supply_status": 1}}):
        with pytest.raises(InvalidField):
            UNDOCK.goal(request)


def test_stages() -> None:
    told = [DOCK.progress({"state": state, "num_retries": 2}) for state in range(7)]
    names = [None, "NAV_TO_STAGING_POSE", "INITIAL_PERCEPTION", "CONTROLLING", "WAIT_FOR_CHARGE", "RETRY", None]
    assert told == [(name, 2) for name in names]
    assert DOCK.progress({}) == (None, None)


def outcome(adapter: Any, status: GoalStatus, **result: Any) -> tuple[GoalStatus, str | None]:
    ended = adapter.outcome(status, {"success": False, "error_code": 0, "error_msg": "", "num_retries": 3} | result)
    return ended.status, ended.error and ended.error.code


def test_outcomes() -> None:
    assert outcome(DOCK, S.SUCCEEDED, success=True) == (S.SUCCEEDED, None)
    assert outcome(DOCK, S.CANCELED) == (S.CANCELED, None)
    assert outcome(DOCK, S.SUCCEEDED, error_code=906) == (S.ABORTED, "failed_to_charge"), "success is false"
    for adapter, errors in ((DOCK, DOCK_ERRORS), (UNDOCK, UNDOCK_ERRORS)):
        found = {number: outcome(adapter, S.ABORTED, error_code=number) for number in errors}
        assert found == {number: (S.ABORTED, code) for number, (code, _) in errors.items()}
    assert outcome(UNDOCK, S.ABORTED, success=True) == (S.ABORTED, "goal_aborted"), "as for a robot off its dock"
    assert outcome(DOCK, S.ABORTED, error_code=3) == (S.ABORTED, "unknown")


def test_the_result_has_the_retries_and_the_servers_own_words() -> None:
    ended = DOCK.outcome(S.ABORTED, {"success": False, "error_code": 904, "error_msg": "x" * 600, "num_retries": 3})
    assert ended.retries == 3
    assert ended.error is not None
    assert ended.error.detail == f"the dock was not detected: {'x' * MAX_MESSAGE}"
    older = DOCK.outcome(S.ABORTED, {"success": False, "error_code": 904, "num_retries": 0})
    assert (older.error and older.error.detail) == "the dock was not detected", "older servers have no error_msg"
