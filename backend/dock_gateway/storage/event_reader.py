"""Reads past events: the stored ones together with those that are not written yet."""

import asyncio
from collections.abc import Callable, Collection, Iterator
from copy import copy
from dataclasses import dataclass
from functools import partial

import sqlalchemy as sa

from dock_gateway.core.event import FEEDBACK, NEVER, Event, kind_of, nanoseconds, time_id
from dock_gateway.core.goal import Goal
from dock_gateway.storage import battery, queries
from dock_gateway.storage.battery import BatterySpan, Bucket, add_events
from dock_gateway.storage.reader import Reader
from dock_gateway.storage.waiting import WaitingEntries


@dataclass(frozen=True)
class LaterEvents:
    """The events after a given one, ordered by id; `complete` if none of them was dropped."""

    events: list[Event]
    complete: bool


class EventReader:
    """Reads events: pending ones first, because they may be written during the read and must not be missed."""

    def __init__(self, reader: Reader, waiting: WaitingEntries) -> None:
        self._reader = reader
        self._waiting = waiting

    def _that_wait(self, chosen: Callable[[Event], bool]) -> dict[str, Event]:
        return {event.id or "": event for event in self._all_that_wait() if chosen(event)}

    def _all_that_wait(self) -> Iterator[Event]:
        yield from self._waiting.events.values()
        yield from self._waiting.droppable.values()

    async def has_battery(self, robot: str) -> bool:
        """Return whether there is a battery state of a robot.

        Raises:
            Unavailable: The database does not answer.
        """
        waits = any(event.topic == "battery" and event.robot == robot for event in self._all_that_wait())
        return waits or await self._reader.read(battery.has_battery, robot)

    async def after(
        self, event_id: str, *, goal_id: str | None, action_name: str | None, topics: frozenset[str], limit: int
    ) -> LaterEvents:
        """Return the events after a given id, oldest first, and whether they are complete.

        Raises:
            Unavailable: The database does not answer.
        """
        self._reader.require_everything()
        given_up = any(self._waiting.gaps.get(topic, "") > event_id for topic in topics)
        reaches_back = any((event.id or NEVER) <= event_id for event in self._all_that_wait())
        found = self._that_wait(
            lambda event: (event.id or "") > event_id and selects(event, goal_id, action_name, topics)
        )
        read = partial(
            _after, goal_id=goal_id, action_name=action_name, topics=topics, limit=limit, reaches_back=reaches_back
        )
        later = await self._reader.read(read, event_id)
        return LaterEvents(_joined(found, later.events, limit), complete=later.complete and not given_up)

    async def of_goal(self, goal_id: str, *, kinds: Collection[str], after: str, until: str, limit: int) -> list[Event]:
        """Return the events of a goal between two ids, oldest first.

        Raises:
            Unavailable: The database does not answer.
        """
        self._reader.require_everything()
        found = self._that_wait(
            lambda event: (
                event.goal_id == goal_id and after < (event.id or "") <= until and kind_of(event.id or "") in kinds
            )
        )
        read = partial(queries.events_of_goal, kinds=kinds, after=after, until=until, limit=limit)
        return _joined(found, await self._reader.read(read, goal_id), limit)

    async def knows_all_of(self, goal: Goal) -> bool:
        """Return whether no event of a goal is missing.

        Raises:
            Unavailable: The database does not answer.
        """
        self._reader.require_everything()
        waiting = self._that_wait(lambda event: event.goal_id == goal.goal_id)
        gap = self._waiting.gaps.get("goals", "")
        return await self._reader.read(_knows_all_of, copy(goal), frozenset(waiting), gap)

    async def battery(self, span: BatterySpan) -> list[Bucket]:
        """Return the battery states of a span in buckets, oldest first.

        Raises:
            Unavailable: The database does not answer, or takes too long.
        """
        waiting = self._that_wait(span.covers)
        # From the first pending event on, events are read one by one: one written meanwhile must count once.
        stored, late = await self._reader.read_much(battery.battery, span, min(waiting, default=NEVER))
        waiting |= {event.id or "": event for event in late}
        return await asyncio.to_thread(add_events, stored, waiting.values(), span)


def _joined(waiting: dict[str, Event], stored: list[Event], limit: int) -> list[Event]:
    found = waiting | {event.id or "": event for event in stored}
    return [found[identity] for identity in sorted(found)][:limit]


def _after(
    connection: sa.Connection,
    event_id: str,
    *,
    goal_id: str | None,
    action_name: str | None,
    topics: frozenset[str],
    limit: int,
    reaches_back: bool,
) -> LaterEvents:
    """Return the stored events after a given id, and whether they are complete."""
    found = queries.events_after(
        connection, event_id, goal_id=goal_id, action_name=action_name, topics=topics, limit=limit
    )
    return LaterEvents(
        found, complete=queries.is_complete_after(connection, event_id, topics, reaches_back=reaches_back)
    )


def _knows_all_of(connection: sa.Connection, goal: Goal, waiting: frozenset[str], gap: str) -> bool:
    stored = queries.first_of_goal(connection, goal.goal_id)
    feedback = {identity for identity in waiting if kind_of(identity) == FEEDBACK}
    # Pending events may be written meanwhile; each counts once.
    count, later = queries.feedback_of_goal(connection, goal.goal_id, min(feedback, default=NEVER))
    return is_complete(
        goal,
        first=min(filter(None, (stored, *waiting)), default=None),
        missing=max(queries.horizon(connection, "goals"), gap),
        feedback=count + len(feedback | later),
    )


def selects(event: Event, goal_id: str | None, action_name: str | None, topics: frozenset[str]) -> bool:
    """Return whether an event matches the arguments of `events_after`."""
    if event.topic != "goals" or event.topic not in topics:
        return event.topic in topics
    return goal_id in (None, event.goal_id) and action_name in (None, event.action_name)


def _begin(goal: Goal, first: str) -> str:
    """Return an id before which the goal has no events; `first` is the id of its first existing event.

    Events carry the robot's clock, which may differ from the gateway's.
    """
    return min(first, time_id(nanoseconds(goal.created_at)))


def is_complete(goal: Goal, *, first: str | None, missing: str, feedback: int) -> bool:
    """Return whether no event of a goal has been dropped.

    Args:
        goal: The goal.
        first: Id of its first existing event.
        missing: Id of the newest dropped event of any goal.
        feedback: The number of its existing feedback events.
    """
    if first is None:
        return goal.last_event_id is None
    return missing < _begin(goal, first) or feedback >= goal.feedback_count
