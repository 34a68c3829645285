"""Storing events of goals before they are published, and taking turns with other gateways (`order.py`)."""

import asyncio
import logging
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal
from dock_gateway.storage import order, queries
from dock_gateway.storage.database import DATABASE_ERRORS, WRITE_TIMEOUT, Database, brief
from dock_gateway.storage.group_commit import GroupCommit
from dock_gateway.storage.rows import Batch

log = logging.getLogger(__name__)

SEAL_TIMEOUT = 1.0  # Seconds that the events of a goal, and all later messages, wait for the database.
AHEAD = 0.2  # Seconds for which a turn allows to publish.


class Sealer:
    """Stores events of goals; all pending ones in one transaction, which is a turn if the database is shared.

    Args:
        database: The database to write to.

    Attributes:
        newest: Id of the newest event that a turn has returned.
        slow: Whether an event was not stored in time, and none has been stored since.
    """

    def __init__(self, database: Database) -> None:
        self.newest = ""
        self.slow = False
        self._database = database
        self._commits = GroupCommit(self._store)
        self._publish: Callable[[list[Event], str | None], None] = lambda *_: None
        self._after: str | None = None  # what the last turn allowed

    async def run(self) -> None:
        """Store what is pending, until it is canceled."""
        await self._commits.run()

    async def open(self) -> None:
        """Take the first turn, if the database is shared and answers; call it while `run` runs."""
        if self._database.shared:
            with suppress(*DATABASE_ERRORS):
                async with asyncio.timeout(SEAL_TIMEOUT):
                    await self._commits.commit(Batch())

    def follow(self, publish: Callable[[list[Event], str | None], None]) -> Callable[[], None]:
        """See `History.follow`."""
        if self._database.shared:
            self._publish = publish
            publish([], self._after)
        return self.ask

    def ask(self) -> None:
        """Take a turn soon."""
        if self._database.shared:
            self._commits.wake()

    async def seal(self, goal: Goal, events: Sequence[Event]) -> list[Event] | None:
        """Store events of a goal; return them as stored, or None if the database takes too long.

        Those are left out that another gateway has made outdated.
        """
        try:
            async with asyncio.timeout(SEAL_TIMEOUT):
                stored = await self._commits.commit(Batch(goals=[goal], events=list(events)))
        except DATABASE_ERRORS as error:
            self.slow = True
            log.warning(
                "goal %s: its state is published before it is stored: %s",
                goal.goal_id,
                brief(error),
                extra={"goal_id": goal.goal_id},
            )
            return None
        found = [(event, stored.get(event.key or "", event)) for event in events]
        return [replace(as_stored, ends_goal=event.ends_goal) for event, as_stored in found if as_stored is not None]

    async def _store(self, batch: Batch) -> order.Stored:
        loop = asyncio.get_running_loop()
        late = loop.call_later(SEAL_TIMEOUT, self._give_way)
        try:
            async with asyncio.timeout(WRITE_TIMEOUT):
                stored = await self._write(batch)
        except DATABASE_ERRORS:
            self._give_way()
            loop.call_later(SEAL_TIMEOUT, self.ask)
            raise
        finally:
            late.cancel()
        self.slow = False
        return stored

    async def _write(self, batch: Batch) -> order.Stored:
        # Not durable: the regular record of the goal is, shortly after.
        if not self._database.shared:
            return dict(await self._database.write(queries.seal, batch, durable=False))
        wanted_ns = time.time_ns() + round(AHEAD * 1e9)
        turn = await self._database.write(order.take_turn, batch, self._after, wanted_ns, durable=False)
        self._after = turn.allowed
        if turn.events:
            self.newest = turn.events[-1].id or ""
        self._publish(turn.events, turn.allowed)
        return turn.stored

    def _give_way(self) -> None:
        """Let everything be published, as the database does not answer."""
        if self._database.shared:
            self._publish([], None)
