"""`/actions/…/goals`: what is sent, and when it is recorded."""

from types import SimpleNamespace
from typing import Any
from unittest.mock import AsyncMock

import pytest
from fastapi import Request

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import InvalidField, MalformedRequest
from dock_gateway.core.goal import GoalStatus
from dock_gateway.core.request import PERMIT
from dock_gateway.doors.rest.sent_goals import ACTION, Target, routes_of
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from tests.support.history import HistoryInMemory, make_goal
from tests.support.permits import permit
from tests.support.requests import request


async def send(name: str, asked: Request, parts: Parts) -> None:
    """Send a goal to an action."""
    (endpoint,) = (route.endpoint for route in routes_of(ACTION).routes if route.name == "send_action_goal")
    await endpoint(asked, parts, ANYBODY, Target(action=f"/{name}"))


def having(action: Any) -> Parts:
    """A gateway with one action."""

    async def find(name: str) -> Any:
        assert name == action.name
        return action

    actions: Any = SimpleNamespace(find=find)
    return Parts({ActionRegistry: actions, GoalDocuments: GoalDocuments(HistoryInMemory())})


@pytest.mark.parametrize(
    ("body", "read"), [(b"", [None]), (b"{}", [{}]), (b'{"order": 3}', [{"order": 3}]), (b"null", []), (b"{", [])]
)
async def test_what_the_action_is_given_to_read(body: bytes, read: list[Any]) -> None:
    given: list[Any] = []

    async def read_goal(goal: object, path: str) -> None:
        assert path == ""
        given.append(goal)
        raise InvalidField([])

    with pytest.raises((InvalidField, MalformedRequest)):
        await send("fibonacci", request(body), having(SimpleNamespace(name="/fibonacci", read_goal=read_goal)))
    assert given == read


async def test_a_goal_that_is_waited_for_is_recorded_as_soon_as_it_is_accepted() -> None:
    """The gateway may be killed before the goal ends."""
    recorded: list[int] = []

    async def submit(*_: object, **__: object) -> Any:
        return make_goal(1, GoalStatus.EXECUTING)

    async def record(status: int) -> None:
        recorded.append(status)

    async def wait_terminal(*_: object) -> None:
        assert recorded == [202]
        recorded.append(0)

    action: Any = SimpleNamespace(
        name="/robot1/spin",
        read_goal=AsyncMock(),
        submitter=SimpleNamespace(submit=submit),
        tracker=SimpleNamespace(wait_terminal=wait_terminal),
    )
    asked = request(b"{}", [(b"prefer", b"wait=30")])
    asked.scope["audit"].record = record
    PERMIT.set(request_permit := permit())
    await send("robot1/spin", asked, having(action))
    assert recorded == [202, 0]
    assert asked.scope["audit"].fields == {"goal_id": "goal-0001"}
    assert request_permit.action == "/robot1/spin"
