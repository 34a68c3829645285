"""A port on which `/` is `/rosbridge`, as clients of rosbridge expect it: `ws://robot:9090`."""

from starlette.types import ASGIApp, Receive, Scope, Send

PATH = "/rosbridge"


class RosbridgePort:
    """ASGI middleware that answers WebSockets of `/` on this port at `/rosbridge`.

    So does one whose upgrade a proxy has not passed on: its answer says so (426). A browser gets the dashboard.

    Args:
        app: The application.
        port: The port.
    """

    def __init__(self, app: ASGIApp, port: int) -> None:
        self._app = app
        self._port = port

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on."""
        if _is_meant(scope) and scope["path"] in ("/", "") and scope["server"] and scope["server"][1] == self._port:
            scope = {**scope, "path": PATH, "raw_path": PATH.encode()}
        await self._app(scope, receive, send)


def _is_meant(scope: Scope) -> bool:
    """Return whether a client asks for a WebSocket."""
    if scope["type"] == "http":
        return any(name == b"sec-websocket-key" for name, _ in scope["headers"])
    return bool(scope["type"] == "websocket")
