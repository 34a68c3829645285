"""Ports on which `/` is another path, as clients of a protocol expect it: `ws://robot:9090` for rosbridge."""

from collections.abc import Mapping

from starlette.types import ASGIApp, Receive, Send
from starlette.types import Scope as ConnectionScope


class OwnPorts:
    """ASGI middleware that answers WebSockets of `/` at another path, by the port that they come to.

    So does one whose upgrade a proxy has not passed on: its answer says so (426). A browser gets the dashboard.

    Args:
        app: The application.
        paths: The paths, by port.
    """

    def __init__(self, app: ASGIApp, paths: Mapping[int, str]) -> None:
        self._app = app
        self._paths = paths

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Pass the request on."""
        if _is_meant(scope) and scope["path"] in ("/", "") and scope["server"]:
            path = self._paths.get(scope["server"][1], scope["path"])
            scope = {**scope, "path": path, "raw_path": path.encode()}
        await self._app(scope, receive, send)


def _is_meant(scope: ConnectionScope) -> bool:
    """Return whether a client asks for a WebSocket."""
    if scope["type"] == "http":
        return any(name == b"sec-websocket-key" for name, _ in scope["headers"])
    return bool(scope["type"] == "websocket")
