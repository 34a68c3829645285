"""Whether a goal's action server is there. The port is a fake; tests/system has real servers that die and freeze."""

import asyncio
import logging
import time
from datetime import UTC, datetime
from typing import Any

import pytest

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.tasks import PendingFacts, cancel
from dock_gateway.goals.goal_machine import GoalMachine
from dock_gateway.goals.limits import GoalLimits
from dock_gateway.goals.liveness import ServerState, ServerWatch
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.settings import Settings
from tests.support.action_port import FakeActionPort
from tests.support.history import HistoryInMemory
from tests.support.waiting import until

A = "aaaaaaaa-0000-4000-8000-000000000000"
S = GoalStatus


class Scene:
    def __init__(self, **settings: Any) -> None:
        self.port = FakeActionPort()
        self.tracker = GoalTracker(self.port, Fanout(queue_limit=10), HistoryInMemory(), PendingFacts(0.01))  # type: ignore[arg-type]
        self.states: list[ServerState] = []
        self.watch = ServerWatch(
            self.tracker,
            Settings(**{"ping_interval": 0.01} | settings),
            self.states.append,
            limits=GoalLimits(gone_grace=0.05, recheck=0.01),
        )
        self.goal = Goal(A, "/dock", "pkg/action/Dock", datetime.now(UTC))
        self.tracker.apply(GoalMachine.add, self.goal)
        self.tracker.apply(GoalMachine.move, self.goal, S.EXECUTING)

    async def look_after(self, seconds: float) -> None:
        await asyncio.sleep(seconds)
        await self.watch.check()


@pytest.fixture
async def scene() -> Scene:
    return Scene()


async def test_a_goal_is_lost_when_its_server_has_left_and_is_silent(scene: Scene) -> None:
    await scene.watch.check()
    assert scene.states[-1] == ServerState("/dock", "pkg/action/Dock", available=True, answering=True)
    scene.port.on_graph = False
    await scene.watch.check()
    assert scene.states[-1] == ServerState("/dock", "pkg/action/Dock", available=False, answering=False)
    assert scene.goal.status is S.EXECUTING
    await scene.look_after(0.06)
    assert scene.goal.status is S.LOST


async def test_a_goal_that_is_heard_of_is_not_lost_though_its_server_is_not_on_the_graph(
    scene: Scene, caplog: pytest.LogCaptureFixture
) -> None:
    scene.port.on_graph = False
    await scene.watch.check()
    with caplog.at_level(logging.WARNING):
        for number in range(3):
            await asyncio.sleep(0.04)
            scene.tracker.on_feedback(A, b"{}", number + 1)
            await scene.watch.check()
    assert scene.goal.status is S.EXECUTING
    assert [record.message for record in caplog.records] == [
        "/dock: messages arrive, but requests do not reach the action server"
    ]
    await scene.look_after(0.06)
    assert scene.goal.status is S.LOST
    scene.port.on_graph = True
    scene.tracker.on_feedback(A, b"{}", 9)
    await scene.watch.check()
    assert scene.goal.status is S.EXECUTING


async def test_a_server_that_did_not_answer_is_asked_again_soon_though_it_is_seldom_asked() -> None:
    """One that has just appeared may not answer the first ping, and is not on the graph of a gateway that starts."""
    scene = Scene(ping_interval=1000, stalled_after=2000, lost_after=3000)
    scene.tracker.last_heard = float("-inf")
    scene.port.on_graph = scene.port.answers = False
    watching = asyncio.create_task(scene.watch.run())
    await asyncio.sleep(0)
    assert not scene.watch.ready
    scene.port.on_graph = True
    await until(lambda: scene.port.pings > 1)
    scene.port.answers = True
    await until(lambda: scene.watch.ready)
    pings = scene.port.pings
    await asyncio.sleep(0.1)
    assert scene.port.pings == pings
    await cancel(watching)


async def test_no_goal_is_sent_while_there_are_two_servers(scene: Scene) -> None:
    await scene.watch.check()
    await scene.watch.require()
    scene.port.servers, scene.port.answered_twice_at = {"a", "b"}, time.monotonic()
    await scene.watch.check()
    assert scene.states[-1] == ServerState("/dock", "pkg/action/Dock", available=True, answering=True, duplicate=True)
    assert not scene.watch.ready
    with pytest.raises(Conflict) as refused:
        await scene.watch.require()
    assert refused.value.code == "duplicate_action_server"
    scene.port.servers = set()
    await scene.watch.require()
    assert not scene.states[-1].duplicate


async def test_no_goal_is_sent_to_a_server_that_does_not_answer(scene: Scene) -> None:
    """Nothing was sent, so that the same request may be repeated."""
    scene.port.answers, scene.tracker.last_heard = False, float("-inf")
    with pytest.raises(Unavailable) as refused:
        await scene.watch.require()
    assert (refused.value.code, refused.value.status) == ("action_server_unresponsive", 503)
    assert "goal_id" not in refused.value.extra
    scene.port.answers = True
    await scene.watch.require()


async def test_two_servers_can_be_allowed() -> None:
    scene = Scene(allow_duplicate_servers=True)
    scene.port.servers, scene.port.answered_twice_at = {"a", "b"}, time.monotonic()
    await scene.watch.check()
    assert scene.states[-1].duplicate
    await scene.watch.require()


async def test_where_there_may_be_two_servers_they_are_asked_each_time(scene: Scene) -> None:
    scene.tracker.heard()
    await scene.watch.check(ping=False)
    assert scene.port.pings == 0
    scene.port.servers = {"a", "b"}
    await scene.watch.check(ping=False)
    assert scene.port.pings == 1
    assert not scene.states[-1].duplicate
