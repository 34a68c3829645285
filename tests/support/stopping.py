"""A real `Stopper` and `Interlock`, and robots and actions that are fakes: they note what they are told."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from dock_gateway.audit.record import RequestRecord
from dock_gateway.core.errors import NotFound
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import is_under
from dock_gateway.core.namespace import ALL_ROBOTS, read_namespace
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import TIMING, Stopper, StopTiming
from tests.support.audit import AuditList, audit_parts
from tests.support.parts import FakeParts


class FakeWheels:
    """`cmd_vel` of a robot."""

    subscribers = 1

    def __init__(self) -> None:
        self.zeros = 0
        self.failures = 0  # so many more are not taken

    def publish_zero(self) -> None:
        if self.failures:
            self.failures -= 1
            raise RuntimeError("ROS does not take it")
        self.zeros += 1


class FakeTopic:
    """`stop_latched` of a robot."""

    def __init__(self) -> None:
        self.said: list[bool | None] = []
        self.failures = 0

    def publish(self, *, latched: bool) -> None:
        if self.failures:
            self.failures -= 1
            raise RuntimeError("ROS does not take it")
        self.said.append(latched)

    async def withdraw(self) -> None:
        self.said.append(None)

    def held_by(self) -> str | None:
        return None

    def let_go(self) -> None:
        pass


class FakeGoals:
    """The goals of an action; its server answers once `answers` is set, or fails with `error`."""

    def __init__(self) -> None:
        self.cancels = 0
        self.stops = 0  # of goals that have not been sent yet
        self.error: Exception | None = None
        self.running: list[str] = []
        self.answers = asyncio.Event()
        self.answers.set()

    def stop(self) -> None:
        self.stops += 1

    @property
    def uncanceled(self) -> bool:
        return bool(self.running)

    async def cancel_all(self) -> list[str]:
        self.cancels += 1
        await self.answers.wait()
        if self.error is not None:
            raise self.error
        canceled, self.running = self.running, []
        return canceled


class FakeFleet:
    """Robots of some namespaces, each with an action, and what stops them.

    Attributes:
        robots: Their `wheels` and `topic`, by namespace.
        goals: What runs on the action of each.
        actions: Their actions.
        parts: What the API calls.
        audit: What was recorded.
    """

    def __init__(self, path: Path, *names: str, timing: StopTiming = TIMING) -> None:
        self.fanout = Fanout(queue_limit=10)
        self.file = LatchFile(path)
        self.interlock = Interlock(self.fanout, self.file, echo_after=0.02, retry_after=0.02)
        self.robots = {name: SimpleNamespace(namespace=name, wheels=FakeWheels(), topic=FakeTopic()) for name in names}
        for name, robot in self.robots.items():
            self.interlock.join(name, robot.topic)
        self.goals = {name: FakeGoals() for name in names}
        actions: Any = SimpleNamespace(under=self._actions_under)
        registry: Any = SimpleNamespace(place=self._place, under=self._robots_under)
        self.actions = {name: Action(f"{name.rstrip('/')}/dock", goals) for name, goals in self.goals.items()}
        self.stopper = Stopper(registry, actions, self.interlock, timing)
        self.audit = AuditList()
        self.parts = FakeParts(
            {**audit_parts(), RequestRecord: self.audit, Stopper: self.stopper, Settings: Settings()}
        )

    def _place(self, namespace: str | None = None) -> str:
        name = ALL_ROBOTS if namespace is None else read_namespace(namespace)
        if name not in self.robots and name != ALL_ROBOTS:
            raise NotFound(f"there is no robot {name}", code="robot_not_found")
        return name

    def _robots_under(self, namespace: str) -> list[Any]:
        return [robot for name, robot in self.robots.items() if is_under(name, namespace)]

    def _actions_under(self, namespace: str) -> list[Any]:
        return [action for name, action in self.actions.items() if is_under(name, namespace)]

    def zeros(self) -> list[int]:
        """How often each robot was told to stand still."""
        return [robot.wheels.zeros for robot in self.robots.values()]

    def said(self) -> list[list[bool | None]]:
        """What was said on each `stop_latched`."""
        return [robot.topic.said for robot in self.robots.values()]

    async def close(self) -> None:
        await self.stopper.close()
        await self.interlock.close()


class Action:
    """An action as a stop sees it."""

    def __init__(self, name: str, goals: FakeGoals) -> None:
        self.name = name
        self.delivery = self.canceler = goals


@asynccontextmanager
async def fake_fleet(path: Path, *names: str, timing: StopTiming = TIMING) -> AsyncIterator[FakeFleet]:
    """A fleet that is closed at the end."""
    fleet = FakeFleet(path, *names, timing=timing)
    try:
        yield fleet
    finally:
        await fleet.close()
