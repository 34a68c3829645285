"""A history that is still being loaded: what must be kept is kept at once, and who asks waits until it can be asked.

SQLAlchemy takes half as long to load as all the rest of the gateway. A robot need not wait for that: goals go to the
spool meanwhile, as they do while the database is away.
"""

import asyncio
import logging
from collections.abc import Callable, Collection
from contextlib import suppress
from copy import copy
from typing import Protocol

from dock_gateway.errors import Unavailable
from dock_gateway.events import Event
from dock_gateway.goals import Goal
from dock_gateway.history.buckets import BatterySpan, Bucket
from dock_gateway.history.protocol import NEVER, Acknowledgement, History, HistoryStats
from dock_gateway.history.spool import Entry, Spool
from dock_gateway.history.wanted import Wanted
from dock_gateway.tasks import cancel

log = logging.getLogger(__name__)

# The start keeps the loop busy for longer; the loading begins when it has done with that.
LOAD_AFTER = 0.5
# Who asks waits so long at most.
PATIENCE = 10.0
# So much is remembered of what comes meanwhile.
MAX_EARLY = 20_000
NOT_LOADED = "it is still being opened"


class Loaded(History, Protocol):
    """What is loaded, and has to be opened."""

    async def open(self) -> None:
        """Take up what a process before this one left, and wait a little for the database."""


class LateHistory:
    """Stands for a history from before it is loaded until the end.

    Args:
        load: Makes it, on another thread; it keeps what its database does not take in the spool it is given.
        spool: The spool.
    """

    def __init__(self, load: Callable[[Spool], Loaded], spool: Spool) -> None:
        self.acknowledgements = LateAcknowledgements(self)
        self._spool = spool
        self._early: list[Goal | Event] = []
        self._history: Loaded | None = None
        self._dropped = 0
        self._error: str | None = None
        self._answers = asyncio.Event()
        self._opening = asyncio.create_task(self._open(load))

    async def _open(self, load: Callable[[Spool], Loaded]) -> None:
        try:
            await asyncio.sleep(LOAD_AFTER)
            history = await asyncio.to_thread(load, self._spool)
            early, self._early, self._history = self._early, [], history
            for entry in early:
                history.record(entry) if isinstance(entry, Goal) else history.record_event(entry)
            await history.open()
        except Exception as error:
            self._error = f"it cannot be opened: {error}"
            log.exception("the history cannot be opened; goals are kept in the spool alone")
        finally:
            self._answers.set()

    async def opened(self) -> None:
        """Come back when it can be asked, or when that takes too long."""
        if self._answers.is_set():  # each time but the first
            return
        with suppress(TimeoutError):
            async with asyncio.timeout(PATIENCE):
                await self._answers.wait()

    def hurry(self) -> None:
        """Nobody waits any more: the gateway is about to close."""
        self._answers.set()

    async def when_opened(self) -> History:
        """The history itself, once it can be asked.

        Raises:
            Unavailable: It could not be opened, or not yet (`history_unavailable`).
        """
        await self.opened()
        if self._history is None or not self._answers.is_set() or self._error is not None:
            raise Unavailable(f"the history cannot be asked: {self._error or NOT_LOADED}", code="history_unavailable")
        return self._history

    # ------------------------------------------------------------------ write

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        """Keep a new goal; it is safe once this returns."""
        if self._history is None and idempotency_key is None:
            await self._spool_early(goal)
        else:
            await (self._history or await self.when_opened()).add(goal, idempotency_key)

    async def _spool_early(self, goal: Goal) -> None:
        try:
            await self._spool.append([goal])
        except OSError as error:
            raise Unavailable("the goal cannot be stored, so it must not run", code="history_unavailable") from error
        self.record(goal)

    async def claim(self, idempotency_key: str, goal_id: str, fingerprint: str) -> tuple[str, str]:
        """Bind a key to a goal, or tell whose it is."""
        return await (await self.when_opened()).claim(idempotency_key, goal_id, fingerprint)

    async def release(self, idempotency_key: str, goal_id: str) -> None:
        """Let go of the key of a goal."""
        await (await self.when_opened()).release(idempotency_key, goal_id)

    def record(self, goal: Goal) -> None:
        """Keep what is new about a goal."""
        if self._history is None:
            self._keep_early(copy(goal))
        else:
            self._history.record(goal)

    def record_event(self, event: Event) -> None:
        """Keep an event, once."""
        if self._history is None:
            self._keep_early(event)
        else:
            self._history.record_event(event)

    def _keep_early(self, entry: Goal | Event) -> None:
        if len(self._early) < MAX_EARLY:
            self._early.append(entry)
        else:
            self._dropped += 1

    # ------------------------------------------------------------------ read

    async def page(self, wanted: Wanted, *, limit: int, before: str | None = None) -> list[Goal]:
        """Goals, newest first."""
        return await (await self.when_opened()).page(wanted, limit=limit, before=before)

    async def get(self, goal_id: str) -> Goal | None:
        """One goal."""
        return await (await self.when_opened()).get(goal_id)

    async def by_key(self, idempotency_key: str) -> Goal | None:
        """The goal that was sent with this key."""
        return await (await self.when_opened()).by_key(idempotency_key)

    async def unfinished(self, *, complete: bool = False) -> list[Goal]:
        """The goals whose status is not final, oldest first."""
        return await (await self.when_opened()).unfinished(complete=complete)

    async def events_after(
        self, event_id: str, *, goal_id: str | None, action_name: str | None, topics: frozenset[str], limit: int
    ) -> list[Event] | None:
        """The events that follow one, oldest first; None where they are not all there."""
        history = await self.when_opened()
        return await history.events_after(
            event_id, goal_id=goal_id, action_name=action_name, topics=topics, limit=limit
        )

    async def events_of(
        self, goal_id: str, *, kinds: Collection[str], after: str = "", until: str = NEVER, limit: int
    ) -> list[Event]:
        """The events of a goal between two, oldest first."""
        history = await self.when_opened()
        return await history.events_of(goal_id, kinds=kinds, after=after, until=until, limit=limit)

    async def knows_all_of(self, goal: Goal) -> bool:
        """Whether no event of a goal is missing."""
        return await (await self.when_opened()).knows_all_of(goal)

    async def battery(self, span: BatterySpan) -> list[Bucket]:
        """The battery states of a span in buckets, oldest first."""
        return await (await self.when_opened()).battery(span)

    # ------------------------------------------------------------------ the rest

    def stats(self) -> HistoryStats:
        """How the keeping goes."""
        if self._history is not None:
            return self._history.stats()
        waiting, spooled, error = len(self._early), self._spool.count, self._error or NOT_LOADED
        return HistoryStats(waiting, spooled, self._dropped, database_reachable=False, last_error=error)

    async def close(self) -> None:
        """Write what waits, or have the spool keep it."""
        if self._history is None:
            await cancel(self._opening)
        else:
            await asyncio.gather(self._opening, return_exceptions=True)
        if self._history is not None:
            await self._history.close()
            return
        entries: list[Entry] = [entry for entry in self._early if isinstance(entry, Goal) or not entry.droppable]
        try:
            await self._spool.append(entries)
        except OSError as error:
            log.error("%d entries are lost: the spool cannot be written: %s", len(entries), error)
        await self._spool.close()


class LateAcknowledgements:
    """The acknowledgements in such a history."""

    def __init__(self, history: LateHistory) -> None:
        self._history = history

    async def read(self) -> dict[str, Acknowledgement]:
        """All of them, by the id of the alert."""
        return await (await self._history.when_opened()).acknowledgements.read()

    async def write(self, alert_id: str, acknowledgement: Acknowledgement | None) -> None:
        """Keep one in place of what there was, or none."""
        await (await self._history.when_opened()).acknowledgements.write(alert_id, acknowledgement)
