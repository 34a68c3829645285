"""Requests for a WebSocket that are none, and WebSockets where there is none."""

import logging
from collections.abc import Iterable
from http import HTTPStatus

from fastapi import FastAPI, Request, WebSocket
from starlette.responses import Response
from starlette.routing import BaseRoute, WebSocketRoute

from dock_gateway.core.errors import MalformedRequest, NotFound

log = logging.getLogger(__name__)


def install_upgrades(app: FastAPI, routes: Iterable[BaseRoute]) -> None:
    """Answer a `GET` of a WebSocket's path with 426, and a WebSocket of any other path with 404.

    Must come after every other route.

    Args:
        app: The application.
        routes: Its routes.
    """
    paths = sorted({route.path for route in routes if isinstance(route, WebSocketRoute)})

    async def upgrade_required(request: Request) -> Response:
        raise MalformedRequest(
            f"{request.scope['path']} is a WebSocket, and this is a plain request: open it with a WebSocket client; a "
            "reverse proxy has to speak HTTP/1.1 to the gateway, and to pass on Upgrade and Connection "
            "(docs/configuration.md)",
            code="upgrade_required",
            status=HTTPStatus.UPGRADE_REQUIRED,
        )

    async def no_websocket(websocket: WebSocket) -> None:
        error = NotFound(f"there is no WebSocket at {websocket.scope['path'][:200]!r}; there are {', '.join(paths)}")
        log.warning("a WebSocket was refused: %s", error.detail)  # a page cannot see why
        raise error

    for path in paths:
        app.add_api_route(path, upgrade_required, include_in_schema=False)
    app.add_api_websocket_route("/{path:path}", no_websocket)
