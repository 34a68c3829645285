"""What sites tell is stored once and told once, in SQLite and PostgreSQL."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from pathlib import Path

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import Event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.storage import History
from dock_hub.fields import ForeignDocumentError
from dock_hub.goal_documents import Happening, ends_of
from dock_hub.mirror import Mirror, MirrorBatch
from dock_hub.store import HubStore, SiteReports
from tests.support.history import open_at
from tests.support.waiting import until

AT = datetime(2026, 11, 27, 12, 0, 0, 123456, tzinfo=UTC)
FIRST, SECOND, THIRD = (f"6a8c2b0a-5c63-4d0e-9c1e-00000000000{number}" for number in (1, 2, 3))


def make_goal(goal_id: str = FIRST, status: GoalStatus = GoalStatus.EXECUTING, action: str = "/berlin/dock") -> Goal:
    goal = Goal(goal_id, action, "pkg/action/Dock", AT, verb="dock", status=status)
    goal.finished_at = AT if status.terminal else None
    return goal


def running(goal: Goal) -> SiteReports:
    return SiteReports("berlin", {goal.goal_id: goal}, [Happening("status", goal, AT)], "0-s-1")


def ended(goal_id: str = FIRST, cursor: str = "0-z-1") -> SiteReports:
    goal = make_goal(goal_id, GoalStatus.SUCCEEDED)
    return SiteReports("berlin", {goal_id: goal}, ends_of(goal), cursor)


@asynccontextmanager
async def opened(url: str, folder: Path) -> AsyncIterator[tuple[History, HubStore, list[Event]]]:
    async with open_at(url, folder) as history:
        await until(lambda: history.stats().database_reachable)
        told: list[Event] = []
        store = HubStore(Mirror(history), Fanout(queue_limit=10, keep=told.append))
        try:
            yield history, store, told
        finally:
            await store.close()


async def test_each_event_is_stored_once_and_told_once(database_url: str, tmp_path: Path) -> None:
    async with opened(database_url, tmp_path) as (history, store, told):
        await store.keep(running(make_goal()))
        await store.keep(ended())
        await store.keep(running(make_goal()))  # told again, after a restart of the hub or by another gateway
        await store.keep(ended(cursor="0-z-2"))
        assert [event.key for event in told][1:] == [f"berlin:s-{FIRST}", f"berlin:z-{FIRST}"]
        assert [event.id for event in told] == sorted(event.id or "" for event in told)
        stored = await history.events_of(FIRST, kinds="sz", limit=10)
        assert [event.id for event in stored] == [event.id for event in told]
        goal = await history.get(FIRST)
        assert goal is not None
        assert (goal.status, goal.last_event_id) == (GoalStatus.SUCCEEDED, told[-1].id)
        assert await Mirror(history).cursor("berlin") == "0-z-2"
        await Mirror(history).forget("berlin")
        assert await Mirror(history).cursor("berlin") is None


async def test_a_goal_of_another_site_is_refused_and_the_others_are_kept(database_url: str, tmp_path: Path) -> None:
    async with opened(database_url, tmp_path) as (history, store, told):
        await store.keep(running(make_goal()))
        forged = make_goal(status=GoalStatus.ABORTED, action="/oslo/dock")
        own = make_goal(THIRD, GoalStatus.SUCCEEDED, action="/oslo/dock")
        with pytest.raises(ForeignDocumentError):
            await store.keep(SiteReports("oslo", {FIRST: forged, THIRD: own}, ends_of(forged) + ends_of(own), "0-z-9"))
        await store.keep(ended(SECOND))
        assert {event.goal_id for event in told} == {FIRST, SECOND, THIRD}
        assert (await history.known([FIRST]))[FIRST].action_name == "/berlin/dock"
        assert await Mirror(history).cursor("oslo") == "0-z-9"


async def test_what_was_written_although_no_answer_came_is_told_all_the_same(tmp_path: Path) -> None:
    class Forgetful:
        def __init__(self, history: History) -> None:
            self.known_keys = Mirror(history).known_keys
            self._take = Mirror(history).take
            self.failures = 1

        async def take(self, batch: MirrorBatch) -> set[str]:
            new = await self._take(batch)
            if self.failures:
                self.failures -= 1
                raise Unavailable("no answer", code="history_unavailable")
            return new

    async with open_at(f"sqlite:///{tmp_path / 'hub.db'}", tmp_path) as history:
        await until(lambda: history.stats().database_reachable)
        fanout = Fanout(queue_limit=10)
        subscriber = fanout.subscribe(EventFilter())
        store = HubStore(Forgetful(history), fanout)  # type: ignore[arg-type]
        await store.keep(ended())
        await store.close()
        events, _ = await subscriber.take(0)
        assert [event.key for event in events] == [f"berlin:s-{FIRST}", f"berlin:z-{FIRST}"]
