"""The services that a viewer is offered: those of the actions follow the robots, and nothing is done twice."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.graph import GraphScan
from dock_gateway.extensions.foxglove.services import FoxgloveServices
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.graph.parameters import Parameters
from dock_gateway.graph.service_calls import ServiceCalls

FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"


def action(number: int) -> Any:
    state = SimpleNamespace(available=True)
    return SimpleNamespace(
        name=f"/robot{number}/fibonacci", type=FIBONACCI, verb=None, watch=SimpleNamespace(state=state)
    )


def services(actions: list[Any]) -> FoxgloveServices:
    parts: Any = {ActionRegistry: SimpleNamespace(all=lambda: actions), ServiceCalls: None, Parameters: None}
    return FoxgloveServices(parts, SimpleNamespace(grant=Grant(Role.AGENT)))  # type: ignore[arg-type]


async def test_they_follow_the_actions() -> None:
    actions, seen = [action(1), action(2)], GraphScan()
    offered = services(actions)
    new, gone = await offered.update(seen)
    of_one = {f"/robot1/fibonacci/{verb}" for verb in ("send_goal", "cancel_goal", "get_result")}
    assert of_one < {each.name for each in new}
    assert not gone
    actions[0].watch.state.available = False
    new, gone = await offered.update(seen)
    assert (new, {each.name for each in gone}) == ([], of_one)
    actions[0].watch.state.available = True
    new, gone = await offered.update(GraphScan())
    assert ({each.name for each in new}, gone) == (of_one, [])


async def test_as_long_as_nothing_changes_nothing_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    """A viewer is one of hundreds, each of which looks every other second."""
    seen, offered = GraphScan(), services([action(number) for number in range(100)])
    assert (await offered.update(seen))[0]

    def fail(*_: object) -> None:
        raise AssertionError("it is done again")

    monkeypatch.setattr(asyncio, "to_thread", fail)
    monkeypatch.setattr(FoxgloveServices, "_of_action", fail)
    for _ in range(10):
        assert await offered.update(seen) == ([], [])
