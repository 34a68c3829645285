"""A port on which `/` is `/rosbridge`, as clients of rosbridge expect it: `ws://robot:9090`."""

from starlette.types import ASGIApp, Receive, Scope, Send

PATH = "/rosbridge"


class RosbridgePort:
    """ASGI middleware that answers WebSockets of `/` on this port at `/rosbridge`.

    Args:
        app: The application.
        port: The port.
    """

    def __init__(self, app: ASGIApp, port: int) -> None:
        self._app = app
        self._port = port

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on."""
        root = scope["type"] == "websocket" and scope["path"] in ("/", "")
        if root and scope["server"] and scope["server"][1] == self._port:
            scope = {**scope, "path": PATH, "raw_path": PATH.encode()}
        await self._app(scope, receive, send)
