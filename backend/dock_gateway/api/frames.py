"""The short way of an event to a WebSocket: its frame is made once and handed to each connection's transport.

The standard way (`websocket.send`) wakes a task for each connection and frames the text anew for each: 35 µs a message
and reader, where the short one takes a few. An ASGI server that offers the extension named here is asked to take it;
with any other the standard way is all there is.
"""

from typing import Protocol

from fastapi import WebSocket
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from dock_gateway.events import Event

EXTENSION = "dock_gateway.frames"


class FrameWriter(Protocol):
    """What stands in the extension."""

    def write_frame(self, frame: bytes) -> bool:
        """Write a whole frame now; False where it would have to wait, and nothing was written."""


class FramesProtocol(WebSocketsSansIOProtocol):
    """uvicorn's WebSocket connection, offering the extension. Only for connections without compression."""

    async def run_asgi(self) -> None:
        """Run the application."""
        if not self.config.ws_per_message_deflate:
            self.scope["extensions"] = {**(self.scope["extensions"] or {}), EXTENSION: {"writer": self}}
        await super().run_asgi()

    def write_frame(self, frame: bytes) -> bool:
        """Write a whole frame now; False where it would have to wait, and nothing was written."""
        if not self.writable.is_set() or self.disconnected or self.close_sent or not self.handshake_complete:
            return False
        self.transport.write(frame)
        return True


class ShortWay:
    """One connection's short way, for a `Subscriber`."""

    def __init__(self, writer: FrameWriter) -> None:
        self._write = writer.write_frame

    def __call__(self, event: Event) -> bool:
        """Send an event; False where it has to queue."""
        return self._write(event.frame)


def short_way(websocket: WebSocket) -> ShortWay | None:
    """The short way to a WebSocket, where the server offers one."""
    extension = (websocket.scope.get("extensions") or {}).get(EXTENSION)
    return None if extension is None else ShortWay(extension["writer"])
