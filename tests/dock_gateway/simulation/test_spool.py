"""What goes to the spool when, in virtual time: what the database takes does not."""

import asyncio
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import pytest

from dock_gateway.core.goal import GoalStatus
from dock_gateway.storage import History
from tests.dock_gateway.simulation.database import Disk, SimulatedDatabase, SimulatedSpool
from tests.dock_gateway.simulation.gateway import FOREVER, simulated
from tests.support.history import make_event, make_goal
from tests.support.virtual import run


class CountingSpool(SimulatedSpool):
    """Notes when something was appended, in seconds since `began`."""

    began = 0.0

    def __init__(self) -> None:
        super().__init__({})
        self.appended: list[tuple[float, str]] = []

    async def append(self, entries: list[Any]) -> None:
        now = asyncio.get_running_loop().time() - self.began
        self.appended += [(now, getattr(entry, "goal_id", "")) for entry in entries]
        await super().append(entries)


async def record_for(seconds: float, delay: float) -> CountingSpool:
    """A goal and an event of it each 0.05 s, in a database whose transactions take twice `delay`."""
    disk, spool = Disk(), CountingSpool()
    disk.empty()
    owner = SimpleNamespace(dead=False)
    database = SimulatedDatabase(disk, owner, lambda: delay, shared=False)
    with patch("dock_gateway.storage.history.open_database", lambda _: database):
        history = History("", spool, max_waiting=1000, limits=FOREVER)  # type: ignore[arg-type]
    await history.open()
    spool.began = asyncio.get_running_loop().time()
    for number in range(round(seconds / 0.05)):
        goal = make_goal(number, GoalStatus.EXECUTING)
        history.record(goal)
        history.record_event(make_event(number, goal_id=goal.goal_id))
        await asyncio.sleep(0.05)
    return spool


def test_what_the_database_takes_is_not_spooled() -> None:
    with simulated():
        assert run(record_for(20.0, delay=0.01)).appended == []


@pytest.mark.parametrize("delay", [3.0, 100.0], ids=["slow", "away"])
def test_what_it_does_not_take_is_spooled_within_half_a_second(delay: float) -> None:
    with simulated():
        spool = run(record_for(2.0, delay))
    at = {goal_id: time for time, goal_id in spool.appended}
    waited = [at[f"goal-{number:04d}"] - 0.05 * number for number in range(30)]
    assert min(waited) > 0.24
    assert max(waited) < 0.51
