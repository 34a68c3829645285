"""Where goals, their events and idempotency keys are kept: SQLite by default, PostgreSQL by URL, or memory."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import platformdirs

from dock_gateway.history.memory import MemoryHistory
from dock_gateway.history.protocol import (
    Acknowledgement,
    AcknowledgementStore,
    History,
    HistoryStats,
    Incident,
    Later,
    fingerprint_of,
)
from dock_gateway.history.spool import Spool
from dock_gateway.history.wanted import Wanted
from dock_gateway.settings import Settings

__all__ = [
    "Acknowledgement",
    "AcknowledgementStore",
    "History",
    "HistoryStats",
    "Incident",
    "Later",
    "MemoryHistory",
    "Wanted",
    "fingerprint_of",
    "open_history",
]


@asynccontextmanager
async def open_history(settings: Settings) -> AsyncIterator[History]:
    """Keep goals where the settings say, from now on and until the block ends."""
    if settings.database_url == "memory:":
        yield MemoryHistory(settings.max_goals)
        return
    folder = platformdirs.user_data_path("dock-gateway", appauthor=False)

    from dock_gateway.history.sql import SqlHistory  # noqa: PLC0415 - it loads SQLAlchemy

    history = SqlHistory(
        settings.database_url or f"sqlite:///{folder / 'history.db'}",
        Spool(settings.spool_path or folder / "spool"),
        max_waiting=settings.history_queue,
        max_age=settings.retention_hours * 3600,
        max_bytes=settings.retention_mb * 1_000_000,
    )
    try:
        await history.open()
        yield history
    finally:
        await history.close()
