"""A goal to dock whose server has left goes to another action of the robot, unless a stop came first."""

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.access import ANYBODY, Principal
from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.request import PERMIT
from dock_gateway.goals.action_context import ActionContext
from dock_gateway.goals.delivery import GoalDelivery
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.goal_machine import GoalChange
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.operations.goals import SendGoal, send_goal
from dock_gateway.settings import Settings
from tests.support.history import make_goal
from tests.support.permits import permit


class FakeAction:
    """An action off the graph; `submit` fails if it has no server, and a stop may come meanwhile."""

    on_graph = False

    def __init__(self, name: str, *, server: bool, stopped: bool = False) -> None:
        self.name = name
        nothing: Any = None
        tracker: Any = SimpleNamespace(on={GoalChange.RETIRED: []}, port=SimpleNamespace(action_name="/dock"))
        interlock: Any = SimpleNamespace(holds=lambda _: False)
        canceler: Any = SimpleNamespace(stop=lambda: None)
        self.delivery = GoalDelivery(
            ActionContext(Settings(), nothing, nothing, nothing, interlock), tracker, nothing, canceler
        )
        self.submitter = self
        self.server = server
        self.stopped = stopped
        self.sent: list[Any] = []

    def read_docking_request(self, request: object, path: str) -> object:
        return request, path

    async def submit(self, message: object, key: str | None, *, sender: Principal) -> Any:
        if self.stopped:
            self.delivery.stop()
        if not self.server:
            raise Unavailable("there is no server")
        self.sent.append((message, key))
        return make_goal(1)


async def send(*found: Any) -> Any:
    """Send a goal to the first action, while the second one is picked. Return the action that the audit log has."""
    picked = iter(found)

    async def find(*_: object) -> Any:
        return next(picked)

    async def require(*_: object) -> None:
        """Have every dock."""

    actions: Any = SimpleNamespace(find_docking=find)
    hints: Any = SimpleNamespace(hinting=lambda *_: nullcontext())
    docks: Any = SimpleNamespace(require=require)
    request_permit = permit()
    PERMIT.set(request_permit)
    parts = Parts({ActionRegistry: actions, DockingHints: hints, Docks: docks})
    await send_goal(parts, ANYBODY, SendGoal(None, key="key"))
    return request_permit.action


async def test_another_action_gets_the_goal_of_one_without_a_server() -> None:
    first, other = FakeAction("/dock", server=False), FakeAction("/dock_robot", server=True)
    assert await send(first, other) == "/dock_robot"
    assert other.sent == [((None, ""), "key")]


async def test_a_stop_that_comes_meanwhile_keeps_it_from_being_sent() -> None:
    first, other = FakeAction("/dock", server=False, stopped=True), FakeAction("/dock_robot", server=True)
    with pytest.raises(Conflict) as refused:
        await send(first, other)
    assert refused.value.code == "stopped"
    assert other.sent == []
