"""Whatever a hostile site tells, the goals, events, robots and answers of the honest one stay as they are."""

import asyncio
import itertools
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any
from unittest.mock import patch
from uuid import UUID

import orjson
import pytest
import sqlalchemy as sa
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dock_gateway.core.event import Event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.sites.tunnel.caller import TunnelAddress
from dock_gateway.storage import History, retention
from dock_gateway.storage.retention import OVERHEAD
from dock_hub import follower, pace
from dock_hub.fields import ForeignDocumentError
from dock_hub.follower import Follower
from dock_hub.goal_documents import Happening, ends_of, read_goal
from dock_hub.mirror import Mirror
from dock_hub.shares import BY_SITE, fair_share, sizes_of_sites
from dock_hub.site_view import MAX_BYTES, SiteView
from dock_hub.store import HubStore, SiteReports
from tests.dock_hub.documents import ROBOT, decoded
from tests.dock_hub.followed_site import FakeSite, snapshot, told
from tests.support.history import open_at
from tests.support.waiting import until

NOW = datetime.now(UTC).replace(microsecond=0)
HONEST = [str(UUID(int=number << 64)) for number in range(1, 11)]
# Bytes: twice as much as the honest site has.
MOST = 2 * len(HONEST) * 4 * OVERHEAD


def honest_goal(goal_id: str) -> Goal:
    goal = Goal(goal_id, "/berlin/robot1/dock", "pkg/action/Dock", NOW - timedelta(days=1), verb="dock")
    goal.status, goal.finished_at, goal.updated_at = GoalStatus.SUCCEEDED, NOW, NOW
    goal.goal = goal.result = b'{"ok":true}'
    return goal


def honest_news() -> SiteReports:
    goals = {goal_id: honest_goal(goal_id) for goal_id in HONEST}
    return SiteReports("berlin", goals, [end for goal in goals.values() for end in ends_of(goal)], "0-z-1")


@asynccontextmanager
async def hub_of(folder: Path, url: str = "", most: int = MOST) -> AsyncIterator[tuple[History, HubStore]]:
    """A hub with the goals of the honest site, and its retention."""
    async with open_at(url or f"sqlite:///{folder / 'hub.db'}", folder, goal_bytes=most) as history:
        await until(lambda: history.stats().database_reachable)
        history.retention.goals_by_size = BY_SITE
        store = HubStore(Mirror(history), Fanout(queue_limit=10))
        try:
            await store.keep(honest_news())
            yield history, store
        finally:
            await store.close()


async def of_honest(history: History) -> tuple[list[dict[str, Any]], list[Event], str | None]:
    """What the hub has of the honest site."""
    goals = await history.page(GoalFilter(namespace="/berlin"), limit=100)
    events = [event for goal_id in HONEST for event in await history.events_of(goal_id, kinds="sz", limit=100)]
    return [decoded(goal.document()) for goal in goals], events, await Mirror(history).cursor("berlin")


# What a hostile site tells.
times = st.one_of(
    st.sampled_from(["1972-01-01T00:00:00Z", "2126-01-01T00:00:00Z", "2199-12-31T23:59:59.999999Z", NOW.isoformat()]),
    st.datetimes(datetime(1960, 1, 1), datetime(2300, 1, 1), timezones=st.just(UTC)).map(datetime.isoformat),  # noqa: DTZ001
)
ids = st.one_of(st.sampled_from(HONEST), st.uuids().map(str), st.sampled_from(["f" * 32, "0" * 32]))
messages = st.none() | st.integers(1, 100_000)  # bytes
names = st.sampled_from(["/dock", "/robot1/dock", "/berlin/robot1/dock", "/", "/robot1/undock"])
goals = st.fixed_dictionaries(
    {
        "goal_id": ids, "action_name": names, "action_type": st.just("t"), "created_at": times, "updated_at": times,
        "finished_at": st.none() | times, "origin": st.sampled_from(["gateway", "external"]),
        "verb": st.sampled_from(["dock", None]), "status": st.sampled_from([*GoalStatus]).map(str),
        "goal": messages, "feedback": messages, "result": messages, "error": st.none(), "stage": st.none(),
        "retries": st.none(), "stalled": st.booleans(), "feedback_count": st.integers(0, 2**31 - 1),
    }
)  # fmt: skip


def hostile_news(site: str, documents: list[dict[str, Any]], *, tell: bool) -> SiteReports:
    news = SiteReports(site, cursor="99999999999999999999-z-x")
    for document in documents:
        sized = {
            name: {"x": "y" * size} if isinstance(size := document[name], int) else size
            for name in ("goal", "feedback", "result")
        }
        with suppress(ForeignDocumentError):
            goal = read_goal(site, document | sized)
            news.goals[goal.goal_id] = goal
            if tell:
                news.happenings += [Happening("status", goal, goal.updated_at), *ends_of(goal)]
    return news


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(st.tuples(st.lists(goals, min_size=1, max_size=6), st.booleans()), min_size=1, max_size=8),
    st.sampled_from(["evil", "berlin2", "berli", "aaa"]),
)
def test_the_history_of_the_honest_site_stays(told: list[tuple[list[dict[str, Any]], bool]], site: str) -> None:
    async def attack(folder: Path) -> None:
        async with hub_of(folder) as (history, store):
            before = await of_honest(history)
            assert (len(before[0]), len(before[1])) == (10, 20)
            for documents, tell in told:
                with suppress(ForeignDocumentError):
                    await store.keep(hostile_news(site, documents, tell=tell))
            with patch.multiple(retention, PAUSE=0, REST=0):
                for _ in range(10):
                    await history.retention.enforce()
            assert await of_honest(history) == before
            sizes = await history.database.read(sizes_of_sites)
            assert sizes.total() <= MOST
            newest = await history.page(GoalFilter(), limit=500)
            assert all(goal.created_at <= datetime.now(UTC) for goal in newest)

    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(attack(Path(folder)))


async def test_goals_of_the_future_do_not_take_the_place_of_others(database_url: str, tmp_path: Path) -> None:
    """80 goals of 2126 with 240 kB each, where 5 MB are kept."""
    large = 120_000  # bytes
    document = {"goal_id": "", "action_name": "/dock", "action_type": "t", "origin": "gateway", "verb": "dock"}
    document |= dict.fromkeys(("created_at", "updated_at", "finished_at"), "2126-01-01T00:00:00Z")
    document |= {"status": "succeeded", "goal": large, "result": large, "feedback": None, "error": None}
    document |= {"stage": None, "retries": None, "stalled": False, "feedback_count": 0}
    async with hub_of(tmp_path, database_url, 5_000_000) as (history, store):
        before = await of_honest(history)
        for number in range(1000, 1080):
            news = hostile_news("evil", [document | {"goal_id": str(UUID(int=number))}], tell=True)
            await store.keep(news)
        await history.retention.enforce()
        assert await of_honest(history) == before
        left = await history.page(GoalFilter(namespace="/evil"), limit=500)
        assert 10 < len(left) < 30  # what the honest site leaves, the other one has


@given(st.dictionaries(st.text(max_size=3), st.integers(0, 10**12), min_size=1), st.integers(0, 10**12))
def test_a_share_is_taken_from_those_that_have_the_most(sizes: dict[str, int], most: int) -> None:
    level = fair_share(sizes.values(), most)
    left = [min(size, level) for size in sizes.values()]
    assert sum(left) <= max(most, 0)
    if sum(sizes.values()) <= most:
        assert left == [*sizes.values()]
    else:
        assert sum(left) > most - len(sizes)
    assert all(size <= level for size in sizes.values() if size <= most // len(sizes))


async def test_goals_that_never_end_go_too_when_a_site_has_nothing_else(database_url: str, tmp_path: Path) -> None:
    async with hub_of(tmp_path, database_url) as (history, store):
        before = await of_honest(history)
        for start in range(0, 400, 200):
            goals = [
                Goal(str(UUID(int=2000 + start + number)), "/evil/dock", "t", NOW, status=GoalStatus.EXECUTING)
                for number in range(200)
            ]
            await store.keep(SiteReports("evil", {goal.goal_id: goal for goal in goals}, cursor="9-z-9"))
        for _ in range(3):
            await history.retention.enforce()
        assert await of_honest(history) == before
        assert (await history.database.read(sizes_of_sites)).total() <= MOST


class HostileSite(FakeSite):
    address = TunnelAddress("evil", "0" * 16)


async def test_a_site_that_tells_without_end_does_not_hold_up_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Large goals, one after the other, as fast as they are read; each site is read in its own share of the time."""
    monkeypatch.setattr(follower, "RETRY_FIRST", 0.01)
    text = "y" * 100_000
    event = orjson.dumps(told(Goal(HONEST[0], "/dock", "t", NOW), 1) | {"goal": {"x": text}}).decode()
    endless = (event.replace(HONEST[0], str(UUID(int=number))) for number in itertools.count(10_000))
    async with hub_of(tmp_path, most=10**9) as (history, store):
        site: Any = HostileSite(itertools.chain([snapshot()], endless))
        evil = Follower(site, view := SiteView("evil"), store, history, Mirror(history))
        await until(lambda: view.cursor is not None)
        kept = 0.0
        for number in range(20):
            goal = honest_goal(str(UUID(int=5000 + number)))
            began = asyncio.get_running_loop().time()
            await store.keep(SiteReports("berlin", {goal.goal_id: goal}, ends_of(goal), f"0-z-{number}"))
            kept = max(kept, asyncio.get_running_loop().time() - began)
        assert kept < 5
        assert evil.kept_bytes <= 2 * (follower.MAX_GOAL_BYTES + len(text))
        await evil.close()


async def test_the_pace_at_which_a_site_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    paused: list[float] = []

    async def sleep(seconds: float) -> None:
        paused.append(seconds)

    monkeypatch.setattr(asyncio, "sleep", sleep)
    monkeypatch.setattr(pace.time, "monotonic", lambda: 7.25)
    reading = pace.Pace()
    for _ in range(10_000):
        await reading.give_way(0.001)
    assert sum(paused) >= pace.BREAK * 9.9  # 10 s of work
    paused.clear()
    for _ in range(10):
        await reading.give_way(0.0)
    assert paused == [0.75] * 10  # too many in this second


def test_robots_alerts_and_approvals_have_a_size() -> None:
    view = SiteView("evil")
    robot = {"name": "/evil/robot1", "stop": {"latched": False}, "display_name": "x" * 30_000}
    robots = [robot | {"name": f"/evil/robot{number}"} for number in range(MAX_BYTES // 30_000 - 5)]
    view.put_robots(robots)
    view.put_robots(robots)
    with pytest.raises(ForeignDocumentError, match="at most"):
        view.put_robots([robot | {"name": f"/evil/more{number}"} for number in range(10)])
    for put in (view.put_alerts, view.put_approvals):
        with pytest.raises(ForeignDocumentError, match="at most"):
            put([robot] * 300)


@given(st.sets(st.integers(0, 99), max_size=60), st.integers(0, 200_000))
def test_what_has_changed_is_published_bit_by_bit(numbers: set[int], most: int) -> None:
    view = SiteView("evil")
    view.put_robots([ROBOT | {"name": f"/evil/robot{number}", "display_name": "x" * 3_000} for number in numbers])
    names, taken = set(view.changed), list[str]()
    assert len(names) == len(numbers)
    while view.changed:
        piece = view.take_changed(most)
        assert piece
        assert len(piece) <= most / 3_000 + 1
        taken += piece
    assert sorted(taken) == sorted(names)
    view.put_robots([], names)
    assert set(view.take_changed(10**9)) == names


def test_the_sum_of_a_database(tmp_path: Path) -> None:
    """The queries of sizes read indexes only, however large the messages are."""

    async def plan() -> list[str]:
        async with hub_of(tmp_path) as (history, _):

            def explain(connection: sa.Connection) -> list[str]:
                texts = (
                    "SELECT action_name, sum(size), count(*) FROM events WHERE NOT droppable GROUP BY action_name",
                    "SELECT action_name, count(*) FROM goals GROUP BY action_name",
                )
                return [
                    str(row[3]) for text in texts for row in connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {text}")
                ]

            return await history.database.read(explain)

    assert all("COVERING INDEX" in step for step in asyncio.run(plan()))
