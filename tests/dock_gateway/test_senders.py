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
