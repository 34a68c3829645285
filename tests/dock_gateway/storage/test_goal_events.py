"""Events after another one, the events of one goal, and whether they are all there."""

from pathlib import Path

import pytest

from dock_gateway.core.event import KINDS, Event, event_id, moment
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.storage import History
from dock_gateway.storage.event_reader import is_complete
from tests.support.history import EVERYTHING, START_NS, make_event, make_goal, open_at, open_place, settled, written

FEEDBACK = "f"


def started(number: int, feedback: int) -> Goal:
    """The goal `g1`, created at the time of an event."""
    return make_goal(
        1,
        GoalStatus.EXECUTING,
        goal_id="g1",
        created_at=moment(START_NS + number),
        feedback_count=feedback,
        last_event_id="1",
    )


async def numbers(history: History, goal_id: str = "g1", **query: object) -> list[int]:
    asked = {"kinds": KINDS.values(), "limit": 100} | query
    found = await history.events_of(goal_id, **asked)  # type: ignore[arg-type]
    assert [event.data for event in found] == [event.data for event in sorted(found, key=lambda event: event.id or "")]
    return [int((event.id or "")[:20]) - START_NS for event in found]


async def test_events_of_a_goal(place: str, tmp_path: Path) -> None:
    """Some of them are stored, some wait, and one does both."""
    async with open_place(place, tmp_path) as history:
        for number in (3, 1, 2):
            history.record_event(make_event(number, droppable=number != 1))
        history.record_event(make_event(4, goal_id="g2"))
        history.record_event(make_event(5, "battery"))
        await settled(history)
        for number in (3, 6, 7):
            history.record_event(make_event(number, droppable=True))
        end = event_id(START_NS + 8, "z", "g1")
        history.record_event(Event(b"{}", "goals", "g1", "/dock", id=end))
        assert await numbers(history) == [1, 2, 3, 6, 7, 8]
        assert await numbers(history, kinds={FEEDBACK}) == [2, 3, 6, 7]
        assert await numbers(history, kinds={"s", "z"}) == [1, 8]
        after = make_event(2, droppable=True).id or ""
        assert await numbers(history, after=after) == [3, 6, 7, 8]
        assert await numbers(history, after=after, limit=2) == [3, 6]
        assert await numbers(history, after=after, until=make_event(6, droppable=True).id) == [3, 6]
        assert await numbers(history, "g2") == [4]
        assert await numbers(history, "g3") == []


async def test_events_after_an_event(place: str, tmp_path: Path) -> None:
    """Some of them are stored, some wait."""
    goals = frozenset({"goals"})
    async with open_place(place, tmp_path) as history:

        async def after(number: int, **query: object) -> list[bytes] | None:
            asked = {"goal_id": None, "action_name": None, "topics": EVERYTHING, "limit": 100} | query
            found = await history.events_after(make_event(number).id or "", **asked)  # type: ignore[arg-type]
            return [event.data for event in found.events] if found.complete else None

        for number in (3, 1, 2, 3):
            history.record_event(make_event(number))
        await settled(history)
        history.record_event(make_event(4, goal_id="g2"))
        history.record_event(make_event(5, "battery"))
        history.record_event(Event(b"{}", "goals"))  # without an id
        assert await after(1) == [make_event(number).data for number in (2, 3, 4, 5)]
        assert await after(1, topics=frozenset({"battery"})) == [make_event(5).data]
        assert await after(1, goal_id="g2", topics=goals) == [make_event(4).data]
        assert await after(1, goal_id="g2", action_name="/other", topics=goals) == []
        assert await after(1, limit=1) == [make_event(2).data]
        assert await after(4) == [make_event(5).data]
        assert await after(5) == []
        assert await after(9) == [], "the event before was told, and is not stored yet"
        assert await after(0) is None, "the past does not reach back so far"


async def test_the_feedback_of_a_goal_is_counted_on_after_a_kill(place: str, tmp_path: Path) -> None:
    """Its events were stored, but not their number."""
    async with open_place(place, tmp_path) as history:
        await history.add(started(0, 0))
        for number in range(63):
            history.record_event(make_event(number, droppable=number > 0))
        await settled(history)
        assert [goal.feedback_count for goal in await history.unfinished()] == [62]
        assert (await history.known(["g1"]))["g1"].feedback_count == 62
        ended = make_goal(2, GoalStatus.SUCCEEDED, goal_id="g2", feedback_count=7)
        await history.add(ended)
        assert (await history.known(["g2"]))["g2"].feedback_count == 7


async def test_nothing_is_missing_of_a_goal_whose_events_are_there(place: str, tmp_path: Path) -> None:
    async with open_place(place, tmp_path) as history:
        assert await history.knows_all_of(make_goal(1)), "it has had no event yet"
        for number in range(4):
            history.record_event(make_event(number, droppable=number > 0))
        assert await history.knows_all_of(started(0, 3))
        await settled(history)
        assert await history.knows_all_of(started(0, 3))
        assert await history.knows_all_of(started(0, 99)), "what was never heard here was not given up"


async def test_what_retention_has_taken_is_missing(database_url: str, tmp_path: Path) -> None:
    size = len(make_event(1, droppable=True).data)
    async with open_at(database_url, tmp_path, event_bytes=5 * size) as history:
        for number in range(11):
            history.record_event(make_event(number, droppable=number > 0))
        history.record_event(make_event(3, goal_id="g2"))
        await written(history)
        assert await history.retention.enforce() == 5
        assert await numbers(history, kinds={FEEDBACK}) == [6, 7, 8, 9, 10]
        assert not await history.knows_all_of(started(0, 10))
        assert await history.knows_all_of(started(0, 0)), "it had no feedback"
        assert not await history.knows_all_of(started(9, 10)), "the robot's clock is behind"
        quiet = make_goal(2, goal_id="g2", created_at=moment(START_NS + 3), last_event_id="1")
        assert await history.knows_all_of(quiet)
        history.record_event(make_event(20, droppable=True))
        assert not await history.knows_all_of(started(0, 11))


async def test_what_was_dropped_for_want_of_memory_is_missing(sqlite_url: str, tmp_path: Path) -> None:
    async with open_at(sqlite_url, tmp_path, max_waiting=3) as history:
        history.record_event(make_event(0))
        for number in range(1, 6):
            history.record_event(make_event(number, droppable=True))
        assert await numbers(history) == [0, 3, 4, 5]
        assert not await history.knows_all_of(started(0, 5))
        await written(history)
        assert not await history.knows_all_of(started(0, 5))
        assert await history.knows_all_of(started(0, 3)), "those of others were dropped"


@pytest.mark.parametrize(("last_event_id", "whole"), [(None, True), ("1", False)])
def test_a_goal_without_any_event(last_event_id: str | None, whole: bool) -> None:
    goal = make_goal(1, last_event_id=last_event_id)
    assert is_complete(goal, first=None, missing="", feedback=0) is whole
