"""Publishes the events of goals: the end of one, and where gateways share a history each state, after it is stored."""

import time
from collections.abc import Awaitable, Callable

from dock_gateway.core.event import Event, nanoseconds, result_event, status_event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.line import Reservation
from dock_gateway.core.tasks import Tasks
from dock_gateway.storage import History


class GoalPublisher:
    """Publishes the events of goals, in the order of all gateways that share the history.

    Args:
        fanout: Receives the events.
        history: Stores them.
    """

    def __init__(self, fanout: Fanout, history: History) -> None:
        self._fanout = fanout
        self._history = history
        self._seals = Tasks("storing the events of goals")

    def publish(self, event: Event, goal: Goal) -> None:
        """Publish feedback or a state. A history that is shared stores states first: another gateway may be killed."""
        if event.droppable or not self._history.shared:
            self._fanout.publish(event)
        else:
            self._seals.spawn(self._seal(goal, [event], self._history.seal(goal, [event])))

    def publish_first(self, goal: Goal) -> None:
        """Publish that a goal was sent, if the gateway that sent it was killed before it had stored that.

        The event has the same key at every gateway, so it is stored once.
        """
        if self._history.shared and goal.last_event_id is None and goal.status is GoalStatus.PENDING:
            source_ns = nanoseconds(goal.created_at)
            self.publish(status_event(goal, self._fanout.clock.stamp(source_ns), source_ns), goal)

    def publish_now(self, make: Callable[[Goal, int, int], Event], goal: Goal) -> None:
        """Publish an event that has no source but this gateway, and record the goal."""
        now_ns = time.time_ns()
        self.publish(make(goal, self._fanout.clock.stamp(now_ns), now_ns), goal)
        self._history.record(goal)

    def publish_end(self, goal: Goal, source_ns: int, published: Callable[[Goal], None]) -> None:
        """Store the events of the end, then publish them: as stored, if another gateway was first.

        Args:
            goal: The goal.
            source_ns: When it ended, in nanoseconds since 1970.
            published: Called afterwards.
        """
        # A history that is shared says when they are to be published: see `History.follow`.
        place = None if self._history.shared else self._fanout.line.reserve(source_ns)
        stamp = self._fanout.clock.stamp(source_ns) if place is None else place.stamp
        end = [status_event(goal, stamp, source_ns), result_event(goal, stamp, source_ns)]
        self._seals.spawn(self._seal(goal, end, self._history.seal(goal, end), place, published))

    async def _seal(
        self,
        goal: Goal,
        events: list[Event],
        sealing: Awaitable[list[Event] | None],
        place: Reservation | None = None,
        published: Callable[[Goal], None] = lambda _: None,
    ) -> None:
        stored = None
        try:
            stored = await sealing
        finally:
            if place is None:
                stored = self._fanout.line.publish_stored(events, stored)
            else:
                stored = stored or events
                place.release(stored)
            self._note(goal, events, stored)
            published(goal)

    def _note(self, goal: Goal, events: list[Event], stored: list[Event]) -> None:
        """Note the id of the last event as it is stored, unless the goal has later ones."""
        if stored and stored[-1].id != goal.last_event_id == events[-1].id:
            goal.last_event_id = stored[-1].id
            self._history.record(goal)

    async def drain(self) -> None:
        """Wait until all events are published, a second at most."""
        await self._seals.drain()
