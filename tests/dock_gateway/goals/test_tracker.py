"""Goals as ROS tells of them: in any order, twice, too late. The port is a fake; tests/system has the real one."""

import asyncio
import time
from collections.abc import Collection

import orjson
import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import Event, restamped, status_event
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.goals.goal_machine import GoalMachine
from tests.support.history import make_goal
from tests.support.tracking import A, B, S, Scene, limits, scene
from tests.support.waiting import PATIENCE, until

__all__ = ["scene"]


async def test_the_usual_order(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.apply(GoalMachine.accept, goal, 1)
    scene.status((A, S.EXECUTING))
    scene.feedback(1)
    await asyncio.sleep(0)
    scene.port.answer_result(A, S.SUCCEEDED, b'{"n":2}')
    assert await scene.events() == [
        "status:pending",
        "status:accepted",
        "status:executing",
        "feedback:1",
        "status:succeeded",
        "result:succeeded",
    ]
    assert goal.result == b'{"n":2}'
    assert scene.tracker.live == {}
    assert len(scene.port.results[A]) == 1


async def test_feedback_before_acceptance_and_after_the_result(scene: Scene) -> None:
    goal = scene.send()
    scene.feedback(1)
    assert goal.status is S.PENDING
    scene.tracker.apply(GoalMachine.move, goal, S.ACCEPTED)
    scene.feedback(2)
    assert goal.status is S.ACCEPTED
    scene.status((A, S.EXECUTING))
    scene.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
    scene.feedback(3)
    scene.status((A, S.EXECUTING))
    assert goal.feedback_count == 2
    assert (await scene.events())[-1] == "result:succeeded"


async def test_progress_is_told_while_the_goal_runs(scene: Scene) -> None:
    goal = scene.send()
    scene.status((A, S.EXECUTING))
    scene.tracker.apply(GoalMachine.progress, goal, "CONTROLLING", 0, 7)
    scene.tracker.apply(GoalMachine.progress, goal, "CONTROLLING", 0, 8)  # said again
    scene.tracker.apply(GoalMachine.progress, goal, "RETRY", 1, 9)
    scene.tracker.apply(GoalMachine.end, goal, S.ABORTED, result=b"{}")
    scene.tracker.apply(GoalMachine.progress, goal, "CONTROLLING", 2, 10)
    assert (goal.stage, goal.retries) == ("RETRY", 1)
    assert await scene.events() == [
        "status:pending",
        "status:executing",
        "status:executing",
        "status:executing",
        "status:aborted",
        "result:aborted",
    ]


async def test_a_goal_of_someone_else(scene: Scene) -> None:
    scene.status((B, S.EXECUTING))
    await until(lambda: B in scene.port.results)
    goal = scene.tracker.live[B]
    assert (goal.action_name, goal.action_type) == ("/dock", "pkg/action/Dock")
    assert (goal.origin, goal.goal) == ("external", None)
    assert goal.created_at.year == 1970, "when the server accepted it"
    scene.port.answer_result(B, S.CANCELED, b'{"n":0}')
    assert await scene.events() == ["status:executing", "status:canceled", "result:canceled"]
    kept = await scene.history.get(B)
    assert kept is not None
    assert (kept.origin, kept.status) == ("external", S.CANCELED)


async def test_lost_and_back(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.apply(GoalMachine.move, goal, S.EXECUTING)
    scene.tracker.lose(goal, GoalError("action_server_lost", "silent"))
    assert scene.tracker.running() == []
    scene.feedback(1)
    assert goal.status is S.EXECUTING
    assert goal.error is None
    assert scene.returned == [goal]


async def test_before_a_goal_is_lost_its_robot_is_stopped_once_and_the_reason_says_so(scene: Scene) -> None:
    statuses: list[GoalStatus] = []

    def stop(goal: Goal) -> str:
        statuses.append(goal.status)
        return "zero velocity was sent"

    scene.before_lost += [stop, lambda _: ""]
    goal = scene.send()
    scene.status((A, S.EXECUTING))
    scene.port.answer_result(A, None)
    await until(lambda: goal.status is S.LOST)
    detail = "the action server does not know the goal; zero velocity was sent"
    assert goal.error == GoalError("action_server_lost", detail)
    scene.tracker.lose(goal, GoalError("action_server_lost", "silent"))
    assert statuses == [S.EXECUTING]


async def test_waiting_ends_with_the_goal_with_the_time_and_with_the_gateway(scene: Scene) -> None:
    goal = scene.send()
    await scene.tracker.wait_terminal(goal, 0.01)
    waiting = asyncio.create_task(scene.tracker.wait_terminal(goal, 2 * PATIENCE))
    await asyncio.sleep(0)
    scene.tracker.apply(GoalMachine.end, goal, S.REJECTED, error=GoalError("goal_rejected", "no"))
    await asyncio.wait_for(waiting, PATIENCE)
    other = scene.send(B)
    waiting = asyncio.create_task(scene.tracker.wait_terminal(other, 2 * PATIENCE))
    await asyncio.sleep(0)
    scene.tracker.release_all()
    await asyncio.wait_for(waiting, PATIENCE)


async def test_each_message_is_a_sign_of_life(scene: Scene) -> None:
    goal = scene.send()
    for hear in (lambda: scene.status((A, S.EXECUTING)), lambda: scene.feedback(1)):
        scene.tracker.last_heard = 0.0
        hear()
        assert 0.0 <= scene.tracker.silence_of(goal) < 5.0
        assert scene.tracker.last_heard > 0.0


async def test_the_silence_of_a_goal_without_news_is_that_of_the_server(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.last_heard = time.monotonic() - 100.0
    assert 100.0 <= scene.tracker.silence_of(goal) < 110.0
    scene.tracker.apply(GoalMachine.move, goal, S.ACCEPTED)
    assert scene.tracker.silence_of(goal) < 10.0


async def test_who_waits_goes_on_when_the_goal_is_lost(scene: Scene) -> None:
    goal = scene.send()
    waiting = [asyncio.create_task(scene.tracker.wait_terminal(goal, 60)) for _ in range(2)]
    await asyncio.sleep(0)
    scene.tracker.lose(goal, GoalError("action_server_lost", "silent"))
    await asyncio.wait_for(asyncio.gather(*waiting), 50)
    await asyncio.wait_for(scene.tracker.wait_terminal(goal, 60), 50)
    scene.fanout.close()
    await asyncio.wait_for(scene.tracker.wait_terminal(scene.send(B), 60), 50)


async def test_the_end_is_stored_under_the_stamp_of_the_message_that_reported_it(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.apply(GoalMachine.end, goal, S.ABORTED, result=b"{}", stamp_ns=7)
    documents = await scene.documents()
    assert [document["type"] for document in documents[-2:]] == ["status", "result"]
    assert [document["time"] for document in documents[-2:]] == ["1970-01-01T00:00:00Z"] * 2
    assert documents[-1]["id"].split("-")[0] == documents[-2]["id"].split("-")[0]
    kept = await scene.history.get(A)
    assert kept is not None
    assert kept.last_event_id == documents[-1]["id"] == goal.last_event_id


async def test_a_rejected_goal_ends_with_a_result_like_any_other(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.apply(GoalMachine.end, goal, S.REJECTED, error=GoalError("goal_rejected", "no"))
    assert await scene.events() == ["status:pending", "status:rejected", "result:rejected"]


async def test_the_end_that_another_gateway_stored_first_counts(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    goal = scene.send()
    later = time.time_ns() + 1_000_000_000
    theirs = status_event(make_goal(1), later), status_event(make_goal(1), later + 1)

    async def seal(ended: Goal, end: list[Event]) -> list[Event]:
        assert (ended, [orjson.loads(event.data)["type"] for event in end]) == (goal, ["status", "result"])
        return list(theirs)

    monkeypatch.setattr(scene.history, "seal", seal)
    scene.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
    await until(lambda: goal.last_event_id == theirs[-1].id)
    kept = await scene.history.get(A)
    assert kept is not None
    assert kept.last_event_id == theirs[-1].id
    assert [document["id"] for document in await scene.documents()][-2:] == [event.id for event in theirs]


async def test_an_end_that_cannot_be_stored_is_published_all_the_same(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def seal(*_: object) -> list[Event]:
        raise Unavailable("full", code="history_unavailable")

    monkeypatch.setattr(scene.history, "seal", seal)
    goal = scene.send()
    waiting = asyncio.create_task(scene.tracker.wait_terminal(goal, 60))
    await asyncio.sleep(0)
    scene.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
    await asyncio.wait_for(waiting, 50)
    assert (await scene.events())[-1] == "result:succeeded"


async def test_where_a_history_is_shared_states_are_published_in_the_order_of_all_gateways(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They come with the permission to publish, or at last when they are stored."""
    stored: list[Event] = []

    async def seal(_: Goal, events: list[Event]) -> list[Event]:
        new = [restamped(event, time.time_ns() + 1_000_000) for event in events]
        stored.extend(new)
        scene.fanout.line.allow(new if scene.tracker.live else [], None)
        return new

    monkeypatch.setattr(scene.history, "shared", True)
    monkeypatch.setattr(scene.history, "seal", seal)
    first, second = scene.send(A), scene.send(B)
    for goal in (first, second):
        scene.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
        await until(lambda goal=goal: stored and goal.last_event_id == stored[-1].id)
    documents = await scene.documents()
    assert [document["id"] for document in documents] == [event.id for event in stored]
    assert [document["type"] for document in documents] == ["status", "status", *["status", "result"] * 2]


async def test_an_end_that_a_shared_history_cannot_store_in_time_is_published_under_a_new_id(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def seal(_: Goal, end: list[Event]) -> None:
        scene.feedback(1, B)

    monkeypatch.setattr(scene.history, "shared", True)
    monkeypatch.setattr(scene.history, "seal", seal)
    goal, _ = scene.send(A), scene.send(B)
    scene.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
    documents = await scene.documents()
    assert [document["type"] for document in documents][-3:] == ["feedback", "status", "result"]
    assert [document["id"] for document in documents] == sorted(document["id"] for document in documents)
    assert goal.last_event_id == documents[-1]["id"]


@limits(lookup_retry=0.01)
async def test_a_history_that_fails_is_asked_again(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    answers = [ValueError("broken"), Unavailable("away")]
    known = scene.history.known

    async def fail_first(goal_ids: Collection[str]) -> dict[str, Goal]:
        if answers:
            raise answers.pop(0)
        return await known(goal_ids)

    monkeypatch.setattr(scene.history, "known", fail_first)
    scene.status((B, S.EXECUTING))
    await until(lambda: B in scene.tracker.live)
    assert answers == []
    assert "while looking up goals" in caplog.text
    assert scene.tracker.live[B].origin == "external"
