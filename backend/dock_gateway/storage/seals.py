"""Storing events of goals before they are published, and taking turns with other gateways (`order.py`)."""

import asyncio
import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal
from dock_gateway.storage import order, queries
from dock_gateway.storage.database import DATABASE_ERRORS, WRITE_TIMEOUT, Database, brief
from dock_gateway.storage.rows import Batch

log = logging.getLogger(__name__)

SEAL_TIMEOUT = 1.0  # Seconds that the events of a goal, and all later messages, wait for the database.
AHEAD = 0.2  # Seconds for which a turn allows to publish.


@dataclass(frozen=True)
class Seal:
    """A goal whose events must be stored before they are published; `stored` has them as stored, by key."""

    goal: Goal
    events: Sequence[Event]
    stored: "asyncio.Future[order.Stored]"


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
        self._seals: list[Seal] = []
        self._wake = asyncio.Event()
        self._tried = asyncio.Event()
        self._publish: Callable[[list[Event], str | None], None] = lambda *_: None
        self._after: str | None = None  # what the last turn allowed
        self._allowed: str | None = None

    async def open(self) -> None:
        """Take the first turn, if the database is shared and answers; call it while `run` runs."""
        if self._database.shared:
            self.ask()
            await self._tried.wait()

    def follow(self, publish: Callable[[list[Event], str | None], None]) -> Callable[[], None]:
        """See `History.follow`."""
        if self._database.shared:
            self._publish = publish
            publish([], self._allowed)
        return self.ask

    def ask(self) -> None:
        """Take a turn soon."""
        if self._database.shared:
            self._wake.set()

    async def seal(self, goal: Goal, events: Sequence[Event]) -> list[Event] | None:
        """Store events of a goal; return them as stored, or None if the database takes too long.

        Those are left out that another gateway has made outdated.
        """
        seal = Seal(goal, events, asyncio.get_running_loop().create_future())
        self._seals.append(seal)
        self._wake.set()
        try:
            async with asyncio.timeout(SEAL_TIMEOUT):
                stored = await seal.stored
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

    async def run(self) -> None:
        """Store what is pending, until it is canceled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            seals, self._seals = self._seals, []
            goals = {seal.goal.goal_id: seal.goal for seal in seals}
            batch = Batch(goals=list(goals.values()), events=[event for seal in seals for event in seal.events])
            late = asyncio.get_running_loop().call_later(SEAL_TIMEOUT, self._give_way)
            try:
                async with asyncio.timeout(WRITE_TIMEOUT):
                    stored = await self._store(batch)
            except DATABASE_ERRORS as error:
                self._give_way()
                for seal in seals:
                    if not seal.stored.done():
                        seal.stored.set_exception(error)
                asyncio.get_running_loop().call_later(SEAL_TIMEOUT, self.ask)
            else:
                self.slow = False
                for seal in seals:
                    if not seal.stored.done():
                        seal.stored.set_result(stored)
            finally:
                late.cancel()

    async def _store(self, batch: Batch) -> order.Stored:
        # Not durable: the regular record of the goal is, shortly after.
        if not self._database.shared:
            return dict(await self._database.write(queries.seal, batch, durable=False))
        wanted_ns = time.time_ns() + round(AHEAD * 1e9)
        turn = await self._database.write(order.take_turn, batch, self._after, wanted_ns, durable=False)
        self._after = self._allowed = turn.allowed
        self._tried.set()
        if turn.events:
            self.newest = turn.events[-1].id or ""
        self._publish(turn.events, turn.allowed)
        return turn.stored

    def _give_way(self) -> None:
        """Let everything be published, as the database does not answer."""
        self._allowed = None
        self._tried.set()
        if self._database.shared:
            self._publish([], None)
