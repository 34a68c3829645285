"""The fast path for events to a WebSocket, if the server offers one (`edge/websocket.py`)."""

from fastapi import WebSocket

from dock_gateway.core.event import Event
from dock_gateway.http.edge.websocket import EXTENSION, FrameWriter


class FastPath:
    """The fast path of one connection, for a `Subscriber`."""

    def __init__(self, writer: FrameWriter) -> None:
        self._write = writer.write_frame

    def __call__(self, event: Event) -> bool:
        """Send an event. Return False if it has to be queued."""
        return self._write(event.frame)


def fast_path(websocket: WebSocket) -> FastPath | None:
    """Return the fast path to a WebSocket; None if the server offers none."""
    extension = (websocket.scope.get("extensions") or {}).get(EXTENSION)
    return None if extension is None else FastPath(extension["writer"])
