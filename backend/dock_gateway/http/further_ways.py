"""Ways to the application besides the ports, such as a tunnel. An extension adds its own to them."""

from collections.abc import Mapping
from typing import Any, Protocol

from starlette.types import ASGIApp

from dock_gateway.core.listeners import Hooks


class FurtherWay(Protocol):
    """A way to the application."""

    async def open(self, app: ASGIApp, state: Mapping[str, Any]) -> None:
        """Open it, once the ports are listened on.

        Args:
            app: The application.
            state: What its requests have as their state.
        """

    async def leave(self) -> None:
        """Say that it ends soon. Streams go on."""

    async def close(self) -> None:
        """End it."""

    def document(self) -> dict[str, Any]:
        """Return its state, as `/healthz` shows it."""


class FurtherWays(Hooks[FurtherWay]):
    """The ways, in the order in which they are opened."""
