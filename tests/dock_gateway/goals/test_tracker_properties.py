"""Whatever ROS says of goals, in any order, and however often the gateway is started again: each goal ends once."""

import asyncio
from collections import Counter
from datetime import UTC, datetime
from typing import Any

import orjson
from hypothesis import given, settings
from hypothesis import strategies as st

from dock_gateway.core.event import Event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import FROM_ROS, Goal, GoalError, GoalStatus
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.goal_machine import GoalMachine
from dock_gateway.goals.limits import GoalLimits
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.ros.status import StatusReport
from tests.support.action_port import FakeActionPort
from tests.support.history import HistoryInMemory
from tests.support.tracking import A, B

LIMITS = GoalLimits(result_wait=0.01, ask_again_after=0.005, end_stamp_wait=0.001, patience=0.01, lookup_retry=0.002)
GOALS = st.sampled_from([A, B])
STATUSES = st.sampled_from(sorted(FROM_ROS.values()))
STEPS = st.one_of(
    st.tuples(st.just("send"), GOALS),
    st.tuples(st.just("status"), GOALS, STATUSES),
    st.tuples(st.just("feedback"), GOALS),
    st.tuples(st.just("answer"), GOALS, STATUSES | st.none()),
    st.tuples(st.just("lose"), GOALS),
    st.tuples(st.just("wait"), st.sampled_from([0.0, 0.02])),
    st.tuples(st.just("restart")),
)


class World:
    """A gateway that is started again and again, its history, and all that readers were told."""

    def __init__(self) -> None:
        self.told: list[Event] = []
        self.history = HistoryInMemory()
        self.start()

    def start(self) -> None:
        newest = max((event.id or "" for event in self.told), default="")
        fanout = Fanout(queue_limit=10, keep=self.keep, newest=newest)
        self.port = FakeActionPort()
        port: Any = self.port
        self.tracker = GoalTracker(port, fanout, self.history, PendingFacts(0.001), limits=LIMITS)

    def keep(self, event: Event) -> None:
        self.told.append(event)
        self.history.record_event(event)

    async def restart(self) -> None:
        await self.tracker.close()
        self.start()
        for goal in await self.history.unfinished():
            self.tracker.take_up(goal)

    async def step(self, name: str, *details: Any) -> None:
        if name == "restart":
            await self.restart()
        elif name == "wait":
            await asyncio.sleep(details[0])
        else:
            await self.step_of(name, *details)

    async def step_of(self, name: str, goal_id: str, status: GoalStatus | None = None) -> None:
        live = self.tracker.live.get(goal_id)
        if name == "send":
            if live is None and await self.history.get(goal_id) is None:
                goal = Goal(goal_id, "/dock", "pkg/action/Dock", datetime.now(UTC))
                await self.history.add(goal)
                self.tracker.apply(GoalMachine.add, goal)
        elif name == "status" and status is not None:
            self.tracker.on_status([StatusReport(goal_id, status, 1)], 2)
        elif name == "feedback":
            self.tracker.on_feedback(goal_id, b"{}", 3)
        elif name == "lose" and live is not None:
            self.tracker.lose(live, GoalError("action_server_lost", "silent"))
        elif name == "answer":
            calls = self.port.results.get(goal_id, [])
            if calls and not calls[-1].response.done():
                self.port.answer_result(goal_id, status, b'{"n":1}')


async def run(steps: list[tuple[Any, ...]]) -> None:
    world = World()
    final: dict[str, tuple[Any, ...]] = {}
    for step in steps:
        await world.step(*step)
        for goal_id in (A, B):
            goal = await world.history.get(goal_id)
            if goal is not None and goal.status.final and goal.result is not None:
                facts = (goal.status, goal.result, goal.finished_at)
                assert final.setdefault(goal_id, facts) == facts, "a goal that has ended does not change"
    await asyncio.sleep(0.05)
    await world.tracker.close()
    documents = [orjson.loads(event.data) for event in world.told]
    ids = [event.id for event in world.told]
    assert ids == sorted(set(ids)), "ids grow, over restarts too"
    states = Counter(d["goal_id"] for d in documents if d["type"] == "status" and GoalStatus(d["status"]).final)
    results = Counter(d["goal_id"] for d in documents if d["type"] == "result")
    assert max([*states.values(), *results.values()], default=1) == 1, documents
    for goal_id, count in states.items():
        last = next(d for d in reversed(documents) if d["goal_id"] == goal_id)
        assert results[goal_id] == count or last["status"] == "rejected"
        assert last["type"] == "result", "nothing is told of a goal after its end"
        kept = await world.history.get(goal_id)
        assert kept is not None
        assert kept.status.value == last["status"]
        assert (kept.error is None) or kept.status is not GoalStatus.SUCCEEDED or kept.result is None


@settings(max_examples=100)
@given(st.lists(STEPS, max_size=30))
def test_each_goal_ends_once(steps: list[tuple[Any, ...]]) -> None:
    asyncio.run(run(steps))
