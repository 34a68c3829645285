"""Opens what lasts: the history and the record of requests."""

from contextlib import AsyncExitStack

from dock_gateway.audit.record import RequestRecord
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from dock_gateway.storage import History, open_history


async def open_storage(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the history, and the record of requests, at a gateway or a hub."""
    parts.add(History, await stack.enter_async_context(open_history(parts[Settings])))
    record = parts.add(RequestRecord, RequestRecord())
    stack.callback(record.end_period)
