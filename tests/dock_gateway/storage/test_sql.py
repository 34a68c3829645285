"""The history in real databases: what is written is read, at once and after a restart, in pages and by event."""

import asyncio
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa

from dock_gateway.core.event import STATUS, Event, event_id, feedback_event, result_event, status_event
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.storage import History, queries, sqlite
from dock_gateway.storage.queries import cursor_of
from dock_gateway.storage.rows import Batch
from dock_gateway.storage.tables import events, goals, idempotency_keys
from tests.support.history import EVERYTHING, NOW, START_NS, make_event, make_goal, open_at, page_of, written


async def count(history: History, table: sa.Table) -> int:
    counted = sa.select(sa.func.count()).select_from(table)
    return await history.database.read(lambda connection: connection.scalar(counted)) or 0


async def ids(history: History, **query: object) -> list[str]:
    return [goal.goal_id for goal in await page_of(history, **query)]


async def after(history: History, number: int, **query: object) -> list[bytes] | None:
    asked = {"goal_id": None, "action_name": None, "topics": EVERYTHING, "limit": 100} | query
    found = await history.events_after(make_event(number).id or "", **asked)  # type: ignore[arg-type]
    return [event.data for event in found.events] if found.complete else None


async def test_a_reader_resumes_where_nothing_was_stored_before_a_crash(database_url: str, tmp_path: Path) -> None:
    asked = {"goal_id": None, "action_name": None, "topics": EVERYTHING, "limit": 100}
    before = event_id(time.time_ns(), STATUS, "1")
    async with open_at(database_url, tmp_path) as history:
        await written(history)
    since = event_id(time.time_ns(), STATUS, "1")
    async with open_at(database_url, tmp_path) as history:
        assert (await history.events_after(since, **asked)).complete  # type: ignore[arg-type]
        assert not (await history.events_after(before, **asked)).complete  # type: ignore[arg-type]


async def test_a_goal_is_the_same_after_a_restart(database_url: str, tmp_path: Path) -> None:
    goal = make_goal(
        1,
        GoalStatus.ABORTED,
        feedback='{"name":"\u00e4"}'.encode(),
        result=b'{"a": 1,  "as_it_was": 2.50}',
        error=GoalError("goal_aborted", "why\0 \u20ac \ud800"),
        stage="CONTROLLING",
        retries=2,
        origin="external",
        verb="undock",
        finished_at=NOW + timedelta(microseconds=1),
        feedback_count=3,
        last_event_id="7",
        updated_at=NOW + timedelta(days=1),
    )
    async with open_at(database_url, tmp_path) as history:
        await history.add(goal, "key")
    async with open_at(database_url, tmp_path) as history:
        found = await history.get(goal.goal_id)
        assert found is not None
        goal.error = GoalError("goal_aborted", "why \u20ac ?")
        assert {name: getattr(found, name) for name in Goal.__slots__} == {
            name: getattr(goal, name) for name in Goal.__slots__
        }
        assert (await history.by_key("key") or goal).goal_id == goal.goal_id
        assert await history.get("another") is None
        assert await history.by_key("another") is None


async def test_what_waits_is_read_as_if_it_were_written(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as history:
        goal = make_goal(1, GoalStatus.PENDING)
        await history.add(goal)
        await written(history)
        goal.status = GoalStatus.EXECUTING
        history.record(goal)
        history.record(make_goal(2, GoalStatus.EXECUTING))
        goal.status = GoalStatus.SUCCEEDED  # not recorded
        assert history.stats().waiting == 2
        assert await ids(history, statuses={GoalStatus.EXECUTING}) == ["goal-0002", "goal-0001"]
        assert await ids(history, statuses={GoalStatus.PENDING}) == []
        assert await ids(history, before=cursor_of(make_goal(2))) == ["goal-0001"]
        assert [each.goal_id for each in await history.unfinished()] == ["goal-0001", "goal-0002"]
        found = await history.get("goal-0001")
        assert found is not None
        assert found.status is GoalStatus.EXECUTING
        await written(history)
        assert await ids(history, statuses={GoalStatus.EXECUTING}) == ["goal-0002", "goal-0001"]


async def test_pages_are_stable(database_url: str, tmp_path: Path) -> None:
    """Also of goals made at the same time, and while new ones come; half of them still wait."""
    async with open_at(database_url, tmp_path) as history:
        made = [make_goal(number, created_at=NOW + timedelta(seconds=number // 4)) for number in range(20)]
        for goal in made[::2]:
            history.record(goal)
        await written(history)
        for goal in made[1::2]:
            history.record(goal)
        history.record(make_goal(3000, action="/other"))
        seen: list[Goal] = []
        for number in range(100):
            before = cursor_of(seen[-1]) if seen else None
            page = await page_of(history, action_names={"/dock"}, limit=3, before=before)
            if not page:
                break
            seen += page
            history.record(make_goal(1000 + number))
        assert [goal.goal_id for goal in seen] == [goal.goal_id for goal in reversed(made)]


async def test_a_page_goes_on_behind_a_goal_that_was_deleted(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as history:
        history.record(make_goal(1))
        history.record(make_goal(3))
        assert await ids(history, before=cursor_of(make_goal(2))) == ["goal-0001"]
        await written(history)
        assert await ids(history, before=cursor_of(make_goal(2))) == ["goal-0001"]


async def test_the_first_claim_holds_for_a_day(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as one, open_at(database_url, tmp_path) as other:
        assert await one.claim("key", "g1", "f1") == ("g1", "f1")
        assert await other.claim("key", "g2", "f2") == ("g1", "f1")
        assert await one.claim("key", "g3", "f3") == ("g1", "f1")
    async with open_at(database_url, tmp_path) as history:
        assert await history.claim("key", "g2", "f2") == ("g1", "f1")
        past = datetime.now(UTC) - timedelta(seconds=1)
        expire = sa.update(idempotency_keys).values(expires_at=past)
        await history.database.write(lambda connection: connection.execute(expire) and None)
    async with open_at(database_url, tmp_path) as history:
        assert await history.by_key("key") is None
        assert await history.claim("key", "g2", "f2") == ("g2", "f2")


async def test_a_key_is_let_go_of_by_its_goal(database_url: str, tmp_path: Path) -> None:
    first, second = make_goal(1), make_goal(2)
    async with open_at(database_url, tmp_path / "1") as one, open_at(database_url, tmp_path / "2") as other:
        await one.add(first, "key")
        assert (await other.claim("key", second.goal_id, "f"))[0] == first.goal_id
        await one.release("key", second.goal_id)
        assert (await one.claim("key", second.goal_id, "f"))[0] == first.goal_id
        await one.release("key", first.goal_id)
        assert await one.by_key("key") is None
        assert (await one.claim("key", second.goal_id, "f"))[0] == second.goal_id
        assert (await other.claim("key", "g3", "f"))[0] == first.goal_id, "it has not heard of that"
        await other.release("key", first.goal_id)
        assert (await other.claim("key", "g3", "f"))[0] == second.goal_id


async def test_one_of_many_claims_wins(database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for patience in ("history.OPEN_TIMEOUT", "keys.KEY_TIMEOUT"):  # a database that is away decides nothing
        monkeypatch.setattr(f"dock_gateway.storage.{patience}", 30.0)
    monkeypatch.setattr(sqlite, "BUSY_TIMEOUT", 30.0)
    async with open_at(database_url, tmp_path) as one, open_at(database_url, tmp_path) as other:
        for round_ in range(10):
            claims = [
                history.claim(f"key-{round_}", f"g{number}", "f")
                for number, history in enumerate([one, other, one, other])
            ]
            assert len(set(await asyncio.gather(*claims))) == 1


async def test_two_replicas_store_everything_once(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as one, open_at(database_url, tmp_path) as other:
        for number in range(200):
            for history in (one, other):
                history.record_event(make_event(number, droppable=number % 2 == 0))
                goal = make_goal(number % 20, GoalStatus.EXECUTING)
                goal.feedback_count = number
                history.record(goal)
        await written(one)
        await written(other)
        assert await count(one, events) == 200
        assert await count(one, goals) == 20
        assert one.stats().last_error is None
        assert other.stats().last_error is None
        found = await after(other, 1)
        assert found == [make_event(number, droppable=number % 2 == 0).data for number in range(2, 200)][:100]


async def test_a_new_goal_adds_to_what_a_replica_has_stored_of_it(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path / "1") as one, open_at(database_url, tmp_path / "2") as other:
        await one.writer.flush()
        await other.writer.flush()
        seen = make_goal(1, GoalStatus.EXECUTING, origin="external", goal=None)
        one.record(seen)
        await written(one)
        await other.add(make_goal(1, GoalStatus.PENDING))
        await other.add(make_goal(2, GoalStatus.PENDING))
        assert [(goal.goal_id, goal.status.value, goal.origin, goal.goal) for goal in await page_of(one)] == [
            ("goal-0002", "pending", "gateway", b'{"order":5}'),
            ("goal-0001", "executing", "gateway", b'{"order":5}'),
        ]


async def test_replicas_agree_on_a_goal_that_both_write(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as one, open_at(database_url, tmp_path) as other:
        sent = make_goal(1, GoalStatus.PENDING)
        seen = make_goal(1, GoalStatus.SUCCEEDED, origin="external", goal=None, result=b'{"done":true}')
        other.record(seen)
        await asyncio.gather(one.add(sent), written(other))
        await written(one)
        for history in (one, other):
            goal = await history.get(sent.goal_id)
            assert goal is not None
            assert (goal.origin, goal.status, goal.goal, goal.result) == (
                "gateway",
                GoalStatus.SUCCEEDED,
                sent.goal,
                seen.result,
            )


async def test_what_a_database_cannot_take_harms_nothing_else(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as history:
        history.record(make_goal(1))
        history.record(make_goal(2, action="/bad\0name", result=b"\xff"))
        history.record(make_goal(3))
        history.record_event(make_event(1))
        await written(history)
        assert await ids(history) == ["goal-0003", "goal-0001"]
        assert await after(history, 1) == []
        assert history.stats().database_reachable


async def test_new_goals_go_ahead_of_the_rest_which_is_not_forgotten(
    database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    batches: list[Batch] = []
    write = queries.write

    def write_noted(connection: sa.Connection, batch: Batch) -> None:
        batches.append(batch)
        write(connection, batch)

    monkeypatch.setattr(queries, "write", write_noted)
    async with open_at(database_url, tmp_path) as history:
        await history.add(make_goal(0))
        await written(history)
        batches.clear()
        history.record_event(make_event(1))
        await history.add(make_goal(1))
        assert [(len(batch.goals), len(batch.events)) for batch in batches] == [(1, 0)]
        number = 1
        while not any(batch.events for batch in batches):
            number += 1
            assert number < 1000, "new goals hold up the rest for ever"
            await history.add(make_goal(number))
        await written(history)
        assert await count(history, events) == 1
        assert await count(history, goals) == number + 1


def ended(status: GoalStatus = GoalStatus.SUCCEEDED, stamp: int = 1) -> tuple[Goal, list[Event]]:
    goal = make_goal(1, status)
    return goal, [status_event(goal, stamp), result_event(goal, stamp)]


async def test_the_end_of_a_goal_is_stored_once_and_told_the_same_by_all(database_url: str, tmp_path: Path) -> None:
    """Two gateways saw it; the first one counts, whatever the other makes of it."""
    async with open_at(database_url, tmp_path / "a") as one, open_at(database_url, tmp_path / "b") as other:
        goal, end = ended(stamp=5)
        stored = await one.seal(goal, end)
        assert [event.key for event in stored or []] == [event.key for event in end]
        late, late_end = ended(GoalStatus.ABORTED, stamp=9)
        assert await other.seal(late, late_end) == stored
        for event in (*end, *late_end):
            one.record_event(event)
            other.record_event(event)
        await written(one)
        await written(other)
        kept = await other.get(goal.goal_id)
        assert kept is not None
        assert kept.status is GoalStatus.SUCCEEDED
        assert await count(one, events) == 2


async def test_the_end_of_a_goal_survives_a_kill_in_the_moment_when_it_is_told(
    database_url: str, tmp_path: Path
) -> None:
    async with open_at(database_url, tmp_path) as history:
        goal, end = ended(stamp=START_NS)
        stored = await history.seal(goal, end)
        found = await history.database.read(lambda db: db.scalars(sa.select(events.c.id)).all())
        assert sorted(found) == sorted(event.id or "" for event in stored or [])


async def test_feedback_that_two_gateways_stamped_differently_is_stored_once(database_url: str, tmp_path: Path) -> None:
    """One of them had published something newer already."""
    async with open_at(database_url, tmp_path / "a") as one, open_at(database_url, tmp_path / "b") as other:
        goal = make_goal(1, GoalStatus.EXECUTING)
        one.record_event(feedback_event(goal, START_NS, START_NS))
        await written(one)
        other.record_event(feedback_event(goal, START_NS + 7, START_NS))
        await written(other)
        assert await count(one, events) == 1


async def test_what_is_known_of_many_goals(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as history:
        await history.add(make_goal(1))
        await written(history)
        history.record(make_goal(2))
        assert (await history.known(["goal-0001", "goal-0002", "goal-0003"])).keys() == {"goal-0001", "goal-0002"}


async def test_the_newest_event_is_known_from_the_start(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as history:
        assert history.newest == ""
        history.record_event(make_event(2))
        history.record_event(make_event(1))
        await written(history)
    async with open_at(database_url, tmp_path) as history:
        assert history.newest == make_event(2).id
