"""Opens what knows who a request is from."""

from contextlib import AsyncExitStack

from dock_gateway.access.logins import Logins
from dock_gateway.access.tickets import Tickets
from dock_gateway.core.tasks import closed_by
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.storage.database import display


async def open_access(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the users and their logins, at a gateway or a hub, and the tickets of their streams."""
    settings = parts[Settings]
    logins = Logins(parts[History], display(settings.database))
    parts.add(Logins, closed_by(stack, logins))
    if settings.authentication:
        await logins.open()
    parts.add(Tickets, Tickets())
