"""The history in memory (`memory:`). Nothing outlives the process."""

import asyncio
import bisect
import time
from collections import defaultdict
from collections.abc import Awaitable, Callable, Collection, Sequence
from copy import copy
from typing import Any

from dock_gateway.core.event import FEEDBACK, Event, kind_of
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal
from dock_gateway.storage.audit import MemoryAudit
from dock_gateway.storage.battery import BatterySpan, Bucket, add_events
from dock_gateway.storage.database import Incident
from dock_gateway.storage.entries import MemoryEntries
from dock_gateway.storage.event_reader import is_complete, selects
from dock_gateway.storage.merge import merge
from dock_gateway.storage.notes import MemoryNotes
from dock_gateway.storage.protocol import (
    KEY_LIFETIME,
    NEVER,
    EntryT,
    HistoryStats,
    LaterEvents,
    fingerprint_of,
)
from dock_gateway.storage.statistics import Span, Tallies, tally_goals


class MemoryHistory:
    """Goals, events and keys in memory.

    Beyond `limit`, the oldest ended goals are dropped; running ones never are. Beyond `event_limit`, the oldest events
    are dropped, feedback and battery first.
    """

    shared = False
    newest = ""
    incident: Incident | None = None

    def __init__(self, limit: int, event_limit: int = 10_000) -> None:
        self.notes = MemoryNotes()
        self.audit = MemoryAudit()
        self.on_loss: Callable[[], None] = lambda: None
        self._documents: defaultdict[str, MemoryEntries[Any]] = defaultdict(MemoryEntries)
        self._limit = limit
        self._event_limit = event_limit
        self._goals: dict[str, Goal] = {}
        self._keys: dict[str, tuple[str, str, float]] = {}  # goal_id, fingerprint, expiry (monotonic)
        self._events: dict[str, Event] = {}
        self._event_ids: list[str] = []  # sorted
        self._horizon: dict[str, str] = {}  # topic → id of the newest dropped event
        self._dropped = 0

    def documents(self, kind: str, model: type[EntryT]) -> MemoryEntries[EntryT]:
        """Return the entries of a kind."""
        return self._documents[kind]

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        """Store a new goal."""
        if idempotency_key is not None:
            await self.claim(idempotency_key, goal.goal_id, fingerprint_of(goal.action_name, goal.goal))
        self.record(goal)

    async def claim(self, idempotency_key: str, goal_id: str, fingerprint: str) -> tuple[str, str]:
        """Bind a key to a goal, or return its owner."""
        now = time.monotonic()
        held = self._keys.get(idempotency_key)
        if held is None or held[2] <= now:
            held = (goal_id, fingerprint, now + KEY_LIFETIME.total_seconds())
            self._keys[idempotency_key] = held
        return held[:2]

    async def release(self, idempotency_key: str, goal_id: str) -> None:
        """Release the key if this goal holds it."""
        held = self._keys.get(idempotency_key)
        if held is not None and held[0] == goal_id:
            del self._keys[idempotency_key]

    def record(self, goal: Goal) -> None:
        """Record the current state of a goal."""
        stored = self._goals.get(goal.goal_id)
        self._goals[goal.goal_id] = copy(goal) if stored is None else merge(stored, goal)
        if len(self._goals) > self._limit:
            self._forget()

    def _forget(self) -> None:
        oldest = next((goal_id for goal_id, goal in self._goals.items() if goal.status.terminal), None)
        if oldest is not None:
            del self._goals[oldest]
            self.notes.forget(oldest)
            self._keys = {key: held for key, held in self._keys.items() if held[0] != oldest}

    def record_event(self, event: Event) -> None:
        """Record an event; duplicates are ignored."""
        if event.id is None or event.id in self._events:
            return
        self._events[event.id] = event
        bisect.insort(self._event_ids, event.id)
        if len(self._event_ids) > self._event_limit:
            index = next((i for i, each in enumerate(self._event_ids) if self._events[each].droppable), 0)
            oldest = self._events.pop(self._event_ids.pop(index))
            self._horizon[oldest.topic] = max(oldest.id or "", self._horizon.get(oldest.topic, ""))
            self._dropped += 1

    def seal(self, goal: Goal, events: Sequence[Event]) -> Awaitable[list[Event] | None]:
        """Store a goal."""
        self.record(goal)
        return self._sealed(list(events))

    async def _sealed(self, events: list[Event]) -> list[Event]:
        return events

    def follow(self, publish: Callable[[list[Event], str | None], None]) -> Callable[[], None]:
        """Do nothing: no other gateway uses this memory."""
        return lambda: None

    async def page(self, wanted: GoalFilter, *, limit: int, before: str | None = None) -> list[Goal]:
        """Return goals, newest first."""
        newest_first = sorted(self._goals.values(), key=lambda goal: (goal.created_at, goal.goal_id), reverse=True)
        if before is not None:
            position = next((i for i, goal in enumerate(newest_first) if goal.goal_id == before), len(newest_first))
            newest_first = newest_first[position + 1 :]
        tagged = self._tagged(wanted)
        found = (copy(goal) for goal in newest_first if tagged(goal) and wanted.matches(goal))
        return [goal for goal, _ in zip(found, range(limit), strict=False)]

    async def action_names(self) -> set[str]:
        """Return the names of the actions that have goals."""
        return {goal.action_name for goal in self._goals.values()}

    def _tagged(self, wanted: GoalFilter) -> Callable[[Goal], bool]:
        """Return a function that says whether a goal has one of the wanted tags, if any are wanted."""
        chosen = self.notes.with_one_of(wanted.tags)
        return lambda goal: not wanted.tags or goal.goal_id in chosen

    async def get(self, goal_id: str) -> Goal | None:
        """Return a goal, or None if there is no such goal."""
        goal = self._goals.get(goal_id)
        return None if goal is None else copy(goal)

    async def known(self, goal_ids: Collection[str]) -> dict[str, Goal]:
        """Return the stored goals among these ids, by id."""
        return {goal_id: copy(self._goals[goal_id]) for goal_id in goal_ids if goal_id in self._goals}

    async def by_key(self, idempotency_key: str) -> Goal | None:
        """Return the goal sent with this key."""
        held = self._keys.get(idempotency_key)
        return await self.get(held[0]) if held is not None and held[2] > time.monotonic() else None

    async def unfinished(self, *, complete: bool = False) -> list[Goal]:
        """Return the goals without a final status, oldest first."""
        goals = [copy(goal) for goal in self._goals.values() if not goal.status.final]
        return sorted(goals, key=lambda goal: (goal.created_at, goal.goal_id))

    async def events_after(
        self, event_id: str, *, goal_id: str | None, action_name: str | None, topics: frozenset[str], limit: int
    ) -> LaterEvents:
        """Return the events after a given id, oldest first."""
        given_up = any(event_id < self._horizon.get(topic, "") for topic in topics)
        known = (*self._event_ids[:1], *self._horizon.values())
        complete = not given_up and any(event_id >= each for each in known)
        start = bisect.bisect_right(self._event_ids, event_id)
        later = (self._events[each] for each in self._event_ids[start:])
        found = (event for event in later if selects(event, goal_id, action_name, topics))
        return LaterEvents([event for event, _ in zip(found, range(limit), strict=False)], complete)

    async def events_of(
        self, goal_id: str, *, kinds: Collection[str], after: str = "", until: str = NEVER, limit: int
    ) -> list[Event]:
        """Return the events of a goal from `after` (exclusive) to `until` (inclusive), oldest first."""
        between = (each for each in self._ids_of(goal_id) if after < each <= until and kind_of(each) in kinds)
        return [self._events[each] for each, _ in zip(between, range(limit), strict=False)]

    async def knows_all_of(self, goal: Goal) -> bool:
        """Return whether no event of a goal has been dropped."""
        ids = self._ids_of(goal.goal_id)
        return is_complete(
            goal,
            first=min(ids, default=None),
            missing=self._horizon.get("goals", ""),
            feedback=sum(kind_of(each) == FEEDBACK for each in ids),
        )

    def _ids_of(self, goal_id: str) -> list[str]:
        return [each for each in self._event_ids if self._events[each].goal_id == goal_id]

    async def battery(self, span: BatterySpan) -> list[Bucket]:
        """Return the battery states of a span in buckets, oldest first."""
        covered = [event for event in self._events.values() if span.covers(event)]
        return await asyncio.to_thread(add_events, {}, covered, span)

    async def tally(self, wanted: GoalFilter, spans: Sequence[Span], *, by_action: bool) -> list[Tallies]:
        """Return how the wanted goals ended, for each span of the time when they were created."""
        found = [copy(goal) for goal in filter(self._tagged(wanted), self._goals.values())]
        return await asyncio.to_thread(tally_goals, found, wanted, spans, by_action=by_action)

    def stats(self) -> HistoryStats:
        """Return the state of the history; only `dropped` ever changes."""
        return HistoryStats(dropped=self._dropped)

    async def close(self) -> None:
        """Do nothing; there is nothing to write."""
