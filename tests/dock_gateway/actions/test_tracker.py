"""Goals as ROS tells of them: in any order, twice, too late. The port is a fake; tests/system has the real one."""

import asyncio

import pytest

from dock_gateway.actions import goal_machine
from dock_gateway.actions import tracker as tracker_module
from dock_gateway.core import tasks as later_module
from dock_gateway.core.event import message_event
from dock_gateway.core.goal import GoalError
from tests.support.history import until
from tests.support.tracking import A, B, S, Scene, scene

__all__ = ["scene"]


async def test_the_usual_order(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.accept(goal, 1)
    scene.status((A, S.EXECUTING))
    scene.feedback(1)
    await asyncio.sleep(0)
    scene.port.answer(A, S.SUCCEEDED, b'{"n":2}')
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
    assert len(scene.port.calls[A]) == 1


async def test_feedback_before_acceptance_and_after_the_result(scene: Scene) -> None:
    goal = scene.send()
    scene.feedback(1)
    assert goal.status is S.PENDING
    scene.tracker.move(goal, S.ACCEPTED)
    scene.feedback(2)
    assert goal.status is S.ACCEPTED
    scene.status((A, S.EXECUTING))
    scene.tracker.end(goal, S.SUCCEEDED, result=b"{}")
    scene.feedback(3)
    scene.status((A, S.EXECUTING))
    assert goal.feedback_count == 2
    assert (await scene.events())[-1] == "result:succeeded"


async def test_progress_is_told_while_the_goal_runs(scene: Scene) -> None:
    goal = scene.send()
    scene.status((A, S.EXECUTING))
    scene.tracker.on_progress(goal, "CONTROLLING", 0, 7)
    scene.tracker.on_progress(goal, "CONTROLLING", 0, 8)  # said again
    scene.tracker.on_progress(goal, "RETRY", 1, 9)
    scene.tracker.end(goal, S.ABORTED, result=b"{}")
    scene.tracker.on_progress(goal, "CONTROLLING", 2, 10)
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
    await until(lambda: B in scene.port.calls)
    goal = scene.tracker.live[B]
    assert (goal.origin, goal.goal) == ("external", None)
    scene.port.answer(B, S.CANCELED, b'{"n":0}')
    assert await scene.events() == ["status:executing", "status:canceled", "result:canceled"]
    kept = await scene.history.get(B)
    assert kept is not None
    assert (kept.origin, kept.status) == ("external", S.CANCELED)


async def test_lost_and_back(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.move(goal, S.EXECUTING)
    scene.tracker.lose(goal, GoalError("action_server_lost", "silent"))
    assert scene.tracker.running() == []
    scene.feedback(1)
    assert goal.status is S.EXECUTING
    assert goal.error is None
    assert scene.returned == [goal]


async def test_waiting_ends_with_the_goal_with_the_time_and_with_the_gateway(scene: Scene) -> None:
    goal = scene.send()
    await scene.tracker.wait_terminal(goal, 0.01)
    waiting = asyncio.create_task(scene.tracker.wait_terminal(goal, 10))
    await asyncio.sleep(0)
    scene.tracker.end(goal, S.REJECTED, error=GoalError("goal_rejected", "no"))
    await asyncio.wait_for(waiting, 1)
    other = scene.send(B)
    waiting = asyncio.create_task(scene.tracker.wait_terminal(other, 10))
    await asyncio.sleep(0)
    scene.tracker.release_all()
    await asyncio.wait_for(waiting, 1)


async def test_memory_is_bounded(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(goal_machine, "MAX_REMEMBERED", 10)
    monkeypatch.setattr(later_module, "MAX_REMEMBERED", 10)
    monkeypatch.setattr(goal_machine, "MAX_LOST", 5)
    for number in range(50):
        goal = scene.send(f"{number:08d}-0000-4000-8000-000000000000")
        scene.reasons.put(goal.goal_id, GoalError("x", "y"))
        scene.tracker.lose(goal, GoalError("action_server_lost", "gone"))
    assert len(scene.tracker.live) == 5
    assert len(scene.tracker._machine._ended) <= 10
    assert len(scene.reasons) <= 10


async def test_nothing_that_follows_an_end_is_told_before_it_where_a_history_is_shared(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another gateway may tell of the end first; a reader of ours that goes there resumes after what it had here."""
    monkeypatch.setattr(scene.history, "shared", True)
    first, second = scene.send(A), scene.send(B)
    for goal in (first, second):
        scene.tracker.move(goal, S.EXECUTING)
    scene.status((A, S.SUCCEEDED))
    scene.feedback(1, B)
    await asyncio.sleep(0)
    scene.port.answer(A, S.SUCCEEDED, b"{}")
    assert (await scene.events())[-3:] == ["status:succeeded", "result:succeeded", "feedback:1"]
    monkeypatch.setattr(tracker_module, "RESERVE_FOR", 0.01)
    scene.status((B, S.SUCCEEDED))
    scene.hub.publish(message_event("battery", b"{}", scene.hub.clock.stamp(0)))
    await asyncio.sleep(0.05)
    assert not scene.hub._line, "a result that does not come holds nothing up for long"
