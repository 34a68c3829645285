"""Goals that turn up by themselves are looked up before anything is said of them."""

import asyncio
import time
from collections.abc import Collection
from datetime import UTC, datetime
from functools import partial
from uuid import UUID

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import Now
from dock_gateway.core.goal import Goal, GoalError, encode
from dock_gateway.goals.adoption import BATCH, Newcomers
from dock_gateway.goals.goal_machine import GoalChange
from dock_gateway.goals.limits import LIMITS, GoalLimits
from tests.support.history import make_goal
from tests.support.tracking import A, B, S, Scene, limits, scene
from tests.support.waiting import until

__all__ = ["scene"]

SENT_AT = datetime(2026, 1, 1, tzinfo=UTC)


def goal_of_before(**more: object) -> Goal:
    goal = Goal(B, "/dock", "pkg/action/Dock", SENT_AT, goal=b'{"n":1}')
    for name, value in more.items():
        setattr(goal, name, value)
    return goal


def replace_id(goal: Goal, goal_id: str) -> Goal:
    goal.goal_id = goal_id
    return goal


def away(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    async def known(_: Collection[str]) -> dict[str, Goal]:
        raise Unavailable("away", code="history_unavailable")

    monkeypatch.setattr(scene.history, "known", known)


async def test_a_goal_of_another_gateway_is_told_with_its_sender_from_the_first_event_on(scene: Scene) -> None:
    scene.history.record(goal_of_before())
    scene.status((B, S.ACCEPTED))
    scene.feedback(1, B)
    scene.feedback(2, B)
    scene.status((B, S.EXECUTING))
    scene.feedback(3, B)
    events = await scene.documents()
    assert [event["type"] for event in events] == ["status", "feedback", "feedback", "status", "feedback"]
    states = [event for event in events if event["type"] == "status"]
    assert [(state["status"], state["feedback_count"]) for state in states] == [("accepted", 0), ("executing", 2)]
    for state in states:
        assert (state["origin"], state["goal"]) == ("gateway", {"n": 1})
        assert datetime.fromisoformat(state["created_at"]) == SENT_AT
    kept = await scene.history.get(B)
    assert kept is not None
    assert scene.tracker.live[B].last_event_id == events[-1]["id"]


async def test_a_goal_of_before_goes_on_from_what_is_known(scene: Scene) -> None:
    scene.history.record(goal_of_before(status=S.EXECUTING, stage="CONTROLLING", feedback_count=10))
    scene.status((B, S.EXECUTING))
    scene.feedback(1, B)
    scene.status((B, S.CANCELING))
    states = [event for event in await scene.documents() if event["type"] == "status"]
    assert [(state["status"], state["feedback_count"], state["stage"]) for state in states] == [
        ("canceling", 11, "CONTROLLING")
    ]


@pytest.mark.parametrize("status", [S.SUCCEEDED, S.CANCELED, S.ABORTED])
async def test_a_goal_that_has_ended_stays_as_it_is(scene: Scene, status: S) -> None:
    """An action server remembers its goals for a while, and tells of them all again after each restart of ours."""
    ended = goal_of_before(status=status, result=b'{"n":9}', error=GoalError("why", "because"), last_event_id="z")
    scene.history.record(ended)
    for _ in range(3):
        scene.status((B, status))
        scene.feedback(1, B)
        assert await scene.events() == []
    kept = await scene.history.get(B)
    assert kept is not None
    assert encode(kept.document()) == encode(ended.document())
    assert scene.port.results == {}
    assert scene.tracker.live == {}


async def test_a_goal_that_is_first_seen_by_its_feedback(scene: Scene) -> None:
    scene.feedback(1, B)
    scene.status((B, S.EXECUTING))
    scene.feedback(2, B)
    assert await scene.events() == ["status:executing", "feedback:1", "feedback:2"]
    goal, kept = scene.tracker.live[B], await scene.history.get(B)
    assert kept is not None
    assert (goal.feedback_count, goal.origin) == (2, "external")


@limits(patience=0.05)
async def test_nothing_is_said_while_the_history_cannot_tell_whether_a_goal_has_ended(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as outage:
        away(scene, outage)
        scene.history.record(goal_of_before(status=S.SUCCEEDED, result=b"{}"))
        scene.status((B, S.SUCCEEDED), (A, S.EXECUTING))
        await until(lambda: A in scene.tracker.live)
        assert scene.tracker.live[A].origin == "external", "a robot that moves is shown, whoever sent it"
        assert B not in scene.tracker.live
    await asyncio.sleep(0.3)
    assert B not in scene.tracker.live
    assert await scene.events() == ["status:executing"]


@limits(patience=0.0)
async def test_a_goal_turns_out_to_be_ours_when_the_history_is_back(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    away(scene, monkeypatch)
    scene.status((B, S.EXECUTING))
    await until(lambda: B in scene.tracker.live)
    scene.tracker.take_up(goal_of_before(status=S.EXECUTING, feedback_count=3))
    states = [event for event in await scene.documents() if event["type"] == "status"]
    assert [(state["origin"], state["feedback_count"]) for state in states] == [("external", 0), ("gateway", 3)]


@pytest.mark.parametrize("claimed_first", [True, False])
async def test_a_goal_that_is_taken_up_while_it_is_looked_up(scene: Scene, claimed_first: bool) -> None:
    scene.history.record(goal_of_before(status=S.ACCEPTED))
    scene.status((B, S.EXECUTING))
    if not claimed_first:
        await asyncio.sleep(0.05)
    scene.tracker.take_up(goal_of_before(status=S.ACCEPTED))
    scene.feedback(1, B)
    assert await scene.events() == ["status:executing", "feedback:1"]
    assert scene.tracker.live[B].origin == "gateway"


def test_those_that_run_are_seen_though_thousands_have_ended(caplog: pytest.LogCaptureFixture) -> None:
    newcomers = Newcomers()
    for number in range(3000):
        newcomers.hear(f"{number}", lambda *_: None, created_ns=1, running=number >= 2990, now=0.0)
    ready, pause = newcomers.ready(list(newcomers), {}, 0.0)
    assert set(ready) >= {f"{number}" for number in range(2990, 3000)}
    assert (len(ready), pause) == (BATCH, LIMITS.batch_interval)
    assert len(newcomers) == LIMITS.newcomers
    assert "some are ignored" in caplog.text


def test_only_a_running_goal_takes_the_place_of_one_that_has_ended() -> None:
    newcomers = Newcomers(GoalLimits(newcomers=2))

    def hear(goal_id: str, *, running: bool) -> list[str]:
        newcomers.hear(goal_id, lambda *_: None, created_ns=1, running=running, now=0.0)
        return list(newcomers)

    assert hear("ended-1", running=False) == ["ended-1"]
    assert hear("ended-2", running=False) == ["ended-1", "ended-2"]
    assert hear("ended-3", running=False) == ["ended-1", "ended-2"]
    assert hear("running-1", running=True) == ["running-1", "ended-1"]
    assert hear("ended-1", running=True) == ["ended-1", "running-1"], "it runs after all"
    assert hear("running-2", running=True) == ["ended-1", "running-1"]


def test_what_to_adopt_and_when_to_ask_again() -> None:
    """Those that have ended come at once, running ones after some patience if the history does not answer."""
    newcomers = Newcomers()
    for number, running in enumerate((True, False)):
        newcomers.hear(f"{number}", lambda *_: None, created_ns=1, running=running, now=10.0)
    patient = 10.0 + LIMITS.patience
    assert newcomers.ready(["0", "1"], None, patient) == ([], LIMITS.lookup_retry)
    assert newcomers.ready(["gone", "1", "0"], None, patient + 0.1) == (["0"], LIMITS.lookup_retry)
    ended = replace_id(goal_of_before(status=S.SUCCEEDED), "1")
    assert newcomers.ready(["0", "1"], {"1": ended}, 10.0) == (["1", "0"], 0.0)
    lost = replace_id(goal_of_before(status=S.LOST), "1")
    assert newcomers.ready(["0", "1"], {"1": lost}, 10.0) == (["0", "1"], 0.0)
    many = [f"{number}" for number in range(BATCH + 1)]
    assert newcomers.ready(many[1:], {}, 10.0) == (many[1:], 0.0)
    assert newcomers.ready(many, {"1": ended}, 10.0) == (["1", "0", *many[2:]], 0.0)
    assert newcomers.ready(many, {}, 10.0) == (many[:-1], LIMITS.batch_interval)


@limits(batch_interval=0.1)
async def test_made_up_goals_are_taken_up_at_a_rate_that_harms_nobody(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    batches: list[tuple[float, int]] = []

    async def known(goal_ids: Collection[str]) -> dict[str, Goal]:
        batches.append((time.monotonic(), len(goal_ids)))
        return {}

    monkeypatch.setattr(scene.history, "known", known)
    scene.status(*((str(UUID(int=number)), S.EXECUTING) for number in range(200)))
    await until(lambda: len(batches) == 4)
    assert [size for _, size in batches] == [200, 150, 100, 50], "one query for all that wait"
    assert batches[-1][0] - batches[0][0] >= 0.3


async def test_goals_that_have_ended_are_recognized_at_once_however_many(scene: Scene) -> None:
    """As after a start: an action server tells of all goals that it remembers, and what follows waits for that."""
    ended = [str(UUID(int=number)) for number in range(1, 91)]
    for goal_id in ended:
        scene.history.record(replace_id(goal_of_before(status=S.SUCCEEDED, result=b"{}"), goal_id))
    scene.status(*((goal_id, S.SUCCEEDED) for goal_id in ended), (A, S.EXECUTING))
    await until(lambda: A in scene.tracker.live, timeout=LIMITS.batch_interval / 2)
    assert set(scene.tracker.live) == {A}


async def test_a_goal_that_cannot_be_taken_up_harms_no_other(scene: Scene, caplog: pytest.LogCaptureFixture) -> None:
    seen: list[str] = []

    def listen(goal: Goal) -> None:
        if goal.goal_id == A:
            raise ValueError("broken")
        seen.append(goal.goal_id)

    scene.tracker.on[GoalChange.SEEN].append(listen)
    scene.status((A, S.EXECUTING), (B, S.EXECUTING))
    await until(lambda: seen == [B])
    later = str(UUID(int=1))
    scene.status((later, S.EXECUTING))
    await until(lambda: seen == [B, later])
    assert "a listener failed: seen, of a goal" in caplog.text


def test_what_waits_of_a_goal_is_bounded() -> None:
    newcomers, taken = Newcomers(), list[int]()
    for number in range(1000):
        message = partial(lambda number, *_: taken.append(number), number)
        newcomers.hear("one", message, created_ns=1, running=True, now=0.0)
    newcomer = newcomers.claim("one")
    assert newcomer is not None
    for take in newcomer.messages:
        take(Now.read(), make_goal(1))
    assert taken == list(range(900, 1000))


async def test_the_end_that_another_gateway_saw_first_is_told_here_too(scene: Scene) -> None:
    """It was quicker than our look-up. Readers of this gateway have not been told."""
    scene.history.record(goal_of_before(status=S.SUCCEEDED, result=b"{}", finished_at=datetime.now(UTC)))
    for _ in range(2):
        scene.status((B, S.EXECUTING))
        scene.status((B, S.SUCCEEDED))
    assert await scene.events() == ["status:succeeded", "result:succeeded"]
