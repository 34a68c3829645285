"""How long the statistics of many goals take, and what waits meanwhile.

`python -m tests.extensions.statistics.benchmark --help`.
"""

import argparse
import asyncio
import random
import time
import uuid
from collections.abc import Awaitable, Callable, Iterator
from contextlib import ExitStack
from datetime import UTC, datetime, timedelta
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import sqlalchemy as sa
from benchmarks.machine import describe

from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.extensions.statistics.tally import merged, tally_goals
from dock_gateway.storage import History
from dock_gateway.storage.rows import goal_row
from dock_gateway.storage.tables import goals
from tests.support.history import open_at
from tests.support.postgresql import running_postgresql
from tests.support.waiting import until

CHUNK = 500
DAYS = 365
START = datetime.now(UTC) - timedelta(days=DAYS)
MESSAGE = b'{"battery_state":"%s"}' % (b"x" * 700)
ENDS = {"succeeded": 90, "canceled": 3, "aborted": 5, "rejected": 1, "lost": 1}
CODES = ("failed_to_charge", "blocked", "failed_to_detect_dock", "timeout")


def make_goals(count: int) -> Iterator[dict[str, Any]]:
    """Yield the rows of docking goals of 50 robots in a year."""
    chance = random.Random(1)
    for number in range(count):
        action = f"/robot{chance.randrange(50)}/{chance.choice(('connect_to_charging_dock', 'undock'))}"
        created = START + timedelta(days=DAYS) * (number / count)
        goal = Goal(str(uuid.UUID(int=chance.getrandbits(128))), action, "p/action/T", created, goal=MESSAGE)
        goal.status = GoalStatus(chance.choices([*ENDS], [*ENDS.values()])[0])
        goal.feedback = goal.result = MESSAGE
        goal.retries = chance.randrange(3)
        goal.finished_at = created + timedelta(seconds=chance.lognormvariate(3.5, 0.5))
        if goal.status not in (GoalStatus.SUCCEEDED, GoalStatus.CANCELED):
            goal.error = GoalError(chance.choice(CODES), "a sentence of some length")
        yield goal_row(goal)


async def fill(history: History, count: int) -> None:
    """Write the goals in large transactions."""
    rows = make_goals(count)

    def write(connection: sa.Connection, piece: list[dict[str, Any]]) -> None:
        connection.execute(sa.insert(goals), piece)

    while piece := [*islice(rows, CHUNK)]:
        await history._database.write(write, piece, durable=False)  # noqa: SLF001


async def worst_of(work: Callable[[], Awaitable[object]], pause: float) -> float:
    """Repeat something until canceled; return the longest time that it took."""
    worst = 0.0
    try:
        while True:
            start = time.perf_counter()
            await work()
            worst = max(worst, time.perf_counter() - start - pause)
            await asyncio.sleep(0.005)
    except asyncio.CancelledError:
        return worst


async def measure(url: str, folder: Path, count: int) -> None:
    """Fill a history and tally it."""
    async with open_at(url, folder) as history:
        await until(lambda: history.stats().database_reachable)
        await fill(history, count)
        some = (await history.page(GoalFilter(), limit=1))[0].goal_id
        days = [(START + timedelta(days=n), START + timedelta(days=n + 1)) for n in range(DAYS + 1)]
        for name, spans in {"a year": [(START, days[-1][1])], "365 days": days, "30 days": days[-31:]}.items():
            watchers = [
                asyncio.create_task(worst_of(lambda: asyncio.sleep(0.002), 0.002)),
                asyncio.create_task(worst_of(lambda: history.get(some), 0.0)),
            ]
            await asyncio.sleep(0.1)
            start = time.perf_counter()
            found = await tally_goals(history, GoalFilter(), spans, by_action=len(spans) == 1)
            total = await asyncio.to_thread(lambda found=found: merged(t for each in found for t in each.values()))
            median = (await asyncio.to_thread(total.percentiles, 50))[0]
            took = time.perf_counter() - start
            for watcher in watchers:
                watcher.cancel()
            loop, read = await asyncio.gather(*watchers)
            print(
                f"{name}: {total.ended} goals in {took:.2f} s, median {median:.1f} s; at most, the event loop was late "
                f"by {1000 * loop:.0f} ms, and reading a goal took {1000 * read:.0f} ms"
            )


def main() -> None:
    """Measure SQLite and PostgreSQL."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--goals", type=int, default=1_000_000)
    parser.add_argument("--databases", nargs="+", default=["sqlite", "postgresql"])
    options = parser.parse_args()
    print(describe())
    for database in options.databases:
        with TemporaryDirectory() as folder, ExitStack() as stack:
            url = f"sqlite:///{folder}/history.db"
            if database == "postgresql":
                url = stack.enter_context(running_postgresql()).url
            print(f"{database}, {options.goals} goals")
            asyncio.run(measure(url, Path(folder), options.goals))


if __name__ == "__main__":
    main()
