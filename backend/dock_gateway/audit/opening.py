"""Opens what lasts: the history and the record of requests."""

from contextlib import AsyncExitStack

from dock_gateway.audit.log import AuditLog
from dock_gateway.core.tasks import closed_by
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from dock_gateway.storage import AuditSpool, History, open_history


async def open_storage(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the history, and the record of requests, at a gateway or a hub."""
    settings = parts[Settings]
    history = parts.add(History, await stack.enter_async_context(open_history(settings)))
    spool = None if settings.database_url == "memory:" else AuditSpool(settings.spool_folder / "audit")
    audit = parts.add(AuditLog, closed_by(stack, AuditLog(history.audit, spool)))
    await audit.open()
