"""The events for one reader, in order: a snapshot or the missed events, then everything as it happens."""

import asyncio
import math
import time
from collections.abc import AsyncIterator, Iterable, Iterator

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import Event, notice, position_of, utc_now
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal
from dock_gateway.core.throttle import Throttle
from dock_gateway.goals.goals import Goals
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from dock_gateway.storage import History, LaterEvents
from dock_gateway.streams.current_state import CurrentState

# Missed events are read from the history in pieces of PIECE events, at most MAX_PIECES pieces.
PIECE, MAX_PIECES = 1000, 100
# Seconds that a resuming reader waits for a history that does not answer.
PATIENCE = 3.0


async def feed(
    parts: Parts, subscriber: Subscriber, *, after: str | None = None, max_rate: float | None = None
) -> AsyncIterator[Event]:
    """Yield every message for one reader. Ends when the gateway closes or the reader is too slow.

    Args:
        parts: The parts of the gateway.
        subscriber: The reader's place in the fan-out.
        after: Id of the last event that the reader has seen. First come `resumed`, the missed events, and the current
            state of all that is not replayed. If some events are gone: `gap`, the remaining ones, and a snapshot.
        max_rate: Maximum messages per second of each goal's feedback, of battery and of velocity.
    """
    newest = parts[Fanout].newest
    async for event in begin(parts, subscriber, after):
        yield event
    async for event in follow(parts, subscriber, max_rate, newest):
        yield event


async def follow(
    parts: Parts, subscriber: Subscriber, max_rate: float | None = None, newest: str | None = None
) -> AsyncIterator[Event]:
    """Yield every message of a `feed` after the first ones: events, and notices of the stream itself.

    Args:
        parts: The parts of the gateway.
        subscriber: The reader's place in the fan-out.
        max_rate: As for `feed`.
        newest: Id of the last event before the first messages, for heartbeats; None if these have no position.
    """
    interval = parts[Settings].heartbeat_interval
    throttle = Throttle(max_rate)
    next_heartbeat = time.monotonic() + interval
    while not (parts[Fanout].closing or subscriber.overrun or subscriber.expelled):
        due = min(next_heartbeat, throttle.next_due())
        events, dropped = await subscriber.take(max(0.0, due - time.monotonic()))
        reached = parts[Fanout].newest if newest is not None and subscriber.empty else None
        if dropped:
            yield notice("dropped", utc_now(), count=dropped)
        now = time.monotonic()
        for event in permitted(subscriber, throttle.let_through(events, now)):
            yield event
        if reached is not None and throttle.next_due() == math.inf:  # nothing is held back
            newest = reached
        if now >= next_heartbeat:
            yield notice("heartbeat", utc_now(), position=newest and position_of(newest))
            next_heartbeat = now + interval
    yield notice("closing", utc_now(), reason=end_of(subscriber))


def end_of(subscriber: Subscriber) -> str:
    """Return why a stream ends."""
    if subscriber.expelled:
        return "invalid_token"
    return "too_slow" if subscriber.overrun else "shutting_down"


async def begin(parts: Parts, subscriber: Subscriber, after: str | None) -> AsyncIterator[Event]:
    """Yield the first messages: a snapshot, or the events missed since an event.

    If the reader wants a single goal, `ends_goal` of the last one says whether the reader now knows how the goal ended.
    """
    subscriber.clear()  # everything up to now is in the snapshot or the replay
    newest = parts[Fanout].newest
    if after is not None and parts[Fanout].clock.is_past(after):
        goal_id = subscriber.event_filter.goal_id
        missed = await _missed(parts, subscriber, parts[Fanout].resolve(after))
        if missed.complete:
            over = goal_id is not None and has_seen_end(parts, await parts[Goals].get(goal_id), after)
            yield notice("resumed", utc_now(), ends_goal=over, after=after, count=len(missed.events))
            for event in permitted(subscriber, (*missed.events, *parts[CurrentState].events(subscriber.event_filter))):
                yield event
            return
        yield notice("gap", utc_now(), after=after, count=len(missed.events))
        for event in permitted(subscriber, missed.events):
            yield event
    elif after is not None:
        yield notice("gap", utc_now(), after=after, count=0)
    if not subscriber.expelled:
        yield await parts[CurrentState].snapshot(subscriber.event_filter, position_of(newest))


def permitted(subscriber: Subscriber, events: Iterable[Event]) -> Iterator[Event]:
    """Yield events as long as their reader may read: one that reads slowly takes a while for all of them."""
    for event in events:
        if subscriber.expelled:
            return
        yield event


def has_seen_end(parts: Parts, goal: Goal, after: str) -> bool:
    """Whether a reader that has seen the event `after`, of any gateway, knows how a goal ended."""
    return goal.status.terminal and (goal.last_event_id or "") <= parts[Fanout].resolve(after)


async def _missed(parts: Parts, subscriber: Subscriber, after: str) -> LaterEvents:
    """Return the events after an event, published by any gateway. The reader's queue skips them."""
    subscriber.after = after
    missed = parts[Fanout].since(after, subscriber.event_filter)
    if missed is not None:
        return LaterEvents(missed, complete=True)
    later = await _from_history(parts, subscriber.event_filter, after)
    if later.events:
        subscriber.catch_up(later.events[-1].id or after)
    return later


async def _from_history(parts: Parts, event_filter: EventFilter, after: str) -> LaterEvents:
    """Return the stored events after an event that this process has not seen or no longer holds."""
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            return await _read_history(parts, event_filter, after)
        except GatewayError:
            if time.monotonic() >= deadline or parts[Fanout].closing:
                return LaterEvents([], complete=False)
            await asyncio.sleep(0.1)


async def _read_history(parts: Parts, event_filter: EventFilter, after: str) -> LaterEvents:
    missed: list[Event] = []
    complete, last = True, after
    for _ in range(MAX_PIECES):
        piece = await parts[History].events_after(
            last,
            goal_id=event_filter.goal_id,
            action_name=event_filter.action_name,
            topics=event_filter.topics,
            limit=PIECE,
        )
        complete = complete and piece.complete
        missed.extend(event for event in piece.events if event_filter.covers(event))
        if len(piece.events) < PIECE:
            return LaterEvents(missed, complete)
        last = piece.events[-1].id or last
    return LaterEvents([], complete=False)
