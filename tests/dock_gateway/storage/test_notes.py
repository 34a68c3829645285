"""Notes and tags as the histories store them: limits, two gateways, an outage, and the end of their goal."""

import asyncio
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.storage import GoalNotes, History, Note, immediate
from dock_gateway.storage.notes import MAX_NOTES
from dock_gateway.storage.tables import goal_notes, goal_tags
from tests.support.history import NOW, locked, make_goal, open_at, open_place, page_of, settled, written
from tests.support.waiting import until


def note(number: int, text: str = "wheel was blocked by a box ü\n\tand a 'chair'") -> Note:
    return Note(f"{number:032x}", "Ada", NOW + timedelta(seconds=number), text)


async def notes_on(history: History) -> tuple[Note, ...]:
    """The notes of the first goal."""
    return (await history.notes.read(["goal-0001"]))["goal-0001"].notes


pytestmark = pytest.mark.usefixtures("patient")


async def test_notes_and_tags_are_stored_and_deleted(place: str, tmp_path: Path) -> None:
    async with open_place(place, tmp_path) as history:
        await ready(history)
        store = history.notes
        assert await store.read(["goal-0001"]) == {}
        await store.add("goal-0001", note(2))
        await store.add("goal-0001", note(3))
        assert await store.read(["goal-0001", "goal-0002"]) == {"goal-0001": GoalNotes((), (note(2), note(3)))}
        await store.add("goal-0002", note(4))
        await store.replace_tags("goal-0001", ["maintenance", "blocked"])
        await store.replace_tags("goal-0002", ["blocked", "Ärger"])
        assert await store.tags_of(["goal-0001", "goal-0002", "goal-0003"]) == {
            "goal-0001": ("blocked", "maintenance"),
            "goal-0002": ("blocked", "Ärger"),
        }
        assert await store.all_tags() == ["blocked", "maintenance", "Ärger"]
        await store.remove("goal-0001", note(2).id)
        for goal_id in ("goal-0001", "goal-0002"):
            await store.remove(goal_id, note(2).id)  # it is gone, or another goal's
        await store.replace_tags("goal-0002", [])
        assert await store.read(["goal-0001", "goal-0002", "goal-0003"]) == {
            "goal-0001": GoalNotes(("blocked", "maintenance"), (note(3),)),
            "goal-0002": GoalNotes((), (note(4),)),
        }


async def test_a_goal_has_room_for_a_hundred_notes(place: str, tmp_path: Path) -> None:
    async with open_place(place, tmp_path) as history:
        await ready(history)
        for number in range(MAX_NOTES):
            await history.notes.add("goal-0001", note(number))
        with pytest.raises(Conflict) as refused:
            await history.notes.add("goal-0001", note(MAX_NOTES))
        assert refused.value.code == "limit_reached"
        await history.notes.add("goal-0002", note(MAX_NOTES))
        assert len(await notes_on(history)) == MAX_NOTES


async def test_two_gateways_have_the_same(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path / "a") as one, open_at(database_url, tmp_path / "b") as other:
        await ready(one)
        await ready(other)
        one.record(make_goal(1))
        await written(one)
        for number in range(MAX_NOTES - 5):
            await one.notes.add("goal-0001", note(1000 + number))
        adds = (each.notes.add("goal-0001", note(number)) for number, each in enumerate((one, other) * 4))
        ends = await asyncio.gather(*adds, return_exceptions=True)
        assert sum(isinstance(end, Conflict) for end in ends) == 3
        assert len(await notes_on(one)) == MAX_NOTES
        await other.notes.replace_tags("goal-0001", ["blocked"])
        assert await one.notes.read(["goal-0001"]) == await other.notes.read(["goal-0001"])


@pytest.mark.parametrize("waiting", [False, True])
async def test_goals_by_tag(place: str, tmp_path: Path, *, waiting: bool) -> None:
    async with open_place(place, tmp_path) as history:
        await ready(history)
        for number in range(1, 5):
            history.record(make_goal(number))
        await settled(history)
        await history.notes.replace_tags("goal-0001", ["blocked", "maintenance"])
        await history.notes.replace_tags("goal-0003", ["maintenance"])
        if waiting:
            for number in range(1, 5):
                history.record(make_goal(number))
        for tags, expected in (
            (["blocked"], [1]),
            (["maintenance"], [3, 1]),
            (["blocked", "maintenance"], [3, 1]),
            (["Blocked"], []),
            ([], [4, 3, 2, 1]),
        ):
            found = await page_of(history, tags=frozenset(tags))
            assert [int(goal.goal_id[-4:]) for goal in found] == expected


async def test_they_go_with_their_goal(database_url: str, tmp_path: Path) -> None:
    old = make_goal(1)
    new = make_goal(2, created_at=datetime.now(UTC))
    async with open_at(database_url, tmp_path, goal_age=86_400.0) as history:
        await ready(history)
        for goal in (old, new):
            goal.created_at = goal.created_at if goal is new else datetime.now(UTC) - timedelta(days=2)
            history.record(goal)
        await written(history)
        for goal in (old, new):
            await history.notes.add(goal.goal_id, note(int(goal.goal_id[-1])))
            await history.notes.replace_tags(goal.goal_id, ["blocked"])
        await history.retention.enforce()
        assert await history.get(old.goal_id) is None
        for table in (goal_notes, goal_tags):
            query = sa.select(table.c.goal_id)
            stored = await history.database.read(lambda db, query: list(db.scalars(query)), query)
            assert stored == [new.goal_id]


async def test_a_database_that_is_locked_takes_none(
    sqlite_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(immediate, "WRITE_TIMEOUT", 0.5)
    async with open_at(sqlite_url, tmp_path) as history:
        await ready(history)
        with locked(sqlite_url.removeprefix("sqlite:///")):
            for change in (history.notes.add("goal-0001", note(1)), history.notes.replace_tags("goal-0001", ["x"])):
                with pytest.raises(Unavailable) as refused:
                    await change
                assert refused.value.code == "history_unavailable"


async def ready(history: History) -> None:
    await until(lambda: history.stats().database_reachable)
