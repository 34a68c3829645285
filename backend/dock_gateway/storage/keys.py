"""Idempotency keys: the newest ones in memory, all in the database, where they are valid at every gateway."""

import asyncio
from contextlib import suppress
from datetime import UTC, datetime

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Goal
from dock_gateway.storage import queries
from dock_gateway.storage.database import DATABASE_ERRORS, Database
from dock_gateway.storage.reader import AWAY, Reader
from dock_gateway.storage.rows import KEY_LIFETIME, Key, fingerprint_of
from dock_gateway.storage.waiting import WaitingEntries
from dock_gateway.storage.writer import Writer

KEY_TIMEOUT = 0.5  # Seconds to look up an idempotency key before its goal is sent.
MAX_KEYS = 10_000


class IdempotencyKeys:
    """Binds keys to goals, at once in the database if it answers.

    Args:
        database: The database.
        writer: Stores the keys with their goals, and knows whether the database answers.
        reader: Reads from the database.
        waiting: The keys that the database has not taken yet.
    """

    def __init__(self, database: Database, writer: Writer, reader: Reader, waiting: WaitingEntries) -> None:
        self._database = database
        self._writer = writer
        self._reader = reader
        self._waiting = waiting
        self._known: dict[str, Key] = {}

    async def load(self) -> None:
        """Load the newest keys, if the database answers."""
        with suppress(Unavailable):
            self._known = {key.key: key for key in await self._reader.read(queries.newest_keys, MAX_KEYS)}
        for key in self._waiting.keys.values():
            self._known.setdefault(key.key, key)

    def store_again(self) -> None:
        """Let all known keys be written, because the database has lost them."""
        for key in self._known.values():
            self._waiting.put_key(key)

    def of(self, goal: Goal, key: str) -> Key:
        """Return a key that may have been claimed for a goal; if not, bind it to the goal."""
        held = self._held(key)
        if held is None:
            held = _new_key(key, goal.goal_id, fingerprint_of(goal.action_name, goal.goal))
            self._hold(held)
        return held

    async def find(self, key: str) -> Key | None:
        """Return a key that is bound to a goal, None if there is no such key.

        Raises:
            Unavailable: The database does not answer, and this gateway does not know the key.
        """
        return self._held(key) or await self._reader.read(queries.key_of, key, timeout=KEY_TIMEOUT)

    async def claim(self, key: str, goal_id: str, fingerprint: str) -> tuple[str, str]:
        """See `History.claim`."""
        held = self._held(key)
        if held is None:
            held = _new_key(key, goal_id, fingerprint)
            if self._writer.reachable:
                try:
                    async with asyncio.timeout(KEY_TIMEOUT):
                        # Not durable: the goal, which is written next, is, and so is what was written before it.
                        held = await self._database.write(queries.claim, held, durable=False)
                except DATABASE_ERRORS as error:
                    self._writer.doubt(error)
            held = self._held(key) or held
            self._hold(held)
        return held.goal_id, held.fingerprint

    async def release(self, key: str, goal_id: str) -> None:
        """See `History.release`."""
        if not self._writer.reachable:
            raise Unavailable(AWAY, code="history_unavailable")
        try:
            async with asyncio.timeout(KEY_TIMEOUT):
                await self._database.write(queries.release, key, goal_id)
        except DATABASE_ERRORS as error:
            self._writer.doubt(error)
            raise Unavailable(AWAY, code="history_unavailable") from error
        held = self._known.get(key)
        if held is not None and held.goal_id == goal_id:
            del self._known[key]
        self._waiting.forget_key(key, goal_id)

    def _held(self, key: str) -> Key | None:
        held = self._known.get(key)
        return None if held is None or held.expired else held

    def _hold(self, key: Key) -> None:
        self._known.pop(key.key, None)
        self._known[key.key] = key
        if len(self._known) > MAX_KEYS:
            del self._known[next(iter(self._known))]


def _new_key(key: str, goal_id: str, fingerprint: str) -> Key:
    return Key(key, goal_id, fingerprint, datetime.now(UTC) + KEY_LIFETIME)
