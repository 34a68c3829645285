"""An action reads the goals that clients send it."""

import re
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.errors import Conflict, InvalidField
from dock_gateway.goals.action import Action


def action_with(stop: Any) -> Any:
    """An action whose goals are read while `stop` is done."""
    delivery = SimpleNamespace(stops=0)

    def require(stops: int) -> None:
        assert stops == 0
        raise Conflict("a stop was requested first", code="stopped")

    async def read(value: object, path: str) -> object:
        stop(delivery)
        return value, path

    delivery.require_no_stop_since = require
    return SimpleNamespace(delivery=delivery, port=SimpleNamespace(goal_codec=SimpleNamespace(read=read)))


async def test_a_stop_while_a_long_goal_is_read_keeps_it_from_being_sent() -> None:
    with pytest.raises(Conflict) as refused:
        await Action.read_goal(action_with(lambda delivery: setattr(delivery, "stops", 1)), {}, "goal")
    assert refused.value.code == "stopped"


async def test_a_goal_that_no_stop_precedes_is_read() -> None:
    assert await Action.read_goal(action_with(lambda _: None), {"order": 3}, "goal") == ({"order": 3}, "goal")


async def test_a_goal_that_is_not_given_is_the_default_only_where_a_robot_docks() -> None:
    def docking(default: object) -> Any:
        adapter = SimpleNamespace(default=default, takes=())
        adapter.goal = lambda request, dock, path: {**request, "dock_id": dock}
        codec = SimpleNamespace(parse=lambda value, path, further: (value, path))
        action: Any = SimpleNamespace(adapter=adapter, port=SimpleNamespace(goal_codec=codec), default_dock="home")
        return action

    assert Action.read_docking_request(docking({}), None, "goal") == ({"dock_id": "home"}, "goal")
    with pytest.raises(InvalidField, match=re.escape("{} for the defaults")):
        Action.read_docking_request(docking(None), None, "goal")
    with pytest.raises(InvalidField, match=re.escape("{} for the defaults")):
        await Action.read_goal(action_with(lambda _: None), None, "goal")
