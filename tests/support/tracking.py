"""Goals on one action, as ROS tells of them: a tracker whose port is a fake."""

import time
from collections.abc import AsyncIterator
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import orjson
import pytest

from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.goal_machine import GoalChange, GoalMachine
from dock_gateway.goals.limits import GoalLimits
from dock_gateway.goals.tracker import BeforeLost, GoalTracker
from dock_gateway.ros.status import StatusReport
from tests.support.action_port import FakeActionPort
from tests.support.history import HistoryInMemory

A, B = "aaaaaaaa-0000-4000-8000-000000000000", "bbbbbbbb-0000-4000-8000-000000000000"
S = GoalStatus


QUICK = GoalLimits(result_wait=0.05, ask_again_after=0.03, end_stamp_wait=0.01)


class Scene:
    def __init__(self, limits: GoalLimits = QUICK, reasons: PendingFacts[GoalError] | None = None) -> None:
        self.fanout = Fanout(queue_limit=100)
        self.history = HistoryInMemory()
        self.returned: list[Goal] = []
        self.port = FakeActionPort()
        port: Any = self.port
        self.reasons: PendingFacts[GoalError] = reasons or PendingFacts(0.1)
        self.before_lost: list[BeforeLost] = []
        self.tracker = GoalTracker(
            port, self.fanout, self.history, self.reasons, before_lost=self.before_lost, limits=limits
        )
        self.tracker.on[GoalChange.RETURNED].append(self.returned.append)
        self.subscriber: Subscriber = self.fanout.subscribe(EventFilter())
        self.stamp = 0

    def send(self, goal_id: str = A) -> Goal:
        goal = Goal(goal_id, "/dock", "pkg/action/Dock", datetime.now(UTC))
        self.history.record(goal)
        self.tracker.apply(GoalMachine.add, goal)
        return goal

    def status(self, *reports: tuple[str, GoalStatus]) -> None:
        self.stamp = time.time_ns()
        self.tracker.on_status([StatusReport(goal_id, status, 1) for goal_id, status in reports], self.stamp)

    def feedback(self, number: int, goal_id: str = A) -> None:
        self.stamp = time.time_ns()
        self.tracker.on_feedback(goal_id, b'{"n":%d}' % number, self.stamp)

    async def documents(self) -> list[dict[str, Any]]:
        """What subscribers got."""
        events, quiet = [], 0
        while quiet < 3:  # a busy machine may wake everything at once
            batch, _ = await self.subscriber.take(0.03)
            quiet = 0 if batch else quiet + 1
            events += batch
        return [orjson.loads(event.data) for event in events]

    async def events(self) -> list[str]:
        """What subscribers got: `status:executing`, `feedback:1`, `result:succeeded`."""
        described = []
        for document in await self.documents():
            detail = document["feedback"]["n"] if document["type"] == "feedback" else document["status"]
            described.append(f"{document['type']}:{detail}")
        return described


@pytest.fixture
async def scene(request: pytest.FixtureRequest) -> AsyncIterator[Scene]:
    """Indirect parameters are limits other than the `QUICK` ones."""
    scene = Scene(replace(QUICK, **getattr(request, "param", {})))
    yield scene
    await scene.tracker.close()


def limits(**changed: float) -> pytest.MarkDecorator:
    """Mark a test whose scene has other limits."""
    return pytest.mark.parametrize("scene", [changed], indirect=True, ids=[""])
