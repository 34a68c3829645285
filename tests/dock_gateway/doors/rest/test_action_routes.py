"""`/actions/…/goals`: what is sent, and when it is recorded."""

from types import SimpleNamespace
from typing import Any
from unittest.mock import AsyncMock

import pytest

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import InvalidField
from dock_gateway.core.goal import GoalStatus
from dock_gateway.doors.rest.action_routes import send_action_goal
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from tests.support.history import make_goal
from tests.support.requests import request


def having(action: Any) -> Parts:
    """A gateway with one action."""

    async def find(name: str) -> Any:
        assert name == action.name
        return action

    actions: Any = SimpleNamespace(find=find)
    return Parts({ActionRegistry: actions})


async def test_no_goal_is_sent_for_an_empty_body() -> None:
    action: Any = SimpleNamespace(name="/fibonacci", read_goal=AsyncMock(side_effect=lambda value: value))
    with pytest.raises(InvalidField):
        await send_action_goal("fibonacci", request(b""), having(action), ANYBODY)


async def test_a_goal_that_is_waited_for_is_recorded_as_soon_as_it_is_accepted() -> None:
    """The gateway may be killed before the goal ends."""
    recorded: list[int] = []

    async def submit(*_: object) -> Any:
        return make_goal(1, GoalStatus.EXECUTING)

    async def record(status: int) -> None:
        recorded.append(status)

    async def wait_terminal(*_: object) -> None:
        assert recorded == [202]
        recorded.append(0)

    action: Any = SimpleNamespace(
        name="/robot1/spin",
        read_goal=AsyncMock(side_effect=lambda value: value),
        submitter=SimpleNamespace(submit=submit),
        tracker=SimpleNamespace(wait_terminal=wait_terminal),
    )
    asked = request(b"{}", [(b"prefer", b"wait=30")])
    asked.scope["audit"].record = record
    await send_action_goal("robot1/spin", asked, having(action), ANYBODY)
    assert recorded == [202, 0]
    assert asked.scope["audit"].fields == {
        "robot": "/robot1",
        "action_name": "/robot1/spin",
        "goal_id": "goal-0001",
    }
