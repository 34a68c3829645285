"""However many goals come and go, what is held in memory of them stays what it was: the port is a fake."""

import asyncio
import uuid
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import GatewayError, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalError, GoalStatus, ResultAnswer
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.action import Action
from dock_gateway.goals.action_context import ActionContext
from dock_gateway.goals.limits import GoalLimits
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.ros.action_port import CancelAnswer
from dock_gateway.ros.status import StatusReport
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from tests.support.action_port import FakeActionPort
from tests.support.calls import FakeCall
from tests.support.history import EVERYTHING, locked, make_event, make_goal, open_at, written
from tests.support.sizes import sizes
from tests.support.waiting import until

ROUND = 40
LIMITS = GoalLimits(
    ended=10, lost=10, unwanted=10, end_stamps=10, result_wait=0.01, late_result=0.05, batch_interval=0.01
)
ACCEPTED = SimpleNamespace(accepted=True, stamp=SimpleNamespace(sec=1, nanosec=0))
REJECTED = SimpleNamespace(accepted=False)


class Port(FakeActionPort):
    """An action server that answers as the test says, and a client that knows which requests it waits for."""

    def __init__(self) -> None:
        super().__init__()
        self.answer: Any = ACCEPTED
        self.result: ResultAnswer | None = ResultAnswer(GoalStatus.SUCCEEDED, b"{}")
        self.waiting: set[FakeCall] = set()

    def _call(self, answer: Any) -> FakeCall:
        call = FakeCall()
        self.waiting.add(call)
        call.response.add_done_callback(lambda _: self.waiting.discard(call))
        if answer is not None:
            call.response.set_result(answer)
        return call

    def send(self, goal_id: str, message: str) -> FakeCall:
        return self._call(self.answer)

    def request_result(self, goal_id: str) -> FakeCall:
        return self._call(self.result)

    async def cancel(self, goal_id: str | None, timeout: float) -> CancelAnswer:
        return CancelAnswer(frozenset({goal_id or ""}), 0)


class Scene:
    def __init__(self, history: History) -> None:
        self.port = Port()
        self.fanout = Fanout(queue_limit=10, keep=history.record_event, recent=10)
        self.history = history
        self.reasons: PendingFacts[GoalError] = PendingFacts(0.01, limit=10)
        settings = Settings(accept_timeout=0.01, ping_interval=0.1, max_pending_goals=1000)
        interlock = Interlock(self.fanout, LatchFile(settings.stop_file))
        port: Any = self.port
        context = ActionContext(settings, self.fanout, history, self.reasons, interlock, LIMITS)
        self.action = Action(port, context, pinned=True)

    def new(self, status: GoalStatus = GoalStatus.PENDING) -> Goal:
        goal = Goal(str(uuid.uuid4()), "/dock", "pkg/action/Dock", utc_now())
        goal.status = status
        return goal

    async def send(self) -> None:
        with suppress(GatewayError):
            await self.action.submitter.submit("{}", str(uuid.uuid4()), sender=ANYBODY)

    # What may become of a goal:

    async def succeeds(self) -> None:
        await self.send()

    async def is_rejected(self) -> None:
        self.port.answer = REJECTED
        await self.send()

    async def is_never_answered(self) -> None:
        self.port.answer = None
        await self.send()

    async def ends_before_it_is_answered(self) -> None:
        self.port.answer = None
        sending = asyncio.create_task(self.send())
        live = self.action.tracker.live
        await until(lambda: bool(live))
        self.action.tracker.on_status([StatusReport(next(iter(live)), GoalStatus.SUCCEEDED, 1)], 1)
        await sending

    async def has_no_result(self) -> None:
        self.port.result = None
        goal = self.new()
        self.action.tracker.on_status([StatusReport(goal.goal_id, GoalStatus.SUCCEEDED, 1)], 1)

    async def is_lost(self) -> None:
        self.port.result = None
        goal = self.new()
        self.action.tracker.on_status([StatusReport(goal.goal_id, GoalStatus.EXECUTING, 1)], 1)
        await until(lambda: goal.goal_id in self.action.tracker.live)
        self.action.tracker.lose(self.action.tracker.live[goal.goal_id], GoalError("action_server_lost", "gone"))

    async def is_canceled_while_nobody_knows_it(self) -> None:
        for status in (GoalStatus.LOST, GoalStatus.EXECUTING):
            goal = self.new(status)
            self.history.record(goal)
            await self.action.canceler.cancel(goal)

    async def is_waited_for_in_vain(self) -> None:
        await self.action.tracker.wait_terminal(self.new(GoalStatus.EXECUTING), 0.01)

    async def has_a_reason_and_never_comes(self) -> None:
        self.reasons.put(self.new().goal_id, GoalError("goal_rejected", "why"))

    @property
    def sizes(self) -> Counter[str]:
        found = sizes(self.action) + sizes(self.fanout) + sizes(self.history)
        found["requests that wait for an answer"] = len(self.port.waiting)
        found["tasks"] = len(asyncio.all_tasks())
        return found


@pytest.fixture
async def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Scene]:
    monkeypatch.setattr("dock_gateway.storage.keys.MAX_KEYS", 10)
    async with open_at(f"sqlite:///{tmp_path}/history.db", tmp_path) as history:
        scene = Scene(history)
        yield scene
        await scene.action.close()


FATES = [
    Scene.succeeds,
    Scene.is_rejected,
    Scene.is_never_answered,
    Scene.ends_before_it_is_answered,
    Scene.has_no_result,
    Scene.is_lost,
    Scene.is_canceled_while_nobody_knows_it,
    Scene.is_waited_for_in_vain,
    Scene.has_a_reason_and_never_comes,
]


@pytest.mark.parametrize("fate", FATES)
async def test_goals_leave_nothing_behind(scene: Scene, fate: Callable[[Scene], Awaitable[None]]) -> None:
    async def round_of_goals() -> None:
        for _ in range(ROUND):
            await fate(scene)

    await round_of_goals()
    before = scene.sizes

    def grown() -> dict[str, tuple[int, int]]:
        now = scene.sizes
        return {place: (before[place], now[place]) for place in now if now[place] > before[place] + ROUND // 4}

    await round_of_goals()
    with suppress(AssertionError):
        await until(lambda: not grown(), 5)
    assert grown() == {}


async def test_a_goal_that_is_spooled_leaves_nothing_pending(tmp_path: Path) -> None:
    path = tmp_path / "history.db"
    async with open_at(f"sqlite:///{path}", tmp_path, max_waiting=10) as history:
        with locked(str(path)):
            for number in range(50):
                await history.add(make_goal(number))
            await until(lambda: history.stats().waiting <= 10)
            assert sizes(history)["History.writer._new_goals._pending"] == 0
        await written(history)
    assert max(sizes(history).values()) < 10


async def test_what_nothing_takes_is_limited(tmp_path: Path) -> None:
    path = tmp_path / "history.db"
    (tmp_path / "spool").touch()
    async with open_at(f"sqlite:///{path}", tmp_path, max_waiting=10) as history:
        await history.add(make_goal(0))
        with locked(str(path)):
            for number in range(1, 100):
                history.record(make_goal(number, origin="external"))
                history.record_event(make_event(number))
                if number % 10 == 0:
                    with pytest.raises(Unavailable):  # and stays refused, whatever the database takes later
                        await history.add(make_goal(1000 + number, GoalStatus.PENDING))
            running = [make_goal(2000 + number, GoalStatus.EXECUTING) for number in range(20)]
            for goal in running:
                history.record(goal)
            # A transaction that was begun before holds on to what it writes until it has failed.
            await until(lambda: max(sizes(history).values()) <= 10 + 10 + len(running))
        await until(lambda: not history.stats().waiting)
        assert [await history.get(f"goal-{1000 + number:04d}") for number in range(10, 100, 10)] == [None] * 9
        assert len(await history.unfinished()) == len(running)
        assert not (
            await history.events_after("0", goal_id=None, action_name=None, topics=EVERYTHING, limit=9)
        ).complete
