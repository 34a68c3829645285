"""Storing the ends of goals at once, before they are published."""

import asyncio
import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal
from dock_gateway.storage import queries
from dock_gateway.storage.database import DATABASE_ERRORS, WRITE_TIMEOUT, Database, brief
from dock_gateway.storage.rows import Batch

log = logging.getLogger(__name__)

SEAL_TIMEOUT = 1.0  # Seconds that the end of a goal, and all later messages, wait for the database.


@dataclass(frozen=True)
class Seal:
    """A goal whose end must be stored before it is published; `stored` has the events as stored, by key."""

    goal: Goal
    end: Sequence[Event]
    stored: "asyncio.Future[dict[str, Event]]"


class Sealer:
    """Stores the ends of goals; all pending ones in one transaction.

    Args:
        database: The database to write to.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._seals: list[Seal] = []
        self._wake = asyncio.Event()

    async def seal(self, goal: Goal, end: Sequence[Event]) -> list[Event]:
        """Store the end of a goal; return its events as stored, or as they are if the database takes too long."""
        seal = Seal(goal, end, asyncio.get_running_loop().create_future())
        self._seals.append(seal)
        self._wake.set()
        try:
            async with asyncio.timeout(SEAL_TIMEOUT):
                stored = await seal.stored
        except DATABASE_ERRORS as error:
            log.warning(
                "goal %s: its state is published before it is stored: %s",
                goal.goal_id,
                brief(error),
                extra={"goal_id": goal.goal_id},
            )
            return list(end)
        return [replace(stored.get(event.key or "", event), ends_goal=event.ends_goal) for event in end]

    async def run(self) -> None:
        """Store what is pending, until it is canceled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            seals, self._seals = self._seals, []
            goals = {seal.goal.goal_id: seal.goal for seal in seals}
            batch = Batch(goals=list(goals.values()), events=[event for seal in seals for event in seal.end])
            try:
                async with asyncio.timeout(WRITE_TIMEOUT):
                    # Not durable: the regular record of the goal is, shortly after.
                    stored = await self._database.write(queries.seal, batch, durable=False)
            except DATABASE_ERRORS as error:
                for seal in seals:
                    if not seal.stored.done():
                        seal.stored.set_exception(error)
            else:
                for seal in seals:
                    if not seal.stored.done():
                        seal.stored.set_result(stored)
