"""A goal is stored, then sent, once for each key. Port and watch are fakes; tests/system has the real ones."""

import asyncio
from collections.abc import AsyncIterator
from types import SimpleNamespace

import orjson
import pytest

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.dock_adapters import charging_dock
from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.event import STATUS, event_id, nanoseconds, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.action_context import ActionContext, Gate
from dock_gateway.goals.cancellation import Canceler
from dock_gateway.goals.delivery import GoalDelivery
from dock_gateway.goals.goal_machine import GoalMachine
from dock_gateway.goals.submitter import Submitter
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.settings import Settings
from dock_gateway.storage import GoalFilter, HistoryStats, fingerprint_of
from tests.support.action_port import FakeActionPort
from tests.support.history import HistoryInMemory
from tests.support.waiting import until

ACCEPTED = SimpleNamespace(accepted=True, stamp=SimpleNamespace(sec=1, nanosec=0))
REJECTED = SimpleNamespace(accepted=False)


class OpenInterlock:
    """No stop is latched."""

    def require_released(self, action_name: str) -> None:
        pass

    def holds(self, action_name: str) -> bool:
        return False


class FakeWatch:
    ready = True

    async def require(self) -> None:
        pass


class GatedHistory(HistoryInMemory):
    """Stores a goal when the test opens the gate, or fails to."""

    def __init__(self) -> None:
        super().__init__()
        self.gate: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.reachable = True

    async def release(self, idempotency_key: str, goal_id: str) -> None:
        if not self.reachable:
            raise Unavailable("away", code="history_unavailable")
        await super().release(idempotency_key, goal_id)

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        await self.gate
        await super().add(goal, idempotency_key)

    def stats(self) -> HistoryStats:
        return HistoryStats(database_reachable=self.reachable)


class Scene:
    def __init__(self) -> None:
        self.port = FakeActionPort()
        self.history = GatedHistory()
        fanout = Fanout(queue_limit=100)
        self.tracker = GoalTracker(self.port, fanout, self.history, PendingFacts(0.01))  # type: ignore[arg-type]
        settings = self.settings = Settings(accept_timeout=5.0)
        self.interlock = Interlock(fanout, LatchFile(settings.stop_file))
        self.reasons: PendingFacts[GoalError] = PendingFacts(0.01)
        self.gates: list[Gate] = []
        canceler = Canceler(settings, self.tracker, self.interlock)
        delivery = GoalDelivery(
            ActionContext(settings, fanout, self.history, self.reasons, self.interlock, gates=self.gates),
            self.tracker,
            FakeWatch(),  # type: ignore[arg-type]
            canceler,
        )
        self.submitter = Submitter(settings, self.history, self.tracker, delivery, charging_dock.DOCK)
        self.delivery = delivery

    def submit(self, key: str | None = None, message: str = "{}") -> "asyncio.Task[Goal]":
        return asyncio.create_task(self.submitter.submit(message, key, sender=ANYBODY))

    def fail(self) -> None:
        self.history.gate.set_exception(Unavailable("full", code="history_unavailable"))


async def turns(count: int = 20) -> None:
    """Let everything that can go on go on."""
    for _ in range(count):
        await asyncio.sleep(0)


@pytest.fixture
async def scene() -> AsyncIterator[Scene]:
    scene = Scene()
    yield scene
    await scene.tracker.close()


@pytest.mark.parametrize("key", [None, "key"])
async def test_a_goal_is_stored_before_it_is_sent(scene: Scene, key: str | None) -> None:
    submission = scene.submit(key)
    await turns()
    assert not scene.port.sent
    scene.history.gate.set_result(None)
    await turns()
    scene.port.answer_goal(ACCEPTED)
    goal = await submission
    assert goal.status is GoalStatus.ACCEPTED
    assert await scene.history.get(goal.goal_id) is not None


async def test_a_goal_that_cannot_be_stored_is_not_sent(scene: Scene) -> None:
    submission = scene.submit()
    await turns()
    scene.fail()
    with pytest.raises(Unavailable) as refused:
        await submission
    assert refused.value.code == "history_unavailable"
    assert not scene.port.sent
    assert not scene.tracker.live


async def test_no_goal_is_sent_while_a_stop_is_latched(scene: Scene) -> None:
    scene.interlock.latch("/")
    with pytest.raises(Conflict) as refused:
        await scene.submit()
    assert refused.value.code == "stop_latched"
    assert not scene.port.sent


async def test_a_stop_while_a_goal_is_stored_keeps_it_from_being_sent(scene: Scene) -> None:
    submission = scene.submit("key")
    await turns()
    scene.interlock.latch("/")
    scene.history.gate.set_result(None)
    with pytest.raises(Conflict) as refused:
        await submission
    assert refused.value.code == "stopped"
    assert not scene.port.sent
    await scene.interlock.release("/")
    submission = scene.submit("key")
    await turns()
    scene.port.answer_goal(ACCEPTED)
    assert (await submission).status is GoalStatus.ACCEPTED


@pytest.mark.parametrize("code", ["action_server_unavailable", "ros_unavailable"])
async def test_a_goal_that_was_never_sent_is_tried_anew(scene: Scene, code: str) -> None:
    scene.history.gate.set_result(None)
    scene.port.gone = Unavailable("nobody serves it", code=code)
    for _ in range(2):
        with pytest.raises(Unavailable) as refused:
            await scene.submit("key")
        assert refused.value.code == code
    assert len(await scene.history.page(GoalFilter(), limit=9)) == 2
    scene.port.gone = None
    with pytest.raises(Conflict, match="another goal"):
        await scene.submit("key", '{"order": 1}')
    retries = [scene.submit("key"), scene.submit("key")]
    await turns()
    scene.port.answer_goal(ACCEPTED)
    goals = [await retry for retry in (*retries, scene.submit("key"))]
    assert {goal.goal_id for goal in goals} == scene.port.sent.keys()


async def test_a_goal_that_was_sent_is_not_sent_again(scene: Scene) -> None:
    scene.history.gate.set_result(None)
    first = scene.submit("key")
    await turns()
    scene.port.answer_goal(REJECTED)
    for again in (first, scene.submit("key")):
        with pytest.raises(Conflict) as refused:
            await again
        assert refused.value.code == "goal_rejected"
    assert len(scene.port.sent) == 1


async def test_a_key_that_cannot_be_let_go_of_stays_with_its_goal(scene: Scene) -> None:
    """Once the database is back it would tell of the first goal: a second one could be followed by a third."""
    scene.history.gate.set_result(None)
    scene.port.gone = Unavailable("nobody serves it")
    with pytest.raises(Unavailable):
        await scene.submit("key")
    scene.port.gone, scene.history.reachable = None, False
    with pytest.raises(Unavailable, match="nobody serves it"):
        await scene.submit("key")
    assert not scene.port.sent


@pytest.mark.parametrize(
    ("said", "code"), [("stop_latched", "stop_latched"), ("dock_busy", "dock_busy"), ("invalid_goal", "goal_rejected")]
)
async def test_what_the_server_says_of_a_rejection(scene: Scene, said: str, code: str) -> None:
    submission = scene.submit()
    scene.history.gate.set_result(None)
    await turns()
    (goal_id,) = scene.port.sent
    scene.reasons.put(goal_id, GoalError(said, "a sentence"))
    scene.port.answer_goal(REJECTED)
    with pytest.raises(Conflict, match="a sentence") as refused:
        await submission
    assert refused.value.code == code


async def test_a_stop_while_the_history_is_asked_for_the_key(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    loaded = asyncio.Event()

    async def by_key(_: str) -> Goal | None:
        await loaded.wait()
        return None

    monkeypatch.setattr(scene.history, "by_key", by_key)
    scene.history.gate.set_result(None)
    submission = scene.submit("key")
    await turns()
    scene.delivery.stop()
    loaded.set()
    with pytest.raises(Conflict) as refused:
        await submission
    assert refused.value.code == "stopped"
    assert scene.port.sent == {}


async def test_pending_comes_before_what_the_server_says(scene: Scene) -> None:
    """By its id, too, which the history goes by: that is of before the goal was sent."""
    scene.history.gate.set_result(None)
    submission = scene.submit()
    await turns()
    (goal,) = scene.tracker.live.values()
    assert goal.last_event_id == event_id(nanoseconds(goal.created_at), STATUS, goal.goal_id)
    submission.cancel()


async def stored_before(scene: Scene, key: str, **more: object) -> Goal:
    """A goal that a gateway stored under a key, and was killed before it sent it."""
    goal = Goal("77777777-0000-4000-8000-000000000000", "/dock", "pkg/action/Dock", utc_now(), goal=b"{}")
    for name, value in more.items():
        setattr(goal, name, value)
    scene.history.record(goal)
    await scene.history.claim(key, goal.goal_id, fingerprint_of("/dock", b"{}"))
    return goal


@pytest.mark.parametrize("taken_up", [True, False], ids=["by this gateway", "by one that is gone"])
async def test_a_goal_that_was_stored_and_not_sent_is_sent_by_the_retry_under_its_id(
    scene: Scene, taken_up: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene.settings, "__dict__", scene.settings.__dict__ | {"accept_timeout": 0.2})
    scene.history.gate.set_result(None)
    goal = await stored_before(scene, "key")
    if taken_up:
        scene.tracker.take_up(goal)
        scene.tracker.lose(goal, GoalError("action_server_lost", "the action server does not know the goal"))
        assert goal.unconfirmed
    submission = scene.submit("key")
    await until(lambda: bool(scene.port.sent))
    assert list(scene.port.sent) == [goal.goal_id]
    scene.port.answer_goal(ACCEPTED)
    assert (await submission).goal_id == goal.goal_id
    assert (await scene.submit("key")).status is GoalStatus.ACCEPTED
    assert len(scene.port.sent) == 1


async def test_a_goal_that_runs_is_not_ended_when_the_server_refuses_its_id_once_more(scene: Scene) -> None:
    scene.history.gate.set_result(None)
    goal = await stored_before(scene, "key")
    scene.tracker.take_up(goal)
    scene.tracker.lose(goal, GoalError("action_server_lost", "silent"))
    submission = scene.submit("key")
    await until(lambda: bool(scene.port.sent))
    scene.tracker.apply(GoalMachine.move, goal, GoalStatus.EXECUTING)  # the first request was only slow
    scene.port.answer_goal(REJECTED)
    assert (await submission).status is GoalStatus.EXECUTING


async def test_a_goal_whose_cancel_was_given_up_and_that_succeeds_has_no_error(scene: Scene) -> None:
    scene.history.gate.set_result(None)
    submission = scene.submit()
    await turns()
    scene.port.answer_goal(ACCEPTED)
    goal = await submission
    goal.error = GoalError("canceled", "it was canceled while the action server could not be reached")
    scene.tracker.apply(GoalMachine.end, goal, GoalStatus.SUCCEEDED, result=b"{}")
    await scene.tracker.close()
    kept = await scene.history.get(goal.goal_id)
    assert kept is not None
    assert (kept.status, kept.error) == (GoalStatus.SUCCEEDED, None)


async def test_a_key_keeps_its_goal_although_a_gate_has_named_its_dock(scene: Scene) -> None:
    """What was asked for counts, not the message that was sent."""

    async def gate(_: object, goal: Goal) -> dict[str, object]:
        assert goal.goal is not None
        return {**charging_dock.DOCK.at_dock(orjson.loads(goal.goal), "lab")}

    def asked(location: str) -> str:
        return orjson.dumps({"desired_battery_state": {"location": location}}).decode()

    scene.port.goal_codec = SimpleNamespace(parse=lambda fields: orjson.dumps(fields).decode())  # type: ignore[attr-defined]
    scene.history.gate.set_result(None)
    scene.gates.append(gate)
    first = scene.submit("key", asked(""))
    await until(lambda: bool(scene.port.sent))
    scene.port.answer_goal(ACCEPTED)
    goal = await first
    assert goal.goal == asked("lab").encode()
    for same in ("", "nearest", "lab"):
        assert (await scene.submit("key", asked(same))).goal_id == goal.goal_id
    for other in ("home", '{"pose": [1, 2, 0]}'):
        with pytest.raises(Conflict) as refused:
            await scene.submit("key", asked(other))
        assert refused.value.code == "idempotency_key_reused"
