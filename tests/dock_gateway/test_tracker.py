"""Goals as ROS tells of them: in any order, twice, too late. The port is a fake; tests/system has the real one."""

import asyncio
from collections.abc import AsyncIterator
from datetime import UTC, datetime
from typing import Any

import orjson
import pytest

from dock_gateway import later as later_module
from dock_gateway import tracker as tracker_module
from dock_gateway.errors import Unavailable
from dock_gateway.goals import Goal, GoalError, GoalStatus
from dock_gateway.history import MemoryHistory
from dock_gateway.hub import Hub, Subscriber
from dock_gateway.interest import Interest
from dock_gateway.later import Later
from dock_gateway.ros.actions import StatusReport
from dock_gateway.tracker import GoalTracker
from tests.support.calls import FakeCall

A, B = "aaaaaaaa-0000-4000-8000-000000000000", "bbbbbbbb-0000-4000-8000-000000000000"
S = GoalStatus


class FakePort:
    """Answers to `request_result` are (status, result) pairs that the test sets."""

    action_name = "/dock"
    action_type = "pkg/action/Dock"

    def __init__(self) -> None:
        self.calls: dict[str, list[FakeCall]] = {}

    def request_result(self, goal_id: str) -> FakeCall:
        call = FakeCall()
        self.calls.setdefault(goal_id, []).append(call)
        return call

    def read_result(self, response: Any) -> Any:
        return response

    def answer(self, goal_id: str, status: GoalStatus | None, result: bytes | None = None) -> None:
        self.calls[goal_id][-1].response.set_result((status, result))


class Scene:
    def __init__(self) -> None:
        self.hub = Hub(queue_limit=100, max_subscribers=10)
        self.history = MemoryHistory(100)
        self.returned: list[Goal] = []
        self.port = FakePort()
        self.reasons: Later[GoalError] = Later(0.1)
        self.tracker = GoalTracker(self.port, self.hub, self.history, self.reasons)  # type: ignore[arg-type]
        self.tracker.on_return = self.returned.append
        self.subscriber: Subscriber = self.hub.subscribe(Interest())
        self.stamp = 1

    def send(self, goal_id: str = A) -> Goal:
        goal = Goal(goal_id, "/dock", "pkg/action/Dock", datetime.now(UTC))
        self.history.record(goal)
        self.tracker.add(goal)
        return goal

    def status(self, *reports: tuple[str, GoalStatus]) -> None:
        self.stamp += 1
        self.tracker.on_status([StatusReport(goal_id, status, 1) for goal_id, status in reports], self.stamp)

    def feedback(self, number: int, goal_id: str = A) -> None:
        self.stamp += 1
        self.tracker.on_feedback(goal_id, b'{"n":%d}' % number, self.stamp)

    async def events(self) -> list[str]:
        """What subscribers got: `status:executing`, `feedback:1`, `result:succeeded`."""
        await asyncio.sleep(0.05)
        described = []
        for event in (await self.subscriber.take(0.01))[0]:
            document = orjson.loads(event.data)
            detail = document["feedback"]["n"] if document["type"] == "feedback" else document["status"]
            described.append(f"{document['type']}:{detail}")
        return described


@pytest.fixture
async def scene(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Scene]:
    monkeypatch.setattr(tracker_module, "RESULT_WAIT", 0.05)
    monkeypatch.setattr(tracker_module, "END_STAMP_WAIT", 0.01)
    monkeypatch.setattr(tracker_module, "LOOK_UP_PAUSES", ())
    monkeypatch.setattr(tracker_module, "LOOK_AGAIN_AFTER", 0.02)
    scene = Scene()
    yield scene
    await scene.tracker.close()


async def test_the_usual_order(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.move(goal, S.ACCEPTED)
    scene.tracker.request_result(goal)
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


async def test_the_sender_is_answered_before_the_result_is_asked_for(scene: Scene) -> None:
    goal = scene.send()
    with scene.tracker.sending(goal):
        scene.status((A, S.EXECUTING))
        scene.tracker.request_result(goal)
    assert scene.port.calls == {}
    await asyncio.sleep(0.03)
    assert len(scene.port.calls[A]) == 1
    scene.tracker.request_result(goal)
    assert len(scene.port.calls[A]) == 1


@pytest.mark.parametrize("status", [S.REJECTED, S.LOST, S.PENDING])
async def test_no_result_is_asked_for_where_there_will_be_none(scene: Scene, status: GoalStatus) -> None:
    goal = scene.send()
    with scene.tracker.sending(goal):
        if status is S.REJECTED:
            scene.tracker.end(goal, S.REJECTED, error=GoalError("goal_rejected", "no"))
        elif status is S.LOST:
            scene.tracker.lose(goal, GoalError("action_server_timeout", "no answer"))
    await asyncio.sleep(0.03)
    assert scene.port.calls == {}
    if status is S.LOST:  # and it turns up
        scene.status((A, S.EXECUTING))
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


async def test_a_goal_that_another_gateway_is_just_storing(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tracker_module, "LOOK_UP_PAUSES", (0.01, 5.0))
    scene.status((B, S.EXECUTING))
    await asyncio.sleep(0)
    scene.history.record(Goal(B, "/dock", "pkg/action/Dock", datetime.now(UTC), goal=b'{"n":1}'))
    assert await scene.events() == ["status:executing"]
    goal = scene.tracker.live[B]
    assert (goal.origin, goal.goal) == ("gateway", b'{"n":1}')


async def test_a_goal_that_another_gateway_stores_late(scene: Scene) -> None:
    scene.status((B, S.EXECUTING))
    await asyncio.sleep(0.001)
    goal = scene.tracker.live[B]
    assert goal.origin == "external"
    scene.history.record(Goal(B, "/dock", "pkg/action/Dock", datetime.now(UTC), goal=b'{"n":1}'))
    assert await scene.events() == ["status:executing", "status:executing"]
    assert (goal.origin, goal.goal) == ("gateway", b'{"n":1}')


async def test_a_goal_of_someone_else(scene: Scene) -> None:
    scene.status((B, S.EXECUTING))
    goal = scene.tracker.live[B]
    assert (goal.origin, goal.goal) == ("external", None)
    kept = await scene.history.get(B)
    assert kept is not None
    assert kept.origin == "external"
    await asyncio.sleep(0)
    scene.port.answer(B, S.CANCELED, b'{"n":0}')
    assert await scene.events() == ["status:executing", "status:canceled", "result:canceled"]


async def test_goals_that_ended_before_we_came_get_their_result_too(scene: Scene) -> None:
    scene.status((A, S.SUCCEEDED), (B, S.ABORTED))
    await asyncio.sleep(0)
    scene.port.answer(A, S.SUCCEEDED, b'{"n":9}')
    await asyncio.sleep(0.2)
    a, b = await scene.history.get(A), await scene.history.get(B)
    assert a is not None
    assert b is not None
    assert (a.status, a.result, a.error) == (S.SUCCEEDED, b'{"n":9}', None)
    assert (b.status, b.result) == (S.ABORTED, None)
    assert b.error == GoalError("result_unavailable", b.error.detail if b.error else "")


async def test_a_result_after_the_time_still_counts(scene: Scene) -> None:
    goal = scene.send()
    scene.status((A, S.SUCCEEDED))
    await asyncio.sleep(0.2)
    assert goal.status is S.SUCCEEDED
    assert goal.result is None
    scene.port.answer(A, S.SUCCEEDED, b'{"n":1}')
    await asyncio.sleep(0.05)
    assert goal.result == b'{"n":1}'
    assert (await scene.events())[-2:] == ["result:succeeded", "result:succeeded"]


async def test_an_aborted_goal_says_why(scene: Scene) -> None:
    goal = scene.send()
    scene.reasons.put(A, GoalError("battery_lost", "no battery for 60 s"))
    scene.tracker.request_result(goal)
    await asyncio.sleep(0)
    scene.port.answer(A, S.ABORTED, b"{}")
    await asyncio.sleep(0.05)
    assert goal.error == GoalError("battery_lost", "no battery for 60 s")


async def test_a_reason_that_comes_a_moment_later(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.request_result(goal)
    await asyncio.sleep(0)
    scene.port.answer(A, S.ABORTED, b"{}")
    await asyncio.sleep(0.05)
    scene.reasons.put(A, GoalError("timeout", "took too long"))
    await asyncio.sleep(0.05)
    await asyncio.sleep(0.05)
    assert goal.error == GoalError("timeout", "took too long")


async def test_lost_and_back(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.move(goal, S.EXECUTING)
    scene.tracker.lose(goal, GoalError("action_server_lost", "silent"))
    assert scene.tracker.running() == []
    scene.feedback(1)
    assert goal.status is S.EXECUTING
    assert goal.error is None
    assert scene.returned == [goal]


async def test_an_unknown_goal_is_lost_only_while_it_runs(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.move(goal, S.EXECUTING)
    scene.tracker.request_result_again(goal)
    await asyncio.sleep(0)
    scene.port.answer(A, None)
    await asyncio.sleep(0.05)
    assert goal.status is S.LOST
    assert goal.error is not None
    assert "restarted" in goal.error.detail


async def test_a_server_that_is_not_there_is_asked_again_later(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.request_result(goal)
    await asyncio.sleep(0)
    scene.port.calls[A][-1].response.set_exception(Unavailable("nobody"))
    await asyncio.sleep(0.05)
    scene.tracker.request_result(goal)
    await asyncio.sleep(0)
    assert len(scene.port.calls[A]) == 2


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
    monkeypatch.setattr(tracker_module, "MAX_REMEMBERED", 10)
    monkeypatch.setattr(later_module, "MAX_REMEMBERED", 10)
    monkeypatch.setattr(tracker_module, "MAX_LOST", 5)
    for number in range(50):
        goal = scene.send(f"{number:08d}-0000-4000-8000-000000000000")
        scene.reasons.put(goal.goal_id, GoalError("x", "y"))
        scene.tracker.lose(goal, GoalError("action_server_lost", "gone"))
    assert len(scene.tracker.live) == 5
    assert len(scene.tracker._ended) <= 10
    assert len(scene.reasons) <= 10
