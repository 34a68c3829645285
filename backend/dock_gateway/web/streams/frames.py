"""The short way of an event to a WebSocket, where the server offers one (`edge/websocket.py`)."""

from fastapi import WebSocket

from dock_gateway.core.event import Event
from dock_gateway.web.edge.websocket import EXTENSION, FrameWriter


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
