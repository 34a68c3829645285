"""Storage of goals, their events and idempotency keys: SQLite by default, PostgreSQL by URL, or SQLite in memory."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from dock_gateway.core.filters import GoalFilter
from dock_gateway.settings import Settings
from dock_gateway.storage.audit import AuditStore
from dock_gateway.storage.database import Incident
from dock_gateway.storage.entries import Dependency, Entries, EntryT
from dock_gateway.storage.event_reader import LaterEvents
from dock_gateway.storage.history import History, HistoryStats
from dock_gateway.storage.notes import GoalNotes, Note
from dock_gateway.storage.retention import Limits, in_memory
from dock_gateway.storage.rows import fingerprint_of
from dock_gateway.storage.spool import AuditSpool, Spool

__all__ = [
    "AuditSpool",
    "AuditStore",
    "Dependency",
    "Entries",
    "EntryT",
    "GoalFilter",
    "GoalNotes",
    "History",
    "HistoryStats",
    "Incident",
    "LaterEvents",
    "Note",
    "fingerprint_of",
    "open_history",
]


@asynccontextmanager
async def open_history(settings: Settings) -> AsyncIterator[History]:
    """Open the history that the settings name; close it when the block ends."""
    limits = Limits(
        event_age=settings.feedback_retention_days * 86_400,
        event_bytes=settings.feedback_retention_mb * 1_000_000,
        goal_age=settings.goal_retention_days * 86_400,
        goal_bytes=settings.goal_retention_mb * 1_000_000,
        audit_age=settings.audit_retention_days * 86_400,
        audit_entries=settings.audit_max_entries,
    )
    folder: Path | None = settings.spool_folder
    if settings.database == "memory:":
        limits, folder = in_memory(limits, settings.memory_max_goals), None
    history = History(settings.database, Spool(folder), max_waiting=settings.history_queue, limits=limits)
    try:
        await history.open()
        yield history
    finally:
        await history.close()
