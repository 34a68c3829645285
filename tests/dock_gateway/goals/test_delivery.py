"""A goal on its way: sent, answered, given up. Port and watch are fakes; tests/system has the real ones."""

import asyncio
from collections.abc import AsyncIterator
from types import SimpleNamespace
from typing import Any

import orjson
import pytest

from dock_gateway.core.access import ANYBODY, Principal
from dock_gateway.core.dock_adapters.adapter import Fields
from dock_gateway.core.errors import (
    Conflict,
    DockOccupied,
    GatewayError,
    NotAllowed,
    ServerTimeout,
    TooManyRequests,
    Unavailable,
)
from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import UNCONFIRMED, Goal, GoalError, GoalStatus
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.action_context import ActionContext, Gate
from dock_gateway.goals.cancellation import TOO_LATE, Canceler
from dock_gateway.goals.delivery import STOPPED_ON_ITS_WAY, GoalDelivery, KeyClaim, outcome
from dock_gateway.goals.goal_machine import GoalMachine
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from dock_gateway.storage import GoalFilter
from tests.support.action_port import FakeActionPort
from tests.support.history import HistoryInMemory
from tests.support.permits import acting, user
from tests.support.tracking import A, B, S
from tests.support.waiting import until

ACCEPTED = SimpleNamespace(accepted=True, stamp=SimpleNamespace(sec=3, nanosec=5))
REJECTED = SimpleNamespace(accepted=False)
WHY = GoalError("why", "because")


class FakeInterlock:
    def __init__(self) -> None:
        self.latched: list[str] = []

    def require_released(self, action_name: str) -> None:
        if self.holds(action_name):
            raise Conflict("a stop is latched", code="stop_latched")

    def holds(self, action_name: str) -> bool:
        return action_name in self.latched

    def requested_by(self, _: str) -> None:
        return None


class FakeWatch:
    missing: GatewayError | None = None

    async def require(self) -> None:
        if self.missing:
            raise self.missing


class SealingHistory(HistoryInMemory):
    """Notes the keys and the goals that are on disk before anything else happens."""

    def __init__(self) -> None:
        super().__init__()
        self.keys: list[str | None] = []
        self.sealed: list[tuple[str, int]] = []

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        self.keys.append(idempotency_key)
        await super().add(goal, idempotency_key)

    def seal(self, goal: Goal, events: Any) -> Any:
        self.sealed.append((goal.status.value, len(events)))
        return super().seal(goal, events)


class Scene:
    def __init__(self, **settings: Any) -> None:
        self.port: Any = FakeActionPort()
        self.history = SealingHistory()
        self.interlock: Any = FakeInterlock()
        self.watch: Any = FakeWatch()
        fanout = Fanout(queue_limit=100)
        self.subscriber = fanout.subscribe(EventFilter())
        self.reasons: PendingFacts[GoalError] = PendingFacts(0.05)
        self.tracker = GoalTracker(self.port, fanout, self.history, self.reasons)
        self.settings = Settings(**{"accept_timeout": 30.0, "max_pending_goals": 2, **settings})
        self.asked: list[tuple[Principal, str, bytes]] = []
        self.refusal: NotAllowed | None = None
        self.gates: list[Gate] = []
        self.canceler = Canceler(self.settings, self.tracker, self.interlock)
        self.delivery = GoalDelivery(
            ActionContext(
                self.settings,
                fanout,
                self.history,
                self.reasons,
                self.interlock,
                before_send=[self.allow],
                gates=self.gates,
            ),
            self.tracker,
            self.watch,
            self.canceler,
        )

    async def allow(self, sender: Principal, action_name: str, goal: bytes) -> None:
        self.asked.append((sender, action_name, goal))
        if self.refusal is not None:
            raise self.refusal

    async def send(self, message: str = "{}", **more: Any) -> "asyncio.Task[Goal]":
        """Start to deliver a goal; return when it is sent."""
        sent = len(self.port.sent)
        task = self.delivery.start(message, **{"sender": ANYBODY, **more})
        await until(lambda: task.done() or len(self.port.sent) > sent)
        return task

    def answer(self, response: Any) -> None:
        self.port.answer_goal(response)

    async def given_up(self) -> Goal:
        """A goal that the server has not answered in time."""
        with pytest.raises(ServerTimeout) as refused:
            await (await self.send())
        (goal,) = self.tracker.live.values()
        assert refused.value.extra["goal_id"] == goal.goal_id
        assert refused.value.code == "action_server_timeout"
        return goal


@pytest.fixture
async def scene() -> AsyncIterator[Scene]:
    scene = Scene()
    yield scene
    await scene.tracker.close()


@pytest.fixture
async def hasty() -> AsyncIterator[Scene]:
    """It gives up at once."""
    scene = Scene(accept_timeout=0.01)
    yield scene
    await scene.tracker.close()


async def refusal(task: "asyncio.Task[Goal]") -> GatewayError:
    with pytest.raises(GatewayError) as refused:
        await task
    return refused.value


async def test_a_goal_that_is_accepted(scene: Scene) -> None:
    task = await scene.send('{"n":1}')
    (goal,) = scene.tracker.live.values()
    assert (goal.status, goal.goal, goal.action_name, goal.action_type) == (
        S.PENDING,
        b'{"n":1}',
        "/dock",
        "pkg/action/Dock",
    )
    assert scene.history.keys == [None]
    assert list(scene.port.sent) == [goal.goal_id]
    assert scene.port.messages[goal.goal_id] == '{"n":1}'
    scene.tracker.last_heard = 0.0
    scene.answer(ACCEPTED)
    assert await task is goal
    assert goal.status is S.ACCEPTED
    assert goal.last_event_id is not None
    assert scene.tracker.last_heard > 0.0, "the server lives"
    assert list(scene.port.results) == [goal.goal_id]
    assert scene.port.canceled == []
    assert scene.history.sealed == [("accepted", 0)], "it is on disk before the answer"
    events = [event.data for event in (await scene.subscriber.take(1.0))[0]]
    assert b'"time":"1970-01-01T00:00:03Z"' in events[-1], "its acceptance has the server's stamp"


async def test_the_stamp_of_the_acceptance_is_exact(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    stamps: list[int] = []
    monkeypatch.setattr(GoalMachine, "accept", lambda *inputs: stamps.append(inputs[-1]))
    task = await scene.send()
    scene.answer(ACCEPTED)
    await task
    assert stamps == [3_000_000_005]


async def test_an_accepted_goal_that_a_stop_holds_is_canceled(scene: Scene) -> None:
    task = await scene.send()
    scene.interlock.latched = ["/dock"]
    scene.answer(ACCEPTED)
    goal = await task
    await until(lambda: scene.port.canceled == [goal.goal_id])


async def test_a_key_is_claimed_for_the_goal(scene: Scene) -> None:
    claimed: list[Goal] = []

    async def take(goal: Goal) -> Goal | None:
        claimed.append(goal)
        return first if len(claimed) > 1 else None

    task = await scene.send(claim=KeyClaim("key", take))
    scene.answer(ACCEPTED)
    first = await task
    assert (claimed, scene.history.keys) == ([first], ["key"])
    assert await (await scene.send(claim=KeyClaim("key", take))) is first
    assert len(scene.port.sent) == 1


async def test_a_goal_that_is_sent_again_keeps_its_id_and_is_not_stored_anew(scene: Scene) -> None:
    goal = Goal(A, "/dock", "pkg/action/Dock", utc_now(), goal=b"{}")
    scene.canceler.mark_unwanted(goal, TOO_LATE)
    task = await scene.send(again=goal)
    scene.answer(ACCEPTED)
    assert await task is goal
    assert (list(scene.port.sent), scene.history.keys) == ([A], [])
    assert (goal.status, scene.port.canceled) == (S.ACCEPTED, [])


async def test_only_so_many_goals_wait_for_an_answer(scene: Scene) -> None:
    with acting(Quotas(scene.settings), user(None, address="192.0.2.1")):
        waiting = [await scene.send() for _ in range(2)]
        with pytest.raises(TooManyRequests, match="2 goals waiting for the answer of /dock: that is the share"):
            scene.delivery.start("{}", sender=ANYBODY)
        scene.answer(ACCEPTED)
        await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
        await scene.send()


async def test_a_goal_is_not_sent_without_a_server(scene: Scene) -> None:
    scene.watch.missing = Unavailable("nobody")
    assert await refusal(await scene.send()) is scene.watch.missing
    assert scene.history.keys == []
    assert scene.tracker.live == {}


async def test_a_goal_is_refused_while_a_stop_is_latched(scene: Scene) -> None:
    scene.interlock.latched = ["/dock"]
    with pytest.raises(Conflict) as refused:
        scene.delivery.start("{}", sender=ANYBODY)
    assert refused.value.code == "stop_latched"


@pytest.mark.parametrize("latched", [True, False])
async def test_a_stop_on_the_way_keeps_a_goal_from_being_sent(scene: Scene, latched: bool) -> None:
    tasks = [scene.delivery.start("{}", sender=ANYBODY) for _ in range(2)]
    if latched:
        scene.interlock.latched = ["/dock"]
    else:
        scene.delivery.stop()
        scene.delivery.stop()
        assert scene.delivery.stops == 2
    for task in tasks:
        error = await refusal(task)
        assert (error.code, error.detail) == (
            "stopped",
            STOPPED_ON_ITS_WAY,
        )
        goal = await scene.history.get(error.extra["goal_id"])
        assert goal is not None
        assert (goal.status, goal.error) == (S.REJECTED, GoalError("stopped", error.detail))
        assert goal.unsent
    assert (scene.port.sent, scene.tracker.live) == ({}, {})


async def test_a_stop_since_the_request_counts_too(scene: Scene) -> None:
    scene.delivery.stop()
    assert (await refusal(scene.delivery.start("{}", stops=0, sender=ANYBODY))).code == "stopped"
    task = await scene.send(stops=1)
    scene.answer(ACCEPTED)
    assert (await task).status is S.ACCEPTED


async def test_a_goal_that_cannot_be_sent(scene: Scene) -> None:
    scene.port.gone = Unavailable("nobody serves it", code="ros_unavailable")
    error = await refusal(await scene.send())
    assert error is scene.port.gone
    (goal,) = await scene.history.page(GoalFilter(), limit=9)
    assert (goal.status, goal.error) == (S.REJECTED, GoalError("ros_unavailable", "nobody serves it"))


@pytest.mark.parametrize(
    ("reason", "error"),
    [
        (None, GoalError("goal_rejected", "the action server rejected the goal and gave no reason")),
        (GoalError("dock_busy", "the dock is taken"), GoalError("dock_busy", "the dock is taken")),
        (GoalError("stop_latched", "a stop"), GoalError("stop_latched", "a stop")),
        (GoalError("bad", "no such dock"), GoalError("goal_rejected", "no such dock")),
    ],
)
async def test_a_goal_that_is_rejected(scene: Scene, reason: GoalError | None, error: GoalError) -> None:
    other = Goal(B, "/dock", "pkg/action/Dock", utc_now())
    scene.tracker.apply(GoalMachine.add, other)  # on its way, too: it keeps nobody busy
    task = await scene.send()
    (goal_id,) = scene.port.sent
    if reason:
        scene.reasons.put(goal_id, reason)
    scene.answer(REJECTED)
    refused = await refusal(task)
    assert isinstance(refused, Conflict)
    assert (refused.code, refused.detail, refused.extra["goal_id"]) == (error.code, error.detail, goal_id)
    goal = await scene.history.get(goal_id)
    assert goal is not None
    assert (goal.status, goal.error) == (S.REJECTED, error)


async def test_a_rejection_while_another_goal_runs_says_so(scene: Scene) -> None:
    other = Goal(B, "/dock", "pkg/action/Dock", utc_now())
    scene.tracker.apply(GoalMachine.add, other)
    scene.tracker.apply(GoalMachine.move, other, S.EXECUTING)
    task = await scene.send()
    scene.answer(REJECTED)
    refused = await refusal(task)
    assert (refused.code, refused.detail) == ("dock_busy", f"goal {B} is running; cancel it first")
    assert (refused.extra["running_goal_id"], refused.extra["goal_id"] != B) == (B, True)


async def test_a_goal_that_runs_is_not_ended_by_a_rejection(scene: Scene) -> None:
    """The server refused the same id, sent again."""
    task = await scene.send()
    (goal,) = scene.tracker.live.values()
    scene.tracker.apply(GoalMachine.move, goal, S.EXECUTING)
    scene.answer(REJECTED)
    assert (await task).status is S.EXECUTING


@pytest.mark.parametrize("reported", [True, False])
async def test_a_goal_that_may_have_been_sent_before_is_rejected_once_its_server_could_have_reported_it(
    scene: Scene, *, reported: bool
) -> None:
    first = Goal(A, "/dock", "pkg/action/Dock", utc_now())
    task = await scene.send(again=first)
    scene.answer(REJECTED)
    await asyncio.sleep(0.2)
    assert not task.done()
    if reported:
        scene.tracker.apply(GoalMachine.report, A, S.EXECUTING, 1, 2)
        assert (await task).status is S.EXECUTING
    else:
        assert (await refusal(task)).code == "goal_rejected"


# ------------------------------------------------------------------ giving up


async def test_a_goal_that_is_not_answered_is_lost(hasty: Scene) -> None:
    goal = await hasty.given_up()
    assert goal.error == GoalError(
        "action_server_timeout", "the action server did not accept or reject the goal within 0.01 s"
    )
    assert goal.status is S.LOST


async def test_a_goal_that_is_accepted_too_late_is_canceled(hasty: Scene) -> None:
    goal = await hasty.given_up()
    hasty.tracker.last_heard = 0.0
    hasty.answer(ACCEPTED)
    await until(lambda: hasty.port.canceled == [goal.goal_id])
    await until(lambda: goal.status is S.CANCELING)
    assert goal.error == TOO_LATE
    assert hasty.tracker.last_heard > 0.0, "the server lives"
    assert list(hasty.port.results) == [goal.goal_id]
    assert hasty.delivery.unanswered == {}


async def test_a_goal_that_its_server_reports_is_not_given_up() -> None:
    """The answer to its request has been lost."""
    scene = Scene(accept_timeout=0.5)
    task = await scene.send()
    (goal,) = scene.tracker.live.values()
    scene.tracker.apply(GoalMachine.move, goal, S.EXECUTING)
    assert await task is goal
    assert (goal.status, scene.delivery.unanswered, scene.port.canceled) == (S.EXECUTING, {}, [])
    await scene.tracker.close()


async def test_a_goal_that_is_rejected_too_late_says_what_its_sender_was_told(hasty: Scene) -> None:
    goal = await hasty.given_up()
    told = goal.error
    hasty.answer(REJECTED)
    await until(lambda: goal.status is S.REJECTED)
    assert goal.error == told
    assert hasty.delivery.unanswered == {}


@pytest.mark.parametrize("failure", [asyncio.CancelledError(), Unavailable("gone")])
async def test_an_answer_that_never_comes_leaves_the_goal_lost(hasty: Scene, failure: BaseException) -> None:
    goal = await hasty.given_up()
    call = hasty.port.sent[goal.goal_id]
    problems: list[Any] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, problem: problems.append(problem))
    if isinstance(failure, GatewayError):
        call.response.set_exception(failure)
    else:
        call.forget()
    await until(lambda: hasty.delivery.unanswered == {})
    assert (goal.status, problems) == (S.LOST, [])


async def test_nothing_is_awaited_of_a_goal_that_was_given_up_and_has_ended(hasty: Scene) -> None:
    goal = await hasty.given_up()
    problems: list[Any] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, problem: problems.append(problem))
    assert hasty.delivery.unanswered.keys() == {goal.goal_id}
    hasty.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
    assert hasty.delivery.unanswered == {}
    assert hasty.port.sent[goal.goal_id].response.cancelled()
    await asyncio.sleep(0)
    assert problems == []


async def test_a_goal_that_ended_before_it_was_answered(scene: Scene) -> None:
    settings = {"accept_timeout": 0.2}
    scene.settings.__dict__.update(settings)
    task = await scene.send()
    (goal,) = scene.tracker.live.values()
    scene.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
    assert (await task).status is S.SUCCEEDED
    assert scene.port.sent[goal.goal_id].response.cancelled()
    assert scene.delivery.unanswered == {}


# ------------------------------------------------------------------ what the sender is told


@pytest.mark.parametrize(
    ("status", "code", "kind"),
    [
        (S.REJECTED, "goal_rejected", Conflict),
        (S.REJECTED, "action_server_unavailable", Unavailable),
        (S.REJECTED, "ros_unavailable", Unavailable),
        (S.REJECTED, "action_server_timeout", ServerTimeout),
        (S.LOST, "action_server_timeout", ServerTimeout),
        (S.LOST, UNCONFIRMED, Unavailable),
    ],
)
def test_what_the_sender_of_a_goal_that_did_not_start_is_told(
    status: GoalStatus, code: str, kind: type[GatewayError]
) -> None:
    goal = Goal(A, "/dock", "pkg/action/Dock", utc_now(), status=status, error=GoalError(code, "because"))
    with pytest.raises(GatewayError) as refused:
        outcome(goal)
    assert type(refused.value) is kind
    assert (refused.value.code, refused.value.detail, refused.value.extra) == (code, "because", {"goal_id": A})


@pytest.mark.parametrize(
    ("status", "error"),
    [(S.ACCEPTED, None), (S.LOST, GoalError("action_server_lost", "silent")), (S.ABORTED, WHY), (S.REJECTED, None)],
)
def test_the_sender_of_a_goal_that_started_gets_it(status: GoalStatus, error: GoalError | None) -> None:
    goal = Goal(A, "/dock", "pkg/action/Dock", utc_now(), status=status, error=error)
    assert outcome(goal) is goal


async def test_what_is_called_before_a_goal_is_sent_may_refuse_it(scene: Scene) -> None:
    scene.refusal = NotAllowed("ada has refused the goal", code="approval_refused")
    with pytest.raises(NotAllowed):
        await (await scene.send('{"n":1}'))
    assert scene.asked == [(ANYBODY, "/dock", b'{"n":1}')]
    assert (scene.port.sent, scene.history.keys) == ({}, [])
    automatic = await scene.send(sender=None)
    assert len(scene.asked) == 1, "a rule asks nobody"
    automatic.cancel()


async def test_a_gate_is_asked_whoever_sends_a_goal_before_it_is_stored(scene: Scene) -> None:
    asked: list[tuple[Principal | None, bytes | None]] = []

    async def gate(sender: Principal | None, goal: Goal) -> None:
        assert await scene.history.get(goal.goal_id) is None
        asked.append((sender, goal.goal))

    scene.gates.append(gate)
    for sender in (ANYBODY, None):
        task = await scene.send('{"n":1}', sender=sender)
        scene.answer(ACCEPTED)
        await task
    assert asked == [(ANYBODY, b'{"n":1}'), (None, b'{"n":1}')]


async def test_a_gate_gives_a_goal_other_fields(scene: Scene) -> None:
    async def gate(_: Principal | None, goal: Goal) -> Fields:
        assert goal.goal is not None
        return {**orjson.loads(goal.goal), "dock_id": "lab"}

    scene.gates.append(gate)
    scene.port.goal_codec = SimpleNamespace(parse=lambda fields: orjson.dumps(fields).decode())
    task = await scene.send('{"n":1}')
    scene.answer(ACCEPTED)
    goal = await task
    assert goal.goal == b'{"n":1,"dock_id":"lab"}'
    assert scene.port.messages == {goal.goal_id: '{"n":1,"dock_id":"lab"}'}


async def test_a_goal_that_a_gate_refuses_is_not_stored_and_its_key_is_free(scene: Scene) -> None:
    async def gate(_: Principal | None, __: Goal) -> None:
        raise DockOccupied("/robot2 has it", robot="/robot2")

    async def take(goal: Goal) -> None:
        await scene.history.claim("key", goal.goal_id, "print")

    scene.gates.append(gate)
    error = await refusal(await scene.send(claim=KeyClaim("key", take)))
    assert (error.code, error.extra) == ("dock_occupied", {"robot": "/robot2"})
    assert (scene.port.sent, scene.tracker.live, await scene.history.by_key("key")) == ({}, {}, None)
    assert await scene.history.claim("key", "another", "other print") == ("another", "other print")


async def test_a_goal_that_was_never_confirmed_asks_again(scene: Scene) -> None:
    asked: list[str] = []

    async def gate(_: Principal | None, goal: Goal) -> None:
        asked.append(goal.goal_id)

    scene.gates.append(gate)
    lost = Goal(A, "/dock", "pkg/action/Dock", utc_now())
    lost.lose(GoalError("action_server_lost", "gone"), utc_now())
    assert lost.unconfirmed
    await scene.send(again=lost)
    assert asked == [A]


async def test_a_stop_asks_no_gate(scene: Scene) -> None:
    task = await scene.send()
    scene.answer(ACCEPTED)
    await task

    async def gate(_: Principal | None, __: Goal) -> None:
        pytest.fail("it was asked")

    scene.gates.append(gate)
    scene.delivery.stop()
    (goal,) = scene.tracker.live.values()
    await scene.canceler.cancel(goal)
    assert scene.port.canceled
