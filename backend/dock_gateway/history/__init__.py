"""Where goals, their events and idempotency keys are kept: SQLite by default, PostgreSQL by URL, or memory."""

import asyncio
import importlib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import platformdirs

from dock_gateway.history.memory import MemoryHistory
from dock_gateway.history.protocol import Acknowledgement, AcknowledgementStore, History, HistoryStats, fingerprint_of
from dock_gateway.history.wanted import Wanted
from dock_gateway.settings import Settings

__all__ = [
    "Acknowledgement",
    "AcknowledgementStore",
    "History",
    "HistoryStats",
    "MemoryHistory",
    "Wanted",
    "fingerprint_of",
    "open_history",
]


@asynccontextmanager
async def open_history(settings: Settings) -> AsyncIterator[History]:
    """Keep goals where the settings say, until the block ends."""
    if settings.database_url == "memory:":
        yield MemoryHistory(settings.max_goals)
        return
    # SQLAlchemy takes half a second to load: beside the rest of the start, and not in programs that keep nothing.
    await asyncio.to_thread(importlib.import_module, "dock_gateway.history.sql")
    from dock_gateway.history.sql import SqlHistory  # noqa: PLC0415

    folder = platformdirs.user_data_path("dock-gateway", appauthor=False)
    history = SqlHistory(
        settings.database_url or f"sqlite:///{folder / 'history.db'}",
        settings.spool_path or folder / "spool",
        max_waiting=settings.history_queue,
        max_age=settings.retention_hours * 3600,
        max_bytes=settings.retention_mb * 1_000_000,
    )
    await history.open()
    try:
        yield history
    finally:
        await history.close()
