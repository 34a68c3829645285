"""The entries that wait to be written: plain data in memory, bounded, and readable like stored entries."""

from collections import Counter
from collections.abc import Mapping
from copy import copy
from datetime import UTC, datetime
from itertools import islice
from typing import TypeVar

from dock_gateway.core.event import Event
from dock_gateway.core.event_buffer import EventBuffer
from dock_gateway.core.goal import Goal
from dock_gateway.storage.merge import merge
from dock_gateway.storage.rows import BATCH_EVENTS, BATCH_GOALS, Batch, Entry, Key

Kept = TypeVar("Kept")
# The kind of an entry, and its id.
Name = tuple[str, str]


class WaitingEntries:
    """Goals, events and keys that the database has not taken yet.

    Feedback and battery events beyond `limit` are dropped, oldest first. Other entries beyond `limit` are removed once
    they are in the spool (`evict`), or if the spool fails too (`shed`).

    `unspooled` are the entries that are only here and must not be lost.

    Attributes:
        held: Ids of goals that are not written yet, with how many stores of their events run: a gateway that is killed
            must not leave a goal that has ended, or has another state, without the events of that.
    """

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.goals: dict[str, Goal] = {}
        self.keys: dict[str, Key] = {}
        self.events: dict[str, Event] = {}
        self.droppable = EventBuffer(limit)
        self.gaps: dict[str, str] = {}
        self.dropped = 0
        self.held: Counter[str] = Counter()
        self._unspooled: dict[Name, Entry] = {}

    def __len__(self) -> int:
        return len(self.goals) + len(self.events) + len(self.droppable) + len(self.keys)

    @property
    def anything(self) -> bool:
        """Whether there is anything to write."""
        return bool(self.goals or self.keys or self.events or self.droppable or self.gaps)

    @property
    def must_keep(self) -> bool:
        """Whether any entry must not be lost."""
        return bool(self.goals or self.keys or self.events)

    def put(self, entry: Entry, *, safe: bool = False) -> None:
        """Add an entry; `safe` if it is in the spool."""
        if isinstance(entry, Goal):
            self.put_goal(entry, safe=safe)
        elif isinstance(entry, Key):
            self.put_key(entry, safe=safe)
        else:
            self.put_event(entry, safe=safe)

    def put_goal(self, goal: Goal, *, safe: bool = False) -> Goal:
        """Add the current state of a goal; return the pending version."""
        waiting = self.goals.get(goal.goal_id)
        kept = copy(goal) if waiting is None else merge(waiting, goal)
        self.goals[goal.goal_id] = kept
        if not safe:
            self._unspooled["goal", goal.goal_id] = kept
        return kept

    def forget_goal(self, goal_id: str) -> None:
        """Remove a goal that must not be stored after all."""
        self.goals.pop(goal_id, None)
        self._unspooled.pop(("goal", goal_id), None)

    def hold(self, goal_id: str) -> None:
        """Do not write a goal while its events are being stored, until `let_go`."""
        self.held[goal_id] += 1

    def let_go(self, goal_id: str) -> None:
        """Write a goal again, once none of its events is being stored."""
        self.held[goal_id] -= 1
        if self.held[goal_id] <= 0:
            del self.held[goal_id]

    def put_key(self, key: Key, *, safe: bool = False) -> None:
        """Add a key; the first goal to claim it keeps it."""
        if key.key not in self.keys:
            self.keys[key.key] = key
            if not safe:
                self._unspooled["key", key.key] = key

    def forget_key(self, key: str, goal_id: str) -> None:
        """Remove the key of a goal that must not be stored after all."""
        if key in self.keys and self.keys[key].goal_id == goal_id:
            del self.keys[key]
            self._unspooled.pop(("key", key), None)

    def put_event(self, event: Event, *, safe: bool = False) -> None:
        """Add an event that has an id."""
        identity = event.id or ""
        if event.droppable:
            for gone in self.droppable.put(event):
                self.drop(gone)
        elif identity not in self.events:
            self.events[identity] = event
            if not safe:
                self._unspooled["event", identity] = event

    def drop(self, event: Event) -> None:
        """Drop an event and record that it is missing."""
        self.droppable.remove(event.id or "")
        self.events.pop(event.id or "", None)
        self._unspooled.pop(("event", event.id or ""), None)
        self.dropped += 1
        self.gaps[event.topic] = max(event.id or "", self.gaps.get(event.topic, ""))

    def batch(self) -> Batch:
        """Return the next batch, oldest first; its entries stay until `done`."""
        goals = self.goals
        if self.held:
            goals = {goal_id: goal for goal_id, goal in goals.items() if goal_id not in self.held}
        return Batch(
            goals=_first(goals, BATCH_GOALS),
            keys=_first(self.keys, BATCH_GOALS),
            events=[*_first(self.events, BATCH_EVENTS), *_first(self.droppable, BATCH_EVENTS)][:BATCH_EVENTS],
            gaps=dict(self.gaps),
        )

    def done(self, batch: Batch) -> None:
        """Remove a written batch, except goals that changed meanwhile."""
        for goal in batch.goals:
            if self.goals.get(goal.goal_id) is goal:
                del self.goals[goal.goal_id]
                self._unspooled.pop(("goal", goal.goal_id), None)
        for key in batch.keys:
            self.keys.pop(key.key, None)
            self._unspooled.pop(("key", key.key), None)
        for event in batch.events:
            self.events.pop(event.id or "", None)
            self.droppable.remove(event.id or "")
            self._unspooled.pop(("event", event.id or ""), None)
        for topic, event_id in batch.gaps.items():
            if self.gaps.get(topic) == event_id:
                del self.gaps[topic]

    def unspooled(self) -> dict[Name, Entry]:
        """Return the entries that are only in memory."""
        return {name: entry for name, entry in self._unspooled.items() if name[1] not in self.held}

    def saved(self, entries: Mapping[Name, Entry]) -> None:
        """Mark entries as spooled, unless they have changed meanwhile."""
        for name, entry in entries.items():
            if self._unspooled.get(name) is entry:
                del self._unspooled[name]

    def forget_spool(self) -> None:
        """Mark all entries as not spooled, because the spool is lost."""
        self._unspooled = {("goal", goal_id): goal for goal_id, goal in self.goals.items()}
        self._unspooled |= {("event", event_id): event for event_id, event in self.events.items()}
        self._unspooled |= {("key", name): key for name, key in self.keys.items()}

    def shed(self) -> None:
        """Drop the oldest events and ended external goals beyond the limit, because database and spool both fail.

        Goals of a gateway stay; no new ones are accepted meanwhile.
        """
        for event in list(self.events.values())[: -self.limit]:
            self.drop(event)
        others = [goal for goal in self.goals.values() if goal.origin == "external" and goal.status.terminal]
        for goal in others[: -self.limit]:
            self.forget_goal(goal.goal_id)

    def evict(self) -> int:
        """Remove the oldest spooled entries beyond the limit; return their number."""
        evicted = 0
        for name, held in (("goal", self.goals), ("event", self.events), ("key", self.keys)):
            if len(held) <= self.limit:
                continue
            safe = [identity for identity in held if (name, identity) not in self._unspooled]
            for identity in safe[: len(held) - self.limit]:
                del held[identity]
                evicted += 1
        return evicted


def batch_of(entries: list[Entry]) -> Batch:
    """Return spool entries as one batch; versions of the same goal are merged."""
    waiting = WaitingEntries(len(entries))
    for entry in entries:
        if isinstance(entry, Goal):
            waiting.put_goal(entry)
    keys = [entry for entry in entries if isinstance(entry, Key) and entry.expires_at > datetime.now(UTC)]
    events = [entry for entry in entries if not isinstance(entry, Goal | Key)]
    return Batch(goals=list(waiting.goals.values()), events=events, keys=keys)


def _first(held: dict[str, Kept], limit: int) -> list[Kept]:
    return list(islice(held.values(), limit))
