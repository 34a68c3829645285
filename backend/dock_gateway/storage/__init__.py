"""Storage of goals, their events and idempotency keys: SQLite by default, PostgreSQL by URL, or memory."""

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.filters import GoalFilter
from dock_gateway.settings import Settings, data_file
from dock_gateway.storage.database import Incident
from dock_gateway.storage.memory import MemoryHistory
from dock_gateway.storage.protocol import (
    Acknowledgement,
    AuditStore,
    Dependency,
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
    "Dependency",
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

log = logging.getLogger(__name__)


@asynccontextmanager
async def open_history(settings: Settings) -> AsyncIterator[History]:
    """Open the history that the settings name; close it when the block ends."""
    if settings.database_url == "memory:":
        yield MemoryHistory(settings.max_goals)
        return
    _tell_of_early_files(settings)
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


def _tell_of_early_files(settings: Settings) -> None:
    """Log which files of versions before the first release, shared by all gateways of a user, are not used."""
    database = None if settings.database_url else data_file("history.db")
    spool = data_file("spool") if settings.spool_path is None else None
    for path in (database, spool):
        if path is not None and path.exists():
            log.warning("%s is from a version before the first release and is not used; move it away", path)
