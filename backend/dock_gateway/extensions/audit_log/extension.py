"""Stores the record of requests where changes to it can be seen."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.audit.record import RequestRecord
from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.extensions.audit_log.log import AuditLog
from dock_gateway.extensions.audit_log.routes import router
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from dock_gateway.storage import AuditSpool, History


@asynccontextmanager
async def open_audit_log(parts: Parts) -> AsyncIterator[AuditLog]:
    """Store the record of requests."""
    settings = parts[Settings]
    spool = None if settings.database_url == "memory:" else AuditSpool(settings.spool_folder / "audit")
    async with closing(AuditLog(parts[RequestRecord], parts[History].audit, spool)) as log:
        await log.open()
        yield log


extension = Extension("audit_log", open_audit_log, routes=lambda _: (router,))
