"""WebSockets with uvicorn and websockets, with limits on client input and a fast path for writing.

On the fast path, an event's frame is built once and written to each connection's transport. The standard path
(`websocket.send`) wakes a task and frames the text again for each connection: 35 µs per message and reader, where the
fast path takes a few. Streams use it if a connection offers it.
"""

import asyncio
import logging
from http import HTTPStatus
from time import monotonic
from typing import Any

from starlette.websockets import WebSocket
from uvicorn._types import ASGIReceiveEvent, ASGISendEvent
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.datastructures import Headers
from websockets.frames import CloseCode
from websockets.http11 import Response
from websockets.server import ServerProtocol
from websockets.typing import StatusLike

from dock_gateway.core.fanout import FrameWriter
from dock_gateway.core.goal import encode
from dock_gateway.http.edge.connection import ConnectionTransport, Edge
from dock_gateway.http.edge.limits import Priority
from dock_gateway.http.edge.refusal import refusal, refusal_headers

# Client errors are answered but not logged: a flood would fill the disk.
log = logging.getLogger("uvicorn.error.websocket")
log.addFilter(lambda record: "Invalid UTF-8" not in record.getMessage())

EXTENSION = "dock_gateway.frames"
# The maximum number of frames per message.
MAX_FRAGMENTS = 1_000
# Seconds that a frame costs in addition to reading it: a command, or a pong.
FRAME_COST = 0.0001


def frame_writer(websocket: WebSocket) -> FrameWriter | None:
    """Return the fast path to a WebSocket; None if the server offers none."""
    extension = (websocket.scope.get("extensions") or {}).get(EXTENSION)
    return None if extension is None else extension["writer"]


class Handshake(ServerProtocol):
    """A connection of `websockets` that refuses handshakes in the gateway's error format."""

    tls = False

    def reject(self, status: StatusLike, text: str) -> Response:
        """Return the answer to a refused handshake."""
        status = HTTPStatus(status)
        body = encode(refusal(status, text.partition("\n")[0]).problem())
        return Response(status, status.phrase, Headers(refusal_headers(body, tls=self.tls)), body)


class Rate:
    """A limit on an amount per second."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._second = 0
        self._used = 0

    def exceeded(self, amount: int) -> bool:
        """Count an amount. Return whether it exceeds the limit."""
        second = int(monotonic())
        if second != self._second:
            self._second, self._used = second, 0
        self._used += amount
        return self._used > self._limit


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """The WebSocket protocol of a connection, without compression."""

    transport: ConnectionTransport  # type: ignore[assignment]
    priority = Priority.REQUEST

    def __init__(self, edge: Edge, **options: Any) -> None:
        super().__init__(**options)
        self.logger = log
        self.conn = Handshake(max_size=self.config.ws_max_size, logger=log)
        self.conn.tls = edge.settings.tls
        self._edge = edge
        self._frames = Rate(edge.settings.max_frames_per_second)
        self._bytes = Rate(edge.settings.max_frame_bytes_per_second)
        self._failed = False
        self._deadline: asyncio.TimerHandle | None = None  # for the rest of a message
        self._last_pong = b""  # not sent yet

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the deadline."""
        self._watch(incomplete=False)
        super().connection_lost(exc)

    # Input.

    def is_urgent(self, data: bytes) -> bool:
        """Return False: frames are masked, so a stop cannot be recognized."""
        return False

    @property
    def unread(self) -> bool:
        """Whether the client is still sending input that will not be read."""
        return self._failed

    @property
    def receiving(self) -> bool:
        """Whether a message has arrived only in part."""
        return not self._failed and bool(self.frames or self.conn.reader.buffer)

    def refuse_input(self) -> None:
        """Tell the client that its message cannot be accepted now."""
        self._fail(CloseCode.TRY_AGAIN_LATER, "too many clients are sending too much at the same time")

    def data_received(self, data: bytes) -> None:
        """Read a piece."""
        if self._bytes.exceeded(len(data)):
            self._fail(CloseCode.POLICY_VIOLATION, "too many bytes a second")
            return
        super().data_received(data)
        if self.conn.handshake_exc is not None and not self.handshake_initiated:
            self._refuse_handshake()
        self._watch(incomplete=self.receiving)

    def handle_events(self) -> None:
        """Handle the parsed events."""
        frames = len(self.conn.events)
        self._edge.scheduler.charge(frames * FRAME_COST)
        if self._frames.exceeded(frames):
            self.conn.events_received()
            self._fail(CloseCode.POLICY_VIOLATION, "too many frames a second")
            return
        super().handle_events()
        if len(self.frames) > MAX_FRAGMENTS:
            self._fail(CloseCode.MESSAGE_TOO_BIG, f"a message in more than {MAX_FRAGMENTS} frames")

    def handle_ping(self) -> None:
        """Answer a ping. If the client does not read, answer only the last one, later (RFC 6455, 5.5.3)."""
        if self.writable.is_set():
            super().handle_ping()
        elif pongs := self.conn.data_to_send():
            self._last_pong = pongs[-1]

    def resume_writing(self) -> None:
        """Resume writing, and send the pong that had to wait."""
        super().resume_writing()
        pong, self._last_pong = self._last_pong, b""
        if pong and not self.close_sent:
            self.transport.write(pong)

    async def receive(self) -> ASGIReceiveEvent:
        """Return the next message. Takes one per turn of the loop, however many have arrived."""
        message = await super().receive()
        if not self.queue.empty():
            await asyncio.sleep(0)
        return message

    def _watch(self, *, incomplete: bool) -> None:
        if incomplete and self._deadline is None:
            self._deadline = self.loop.call_later(self._edge.settings.body_timeout, self._too_late)
        elif not incomplete and self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _too_late(self) -> None:
        self._fail(CloseCode.POLICY_VIOLATION, "the rest of a message did not arrive in time")

    # Errors.

    def _fail(self, code: CloseCode, reason: str) -> None:
        self.conn.fail(code, reason)
        self.handle_parser_exception()

    def handle_parser_exception(self) -> None:
        """Send the reason for closing, if that is still possible."""
        self._watch(incomplete=False)
        self._failed = True
        if self.conn.close_sent is None:
            self.transport.abort()
        else:
            super().handle_parser_exception()

    def _refuse_handshake(self) -> None:
        self._failed = self.close_sent = self.handshake_complete = True
        answer = b"".join(self.conn.data_to_send())
        self.transport.write(answer or self.conn.reject(HTTPStatus.BAD_REQUEST, "not a handshake").serialize())
        self.transport.close()

    # Output.

    async def send(self, message: ASGISendEvent) -> None:
        """Send a message of the application, then give way. A client that was cut off counts as disconnected.

        It may have a whole `frame` (`EXTENSION`), which needs no encoding for each client.
        """
        frame: Any = message.get("frame")
        try:
            if frame is None:
                await super().send(message)
            else:
                await self.writable.wait()
                if not self.write_frame(frame):
                    raise ClientDisconnected
            data: Any = frame or message.get("text") or message.get("bytes") or b""
            await self._edge.scheduler.sent(len(data))
            if message["type"] == "websocket.http.response.body" and self.close_sent:
                self.handshake_complete = True  # refused, which is no error of the application
        except RuntimeError:
            if self._failed or self.transport.is_closing():
                raise ClientDisconnected from None
            raise

    async def run_asgi(self) -> None:
        """Run the application, and offer it the extension."""
        self.scope["extensions"] = {**(self.scope["extensions"] or {}), EXTENSION: {"writer": self}}
        await super().run_asgi()

    def write_frame(self, frame: bytes) -> bool:
        """Write a whole frame now. Return False, without writing, if it would have to wait."""
        if not self.writable.is_set() or self.disconnected or self.close_sent or not self.handshake_complete:
            return False
        self.transport.write(frame)
        return True
