"""Goals, events and histories for tests of the history. As a program: a process that keeps goals, and can be killed."""

import asyncio
import sqlite3
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from dock_gateway.core.cursor import Cursor
from dock_gateway.core.event import Event, event_id
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.storage import GoalFilter, History
from dock_gateway.storage.retention import Limits
from dock_gateway.storage.spool import Spool
from tests.support.waiting import PATIENCE, until

NOW = datetime(2026, 11, 21, tzinfo=UTC)
EVERYTHING = frozenset({"goals", "battery", "cmd_vel"})


def make_goal(number: int, status: GoalStatus = GoalStatus.SUCCEEDED, action: str = "/dock", **more: object) -> Goal:
    goal = Goal(f"goal-{number:04d}", action, "pkg/action/T", NOW + timedelta(seconds=number), goal=b'{"order":5}')
    goal.status = status
    for name, value in more.items():
        setattr(goal, name, value)
    return goal


def make_event(number: int, topic: str = "goals", *, droppable: bool = False, goal_id: str | None = "g1") -> Event:
    """An event of today; the number orders them."""
    identity = event_id(START_NS + number, "f" if droppable else "s", "g1")
    named = goal_id if topic == "goals" else None
    data = b'{"id":"%s","text":"\xc3\xa4"}' % identity.encode()
    return Event(data, topic, named, "/dock" if named else None, droppable, id=identity)


START_NS = time.time_ns()
GENEROUS = Limits(10**9, 10**9, 10**9, 10**12, 10**9, 10**9)


def history_at(url: str, folder: Path, *, max_waiting: int = 1000, **limits: float) -> History:
    """A history that is not open yet; limits as `Limits` has them."""
    keep = replace(GENEROUS, **limits)  # type: ignore[arg-type]
    return History(url, Spool(folder / "spool"), max_waiting=max_waiting, limits=keep)


@asynccontextmanager
async def open_at(url: str, folder: Path, *, max_waiting: int = 1000, **limits: float) -> AsyncIterator[History]:
    """A history, closed in the end."""
    history = history_at(url, folder, max_waiting=max_waiting, **limits)
    await history.open()
    try:
        yield history
    finally:
        await history.close()


class HistoryInMemory(History):
    """A history in memory, which needs no closing.

    Its writer runs if it is made on an event loop. What it has not written yet is read as if it were, except by
    statistics.
    """

    def __init__(self) -> None:
        super().__init__("memory:", Spool(None), max_waiting=10_000, limits=GENEROUS)
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            return
        self.writer.start()
        self._tasks = [asyncio.create_task(self._sealer.run())]


@asynccontextmanager
async def open_place(url: str, folder: Path, **limits: int) -> AsyncIterator[History]:
    """A history in memory or in a database, closed in the end."""
    async with open_at(url, folder, **limits) as history:
        yield history


@contextmanager
def locked(path: str) -> Iterator[None]:
    """Another process writes to the SQLite file and does not come to an end."""
    connection = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    connection.execute("PRAGMA journal_mode=WAL")
    connection.execute("BEGIN EXCLUSIVE")
    try:
        yield
    finally:
        connection.execute("ROLLBACK")
        connection.close()


async def settled(history: History) -> None:
    """Wait until all is where it is kept."""
    await written(history)


async def written(history: History, timeout: float = PATIENCE) -> None:
    """Wait until all is in the database."""
    await until(lambda: not history.stats().waiting and not history.stats().spooled, timeout)


async def page_of(history: History, *, limit: int = 100, before: Cursor | None = None, **wanted: Any) -> list[Goal]:
    """A page of the goals that are `GoalFilter` so."""
    for name in ("action_names", "statuses"):
        wanted[name] = frozenset(wanted.get(name, ()))
    return await history.page(GoalFilter(**wanted), limit=limit, before=before)


async def timed(work: Awaitable[object]) -> float:
    """Seconds that something takes."""
    start = time.perf_counter()
    await work
    return time.perf_counter() - start


async def main(command: str, url: str, folder: str, *arguments: str) -> None:
    """`keep FIRST COUNT`: keep goals, say so, and wait to be killed. `claim KEY NAME`: claim, and say whose it is."""
    async with open_at(url, Path(folder)) as history:
        if command == "claim":
            await until(lambda: history.stats().database_reachable)
            print(*await history.claim(arguments[0], arguments[1], "print"), history.stats().database_reachable)
            return
        first, count = map(int, arguments)
        for number in range(first, first + count):
            await history.add(make_goal(number, GoalStatus.PENDING), f"key-{number}")
            print(f"kept {number} spooled {history.stats().spooled}", flush=True)
        print("all kept", flush=True)
        await asyncio.sleep(60)


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))


def explain(connection: sa.Connection, work: Callable[[sa.Connection], object]) -> str:
    """How the database plans the first query of a function."""
    asked: list[tuple[str, Any]] = []

    def note(_: object, __: object, statement: str, parameters: Any, *___: object) -> None:
        asked.append((statement, parameters))

    sa.event.listen(connection, "before_cursor_execute", note)
    work(connection)
    sa.event.remove(connection, "before_cursor_execute", note)
    how = "EXPLAIN QUERY PLAN " if connection.dialect.name == "sqlite" else "EXPLAIN "
    statement, parameters = next(each for each in asked if each[0].startswith("SELECT"))
    return str(connection.exec_driver_sql(how + statement, parameters).all())
