"""A goal turns up before the gateway that sent it has stored it."""

import asyncio
from datetime import UTC, datetime

import pytest

from dock_gateway import senders as senders_module
from dock_gateway.goals import Goal
from tests.support.tracking import B, S, Scene, scene

__all__ = ["scene"]


async def test_a_goal_that_another_gateway_is_just_storing(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(senders_module, "LOOK_UP_PAUSES", (0.01, 5.0))
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


async def test_what_is_held_back_is_told_as_it_was(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(senders_module, "LOOK_UP_PAUSES", (0.02,))
    scene.status((B, S.ACCEPTED))
    goal = scene.tracker.live[B]
    await asyncio.sleep(0.001)
    scene.feedback(1, B)
    scene.feedback(2, B)
    scene.tracker.on_progress(goal, "CONTROLLING", 0, 7)
    scene.status((B, S.EXECUTING))
    scene.feedback(3, B)
    sent_at = datetime(2026, 1, 1, tzinfo=UTC)
    scene.history.record(Goal(B, "/dock", "pkg/action/Dock", sent_at, goal=b'{"n":1}'))
    events = await scene.documents()
    states = [event for event in events if event["type"] == "status"]
    assert [event["feedback"]["n"] for event in events if event["type"] == "feedback"] == [1, 2, 3]
    assert [(state["status"], state["feedback_count"], state["stage"]) for state in states] == [
        ("accepted", 0, None),
        ("accepted", 2, "CONTROLLING"),
        ("executing", 2, "CONTROLLING"),
    ]
    assert states[0]["updated_at"] < states[1]["updated_at"]
    for state in states:
        assert (state["origin"], state["goal"]) == ("gateway", {"n": 1})
        assert datetime.fromisoformat(state["created_at"]) == sent_at
        assert state["last_event_id"] == state["id"]
    kept = await scene.history.get(B)
    assert kept is not None
    assert goal.last_event_id == kept.last_event_id == events[-1]["id"]


async def test_what_is_held_back_goes_on_from_what_is_known(scene: Scene) -> None:
    known = Goal(B, "/dock", "pkg/action/Dock", datetime.now(UTC), status=S.EXECUTING, stage="CONTROLLING")
    known.feedback_count = 10
    scene.history.record(known)
    scene.status((B, S.EXECUTING))
    scene.feedback(1, B)
    scene.status((B, S.CANCELING))
    states = [event for event in await scene.documents() if event["type"] == "status"]
    assert [(state["feedback_count"], state["stage"]) for state in states] == [(10, "CONTROLLING"), (11, "CONTROLLING")]
    assert scene.tracker.live[B].feedback_count == 11


@pytest.mark.parametrize("error", [RuntimeError("broken"), asyncio.CancelledError()])
async def test_a_look_up_that_fails_holds_nothing_back(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, error: BaseException
) -> None:
    async def get(goal_id: str) -> Goal | None:
        raise error

    monkeypatch.setattr(scene.history, "get", get)
    scene.status((B, S.EXECUTING))
    await asyncio.sleep(0.001)
    scene.feedback(1, B)
    assert await scene.events() == ["status:executing", "feedback:1"]
    assert scene.tracker.live[B].origin == "external"
    assert (f"while looking up who sent goal {B}" in caplog.messages) is isinstance(error, Exception)


async def test_feedback_that_came_before_the_look_up_counts_once(scene: Scene) -> None:
    scene.feedback(1, B)
    scene.status((B, S.EXECUTING))
    scene.feedback(2, B)
    assert await scene.events() == ["feedback:1", "status:executing", "feedback:2"]
    goal, kept = scene.tracker.live[B], await scene.history.get(B)
    assert kept is not None
    assert (goal.feedback_count, kept.feedback_count, goal.origin) == (2, 2, "external")
