"""The battery's past in buckets is the same whether it is reckoned here or in a database, stored or waiting."""

import asyncio
import random
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import Event, robot_event
from dock_gateway.storage import battery, reader
from dock_gateway.storage.battery import FIELDS, BatterySpan, Bucket
from tests.support.history import START_NS, history_at, make_event, open_at, open_place, settled, written

SECOND = 10**9
START = START_NS // (30 * SECOND) * (30 * SECOND)


def state(at: float, *, robot: str = "/", status: int = 2, **measured: float | None) -> Event:
    """A battery message, so many seconds after the start."""
    fields = dict.fromkeys(FIELDS) | measured
    document = {"power_supply_status": status, "cell_voltage": [3.7], **fields}
    return robot_event("battery", {"state": document}, START + round(at * SECOND), robot=robot)


def span(since: float, until: float, step: float = 1.0, robot: str = "/") -> BatterySpan:
    return BatterySpan(robot, START + round(since * SECOND), START + round(until * SECOND), round(step * SECOND))


def rows(buckets: list[Bucket], field: str = "voltage") -> list[tuple[Any, ...]]:
    return [
        (
            (bucket.stamp - START) / SECOND,
            bucket.status,
            bucket.tallies[field].mean,
            bucket.tallies[field].low,
            bucket.tallies[field].high,
        )
        for bucket in buckets
    ]


async def test_buckets(place: str, tmp_path: Path) -> None:
    async with open_place(place, tmp_path) as history:
        for event in (
            state(0.1, voltage=12.0, percentage=0.5),
            state(0.9, voltage=11.0, status=1),
            state(0.5, voltage=16.0, status=4),
            state(3.0, status=3),
            state(4.0, voltage=2.5, status=0),
            state(2.0, robot="/robot1", voltage=99.0),
            make_event(1, "cmd_vel"),
        ):
            history.record_event(event)
        await settled(history)
        found = await history.battery(span(0, 10))
        assert rows(found) == [
            (0.9, 1, 13.0, 11.0, 16.0),
            (3.0, 3, None, None, None),
            (4.0, 0, 2.5, 2.5, 2.5),
        ]
        assert rows(found, "percentage")[0] == (0.9, 1, 0.5, 0.5, 0.5)
        assert rows(found, "temperature")[0] == (0.9, 1, None, None, None)
        assert rows(await history.battery(span(0.5, 4))) == [(0.9, 1, 13.5, 11.0, 16.0), (3.0, 3, None, None, None)]
        assert rows(await history.battery(span(3, 3.000000001))) == [(3.0, 3, None, None, None)]
        assert rows(await history.battery(span(0, 10, 10)))[0][:2] == (4.0, 0)
        assert rows(await history.battery(span(0, 10, robot="/robot1"))) == [(2.0, 2, 99.0, 99.0, 99.0)]
        assert await history.battery(span(5, 10)) == []
        assert await history.battery(span(0, 10, robot="/robot2")) == []


async def test_what_cannot_be_right_is_not_drawn(place: str, tmp_path: Path) -> None:
    async with open_place(place, tmp_path) as history:
        for event in (
            state(0.0, voltage=12.0, percentage=12.0, current=-2000.0, temperature=300.0),
            state(0.1, voltage=-1.0, percentage=-0.01, current=-1.0, temperature=-300.0),
            state(0.2, voltage=12_000.0, percentage=1.02, current=3.0, temperature=20.0),
            state(0.3, voltage=0.0, percentage=0.0),  # a driver before its first measurement
            state(0.4, percentage=-0.0005),
        ):
            history.record_event(event)
        await settled(history)
        found = await history.battery(span(0, 1))
        assert rows(found) == [(0.4, 2, 6.0, 0.0, 12.0)]
        assert rows(found, "percentage") == [(0.4, 2, 0.5, 0.0, 1.0)]
        assert rows(found, "current") == [(0.4, 2, 1.0, -1.0, 3.0)]
        assert rows(found, "temperature") == [(0.4, 2, 20.0, 20.0, 20.0)]
        to_100 = rows(await history.battery(replace(span(0, 1), counts_to_100=True)), "percentage")
        assert to_100 == [(0.4, 2, pytest.approx((0.12 + 0.0102) / 3), 0.0, pytest.approx(0.12))]


async def test_what_waits_counts_and_counts_once(database_url: str, tmp_path: Path) -> None:
    """Stored, waiting, or both, as while it is being written; early, late and in between."""
    chance = random.Random(5)
    events = [
        state(
            chance.uniform(0, 20),
            status=chance.randrange(5),
            **{name: chance.choice([None, round(chance.uniform(-50, 50), 3)]) for name in FIELDS},
        )
        for _ in range(300)
    ]
    async with open_place("memory:", tmp_path) as memory, open_at(database_url, tmp_path) as history:
        for event in events:
            memory.record_event(event)
        for event in events[:200]:
            history.record_event(event)
        await written(history)
        for event in events[150:]:
            history.record_event(event)
        for asked in (span(0, 20), span(3.3, 17.7, 0.37), span(0, 20, 30), span(19, 40)):
            expected, found = await memory.battery(asked), await history.battery(asked)
            for field in FIELDS:
                assert rows(found, field) == [pytest.approx(row, nan_ok=True) for row in rows(expected, field)]
        await written(history)
        assert sum(bucket.tallies["voltage"].count for bucket in await history.battery(span(0, 20))) == sum(
            bucket.tallies["voltage"].count for bucket in await memory.battery(span(0, 20))
        )


async def test_the_index_is_used(database_url: str, tmp_path: Path) -> None:
    statements: list[tuple[str, Any]] = []

    def explain(connection: sa.Connection) -> str:
        def noted(_: object, __: object, statement: str, parameters: Any, *___: object) -> None:
            statements.append((statement, parameters))

        sa.event.listen(connection, "before_cursor_execute", noted)
        battery.battery(connection, span(0, 10), "~")
        sa.event.remove(connection, "before_cursor_execute", noted)
        statement, parameters = next(each for each in statements if "GROUP BY" in each[0])
        how = "EXPLAIN QUERY PLAN " if connection.dialect.name == "sqlite" else "EXPLAIN "
        return str(connection.exec_driver_sql(how + statement, parameters).all())

    async with open_at(database_url, tmp_path, max_waiting=5000) as history:
        for number in range(5000):
            history.record_event(state(number, robot=f"/robot{number % 50}", voltage=1.0))
        await written(history)
        if database_url.startswith("postgresql"):
            await history.database.write(lambda connection: connection.exec_driver_sql("ANALYZE events") and None)
        assert "battery_events" in await history.database.read(explain)


async def test_what_takes_too_long_does_not_stop_the_rest(
    sqlite_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def slow(*_: object) -> tuple[dict[int, Bucket], list[Event]]:
        time.sleep(0.5)
        return {}, []

    async with open_at(sqlite_url, tmp_path) as history:
        monkeypatch.setattr(battery, "battery", slow)
        monkeypatch.setattr(reader, "MUCH_TIMEOUT", 0.1)
        asking = asyncio.gather(*(history.battery(span(0, 10)) for _ in range(5)), return_exceptions=True)
        for _ in range(10):
            await history.get("goal-0001")
            await asyncio.sleep(0.02)
        for error in await asking:
            assert isinstance(error, Unavailable)
            assert "request less data" in error.detail
        assert history.stats().database_reachable


async def test_a_database_that_is_away_is_said_to_be(sqlite_url: str, tmp_path: Path) -> None:
    history = history_at(sqlite_url, tmp_path, max_waiting=10)
    with pytest.raises(Unavailable, match="does not answer"):
        await history.battery(span(0, 10))
