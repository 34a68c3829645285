"""A site for the tests of shared docks: robots and their goals are what the test says, time is virtual."""

import asyncio
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace
from typing import Any, cast

import orjson

from dock_gateway.core.dock_adapters import charging_dock
from dock_gateway.core.errors import NotFound
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.share import EVERYTHING
from dock_gateway.extensions.chargers.dock import DockBody, DockEntry, DockRecord, WaitEntry
from dock_gateway.extensions.chargers.shared_docks import SharedDocks
from dock_gateway.extensions.chargers.watch import DockWatch
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries
from tests.support.entries import SharedStore

NOON = datetime(2026, 11, 30, 12, tzinfo=UTC)


def now() -> datetime:
    """Return the virtual time."""
    return NOON + timedelta(seconds=asyncio.get_running_loop().time())


def docking(dock: str = "a", goal_id: str = "goal", status: GoalStatus = GoalStatus.EXECUTING) -> Goal:
    """A goal to a dock."""
    message = orjson.dumps({"desired_battery_state": {"location": dock}})
    made = Goal(goal_id, "/robot1/dock", "pkg/action/T", now(), goal=message, verb="dock")
    made.status = status
    return made


class Site:
    """A gateway with the shared docks `a` and `b`, which follows `/robot1`."""

    def __init__(self) -> None:
        self.records = SharedStore[DockRecord]()
        self.goals: dict[str, Goal] = {}
        self.robot: Any = SimpleNamespace(
            name="/robot1",
            docked=None,
            on_dock=False,
            battery=SimpleNamespace(age=0.1, stale_since=None),
            dock=None,
            goals=[],
            lost=[],
            last_goal=None,
        )
        self.there = True
        self.at_work = True
        book = SharedBook(SharedStore[DockEntry](), "shared_dock", 10)
        for name in ("a", "b"):
            book.put(name, DockBody().entry())
        action = SimpleNamespace(adapter=charging_dock.DOCK)
        self.docks = SharedDocks(
            book,
            SharedEntries(self.records),
            SharedEntries(SharedStore[WaitEntry]()),
            robots=cast("Any", SimpleNamespace(is_at_work=lambda _: self.at_work)),
            actions=cast("Any", SimpleNamespace(get=lambda _: action)),
            docks=cast("Any", None),
            labels=cast("Any", None),
            distances=cast("Any", None),
            can_drive=lambda _: True,
            clock=now,
        )
        self.watch = DockWatch(self.docks, cast("Any", self), cast("Any", self), EVERYTHING, clock=now)

    def states(self) -> list[Any]:
        """Stand in for the fleet."""
        return [self.robot] if self.there else []

    async def get(self, goal_id: str) -> Goal:
        """Stand in for the goals."""
        if goal_id not in self.goals:
            raise NotFound("no goal")
        return self.goals[goal_id]

    def sees(self, *, docked: bool | None) -> None:
        """Let the robot be docked or not."""
        self.robot.docked, self.robot.on_dock = docked, bool(docked)

    async def look(self, seconds: float = 0.0) -> DockRecord:
        """Let time pass, in which it looks each second; return the record of the dock `a`."""
        await self.docks.sync()
        for _ in range(int(seconds)):
            await asyncio.sleep(1.0)
            await self.watch.look()
        await self.watch.look()
        return self.records.known.get("a", DockRecord())
