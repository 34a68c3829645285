"""Storage of goals, their events and idempotency keys: SQLite by default, PostgreSQL by URL, or memory."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from dock_gateway.core.filters import GoalFilter
from dock_gateway.settings import Settings, data_file
from dock_gateway.storage.database import Incident
from dock_gateway.storage.handover import take_over_database, take_over_spool
from dock_gateway.storage.memory import MemoryHistory
from dock_gateway.storage.protocol import (
    Acknowledgement,
    AuditStore,
    Beside,
    Entries,
    EntryT,
    GoalNotes,
    History,
    HistoryStats,
    LaterEvents,
    Note,
    RobotLabel,
    fingerprint_of,
)
from dock_gateway.storage.retention import Limits
from dock_gateway.storage.spool import AuditSpool, Spool
from dock_gateway.storage.sql import SqlHistory

__all__ = [
    "Acknowledgement",
    "AuditSpool",
    "AuditStore",
    "Beside",
    "Entries",
    "EntryT",
    "GoalFilter",
    "GoalNotes",
    "History",
    "HistoryStats",
    "Incident",
    "LaterEvents",
    "MemoryHistory",
    "Note",
    "RobotLabel",
    "fingerprint_of",
    "open_history",
]


@asynccontextmanager
async def open_history(settings: Settings) -> AsyncIterator[History]:
    """Open the history that the settings name; close it when the block ends."""
    if settings.database_url == "memory:":
        yield MemoryHistory(settings.max_goals)
        return
    await asyncio.to_thread(_take_over, settings)
    history = SqlHistory(
        settings.database,
        Spool(settings.spool_folder),
        max_waiting=settings.history_queue,
        limits=Limits(
            event_age=settings.retention_hours * 3600,
            event_bytes=settings.retention_mb * 1_000_000,
            goal_age=settings.goal_retention_days * 86_400,
            goal_bytes=settings.goal_retention_mb * 1_000_000,
            audit_age=settings.audit_retention_days * 86_400,
            audit_entries=settings.audit_max_entries,
        ),
    )
    try:
        await history.open()
        yield history
    finally:
        await history.close()


def _take_over(settings: Settings) -> None:
    """Take over the files that all gateways of a user once shared, where this gateway uses the same folder."""
    if not settings.database_url:
        take_over_database(data_file("history.db"), Path(settings.database.removeprefix("sqlite:///")))
    if settings.spool_path is None:
        take_over_spool(data_file("spool"), settings.spool_folder)
