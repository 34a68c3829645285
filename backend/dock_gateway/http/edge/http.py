"""HTTP/1.1 with uvicorn and h11, with limits on the request head and on unread input."""

import asyncio
import contextlib
import logging
import socket
import sys
from collections.abc import Callable, Coroutine
from http import HTTPStatus
from typing import Any

import h11
from starlette.requests import Request
from uvicorn._types import ASGISendEvent
from uvicorn.protocols.http.h11_impl import H11Protocol

from dock_gateway.core.errors import GatewayError, MalformedRequest, TooManyRequests, Unavailable
from dock_gateway.http.edge.connection import LINGER_BYTES, ConnectionTransport, Edge, GuardedConnection
from dock_gateway.http.edge.limits import Priority
from dock_gateway.http.edge.refusal import http_answer, refusal
from dock_gateway.http.edge.strict import StrictConnection
from dock_gateway.http.edge.targets import begins_stop, is_stop

# Client errors are answered but not logged: a flood would fill the disk. The gateway's own errors are logged.
log = logging.getLogger("uvicorn.error.http")
log.setLevel(logging.ERROR)
log.addFilter(lambda record: "without completing response" not in record.getMessage())  # PacedResponse says why

# The limit of the WebSocket library. Each header costs time.
MAX_HEADERS = 128
# Stops are handled before everything else, as long as they are short: at most STOP_PIECES pieces.
STOP_PIECES = 4
# Seconds that a request costs in addition to reading it: routing, validation, response.
REQUEST_COST = 0.001
# Seconds at shutdown for the client of an idle connection to confirm the end of TLS. Many do not read meanwhile.
END_OF_TLS = 0.3
# Seconds that a piece of a body costs in addition to reading it: the route wakes up and takes it.
PIECE_COST = 0.0001

EXTENSION = "dock_gateway.socket"
UNANSWERED = Unavailable(
    "the gateway shut down before it had answered; what was asked for may have been done", code="shutting_down"
)
Send = Callable[[ASGISendEvent], Coroutine[Any, Any, None]]


def limit_unsent(request: Request, size: int) -> None:
    """Let the system hold at most so many unsent bytes for a client, so that a slow one gets what is new.

    Without the limit the system would hold seconds of old pictures.
    """
    extension = (request.scope.get("extensions") or {}).get(EXTENSION)
    if extension is not None:
        with contextlib.suppress(OSError, ValueError):  # the client has left, and its socket is closed
            extension["socket"].setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, size)


def create_connection(edge: Edge, **options: Any) -> GuardedConnection:
    """Create a connection. The factory for uvicorn's option `http`."""
    return GuardedConnection(edge, HttpProtocol(edge, **options))


def host_of(address: tuple[str, int | None] | None) -> bytes:
    """Return what a client would name a server with this address."""
    host, port = address or ("localhost", None)
    name = f"[{host}]" if ":" in host else host
    return (name if port is None else f"{name}:{port}").encode()


class HttpProtocol(H11Protocol):
    """The HTTP protocol of a connection, until the client asks for a WebSocket."""

    transport: ConnectionTransport  # type: ignore[assignment]
    conn: StrictConnection

    def __init__(self, edge: Edge, **options: Any) -> None:
        super().__init__(**options)
        self.logger = log
        self.conn = StrictConnection(edge.settings.max_header_bytes)
        self._edge = edge
        self._deadline: asyncio.TimerHandle | None = None  # for the rest of incomplete input
        self._unwanted = 0  # body bytes received after the answer
        self._refused = False
        self._answered_one = False
        self._stop_pieces = 0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for the first request. A gateway with TLS answers none without."""
        super().connection_made(transport)
        self.conn.host = host_of(self.server)
        if self._edge.settings.tls and not self._secure:
            self._answer(MalformedRequest("this port speaks TLS: use https:// or wss://", code="tls_required"))
        else:
            self._watch(incomplete=True)

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the deadline."""
        self._watch(incomplete=False)
        super().connection_lost(exc)

    def shutdown(self) -> None:
        """Close the connection once the current answer has been sent."""
        if self._refused:
            self.transport.abort()
        else:
            super().shutdown()
            if self._secure and self.transport.is_closing():
                self.loop.call_later(END_OF_TLS, self.transport.abort)

    @property
    def _secure(self) -> bool:
        return self.scheme == "https"

    # Input.

    def is_urgent(self, data: bytes) -> bool:
        """Whether this piece begins or continues a stop."""
        if self.conn.their_state is h11.IDLE:
            self._stop_pieces = STOP_PIECES if begins_stop(data) else 0
        self._stop_pieces -= 1
        return self._stop_pieces >= 0

    @property
    def priority(self) -> Priority:
        """The priority of the client's request."""
        if self.cycle is None or self.cycle.response_complete:
            return Priority.IDLE
        return Priority.STOP if is_stop(self.scope["method"], self.scope["path"]) else Priority.REQUEST

    @property
    def unread(self) -> bool:
        """Whether the client is still sending input that will not be read."""
        answered = self.cycle is None or self.cycle.response_complete
        return self._refused or (answered and self.conn.their_state is h11.SEND_BODY)

    @property
    def receiving(self) -> bool:
        """Whether a request has arrived only in part."""
        sending = self.cycle is not None and self.cycle.more_body and not self.cycle.response_complete
        return self._has_begun or sending

    @property
    def _has_begun(self) -> bool:
        return self.conn.their_state is h11.IDLE and bool(self.conn.trailing_data[0])

    def refuse_input(self) -> None:
        """Tell the client that its request cannot be accepted now."""
        self._answer(TooManyRequests("too many clients are sending too much at the same time", code="too_much_input"))

    def data_received(self, data: bytes) -> None:
        """Read a piece."""
        if self.conn.their_state is h11.IDLE and self._count_headers(data) > MAX_HEADERS:
            self._refuse(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, f"the request has more than {MAX_HEADERS} headers")
            return
        if self.unread:
            self._unwanted += len(data)
            if self._unwanted > LINGER_BYTES:
                self.transport.abort()
                return
        if self.receiving:
            self._edge.scheduler.charge(PIECE_COST)
        super().data_received(data)

    def _count_headers(self, data: bytes) -> int:
        head = (self.conn.trailing_data[0] + data).lstrip(b"\r\n")
        end = head.find(b"\n\r\n")
        return head.count(b"\n", 0, end if end >= 0 else len(head))

    def on_response_complete(self) -> None:
        """Continue with the next request, in turn with those of other connections."""
        self._answered_one = True
        super().on_response_complete()
        self._answered_one = False

    def handle_events(self) -> None:
        """Handle the parsed events."""
        if self._answered_one:
            if self.conn.trailing_data[0]:
                self.transport.connection.enqueue()
            return
        before = self.cycle
        super().handle_events()
        if self.cycle is not before:
            self.scope["extensions"] = {EXTENSION: {"socket": self.transport.get_extra_info("socket")}}
            self._edge.scheduler.charge(REQUEST_COST)
            self.cycle.send = self._in_turn(self.cycle.send)  # type: ignore[method-assign, assignment]
            self.cycle.send_500_response = self._end_unanswered  # type: ignore[method-assign]
            # A careless proxy takes a connection on which it has seen a WebSocket's upgrade for a tunnel, whatever the
            # answer: its client could send any request through it.
            if not self.transport.connection.regular or super()._get_upgrade() == b"websocket":
                self.cycle.keep_alive = False
        if self.transport.connection.protocol is self:
            self._watch(incomplete=self._has_begun or self.unread)

    async def _end_unanswered(self) -> None:
        """Answer a request that is canceled at shutdown. For all exceptions, the application has an answer."""
        self._answer(UNANSWERED)

    def _in_turn(self, send: Send) -> Send:
        """Return a `send` that gives way after each piece of a streamed answer."""

        async def send_and_give_way(message: ASGISendEvent) -> None:
            await send(message)
            if message["type"] == "http.response.body" and message.get("more_body"):
                await self._edge.scheduler.sent(len(message["body"]))

        return send_and_give_way

    def _watch(self, *, incomplete: bool) -> None:
        if incomplete and self._deadline is None and not self._refused:
            self._deadline = self.loop.call_later(self._edge.settings.header_timeout, self._too_late)
        elif not incomplete and self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _too_late(self) -> None:
        self._deadline = None
        if self._has_begun:
            seconds = f"{self._edge.settings.header_timeout:g} s"
            self._refuse(HTTPStatus.REQUEST_TIMEOUT, f"the head of the request did not arrive within {seconds}")
        else:
            self.transport.abort()

    # Upgrades and invalid requests.

    def _get_upgrade(self) -> bytes | None:
        """Return the requested upgrade if it is a WebSocket by GET. Others may be ignored (RFC 9110, 7.8).

        One in HTTP/1.0 must be: what sends it is a proxy that would not pass the WebSocket on.
        """
        upgrade = super()._get_upgrade()
        is_get = self.scope["method"] == "GET" and self.scope["http_version"] != "1.0"
        return upgrade if upgrade == b"websocket" and is_get else None

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection to the WebSocket protocol, unless it is in the reserve."""
        self._watch(incomplete=False)
        if self.transport.connection.regular:
            super().handle_websocket_upgrade(event)
        else:
            detail = "there are too many connections for another WebSocket"
            self._answer(TooManyRequests(detail, code="too_many_connections"))

    def send_400_response(self, msg: str) -> None:
        """Answer with the error. Called while h11's exception is being handled."""
        error = sys.exception()
        status = HTTPStatus(getattr(error, "error_status_hint", HTTPStatus.BAD_REQUEST))
        if status == HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE:
            msg = f"the head of the request is larger than {self._edge.settings.max_header_bytes} bytes"
        else:
            msg = f"the request is not HTTP/1.1: {error}"
        self._refuse(status, msg)

    def _refuse(self, status: HTTPStatus, detail: str) -> None:
        self._answer(refusal(status, detail))

    def _answer(self, error: GatewayError) -> None:
        self._refused = True
        self._watch(incomplete=False)
        if self.cycle is not None and not self.cycle.response_complete:  # the body was invalid
            if self.cycle.response_started:
                self.transport.abort()
                return
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        self.transport.write(http_answer(error, tls=self._secure))
        self.transport.close()
