"""An audit log in a list, and examples of entries. As a program: a process that appends, and can be killed."""

import asyncio
import itertools
import sys
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from dock_gateway.access.logins import Logins
from dock_gateway.audit.record import RequestRecord
from dock_gateway.audit.subjects import Subjects
from dock_gateway.core.audit import AuditEntry
from dock_gateway.core.errors import Unavailable
from dock_gateway.extension import Installed, extensions
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from dock_gateway.storage.history import open_database
from tests.support.history import HistoryInMemory, open_at
from tests.support.waiting import until

NOON = datetime(2026, 11, 21, 12, tzinfo=UTC)


class AuditList:
    """Takes entries, as `RequestRecord` does."""

    def __init__(self) -> None:
        self.entries: list[AuditEntry] = []
        self.stored_first: list[str] = []

    def record(self, entry: AuditEntry) -> None:
        self.entries.append(entry)

    async def store(self, entry: AuditEntry) -> None:
        self.entries.append(entry)
        self.stored_first.append(entry.what)


def audit_parts() -> dict[type, Any]:
    """The parts of a gateway that are needed to make its routes, and to allow and record a request without a login."""
    settings = Settings()
    return {
        Installed: extensions(),
        RequestRecord: AuditList(),
        Subjects: Subjects(settings, lambda _: None, list),
        Logins: Logins(HistoryInMemory()),
        Quotas: Quotas(settings),
    }


def make_entry(number: int, **fields: Any) -> AuditEntry:
    """An entry; the number orders them by time and makes them differ."""
    usual: dict[str, Any] = {
        "id": f"{number:032x}",
        "acted_at": NOON + timedelta(seconds=number),
        "principal": "ada",
        "role": "admin",
        "token_id": "0123456789abcdef",
        "client": "192.0.2.1",
        "request_id": None,
        "what": "dock",
        "robot": "/robot1",
        "action_name": "/robot1/connect_to_charging_dock",
        "goal_id": None,
        "subject": None,
        "status": 202,
        "code": None,
    }
    return AuditEntry(**usual | fields)


async def append_on(url: str, folder: str, first: int) -> None:
    """Append entries one after the other, and say so, until killed."""
    async with open_at(url, Path(folder)) as history:
        await until(lambda: history.stats().database_reachable)
        for number in itertools.count(first):
            try:
                await history.audit.append([make_entry(number)])
            except Unavailable:
                continue
            print("stored", number, flush=True)


async def change(url: str, work: Callable[[sa.Connection], object]) -> None:
    """Do something to the tables, as somebody with access to the database can."""
    database = open_database(url)
    try:
        await database.prepare()
        await database.write(work)
    finally:
        await database.close()


def statement(text: str) -> Callable[[sa.Connection], object]:
    """What runs a statement of SQL, for `change`."""
    return lambda connection: connection.execute(sa.text(text))


if __name__ == "__main__":
    asyncio.run(append_on(sys.argv[1], sys.argv[2], int(sys.argv[3])))
