"""One TCP connection of either protocol: its limits, its input in pieces, and its end."""

import asyncio
import logging
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol, cast

from dock_gateway.http.edge.limits import ConnectionLimits, Priority
from dock_gateway.http.edge.scheduler import TurnScheduler
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

# Bytes of further input that are discarded after an answer, so that the answer reaches a client that still sends.
LINGER_BYTES = 64_000_000
# Bytes that wait in a connection until its protocol stops writing. TLS would hold eight times as many.
WRITE_BUFFER = 65_536
# Maximum incomplete input of all clients together, in bodies of the maximum size.
UNFINISHED_BODIES = 8
# The same for all clients at one address.
UNFINISHED_OF_ADDRESS = 6
# Beyond these limits, a client that has sent more than this number of bytes is refused; small requests still pass.
SHARE = 16_384
# Seconds that a reserve connection has for its answer, in addition to the timeout of the request head.
ANSWER_WITHIN = 2.0


@dataclass
class Edge:
    """State shared by all connections.

    Attributes:
        unfinished: Bytes received of incomplete requests and messages, by the addresses of their clients.
    """

    settings: Settings
    limits: ConnectionLimits
    scheduler: TurnScheduler = field(default_factory=TurnScheduler)
    unfinished: Counter[str] = field(default_factory=Counter)


class InnerProtocol(Protocol):
    """One of uvicorn's protocols, as extended by a subclass in this package."""

    @property
    def priority(self) -> Priority:
        """The priority of the client's request."""

    @property
    def unread(self) -> bool:
        """Whether the client is still sending input that will not be read."""

    @property
    def receiving(self) -> bool:
        """Whether a request or message has arrived only in part."""

    def refuse_input(self) -> None:
        """Tell the client that its request or message cannot be accepted now."""

    def is_urgent(self, data: bytes) -> bool:
        """Whether this piece must be handled before everything else."""

    def data_received(self, data: bytes) -> None:
        """Read a piece."""

    def handle_events(self) -> None:
        """Handle the parsed events."""

    def connection_made(self, transport: asyncio.Transport) -> None:
        """Handle an opened connection."""

    def connection_lost(self, exc: Exception | None) -> None:
        """Handle a closed connection."""

    def pause_writing(self) -> None:
        """Stop writing: the client reads too slowly."""

    def resume_writing(self) -> None:
        """Resume writing: the client has caught up."""


class GuardedConnection(asyncio.BufferedProtocol):
    """Sits between a transport and uvicorn's protocols: limits their input, and lingers before closing.

    Args:
        edge: State shared by all connections.
        protocol: The initial protocol, HTTP.
    """

    def __init__(self, edge: Edge, protocol: InnerProtocol) -> None:
        self.address = ""
        self.regular = False
        self.protocol = protocol
        self.edge = edge
        self._transport: asyncio.Transport = None  # type: ignore[assignment]
        self._pending = b""  # received but not handled yet
        self._unfinished = 0  # bytes received of an incomplete request or message
        self._queued = False
        self._paused = False  # by the protocol
        self._lingering = 0  # bytes still accepted while lingering; 0: not lingering
        self._timer: asyncio.TimerHandle | None = None
        self._left_to_write = -1

    # Opening and closing.

    def arrive(self, transport: asyncio.Transport) -> None:
        """Apply the limits: before the TLS handshake, if there is one."""
        self._transport = transport
        self.address = (transport.get_extra_info("peername") or ("",))[0]
        self.regular = self.edge.limits.admit(self)
        if not self.regular:
            self._abort_in(self.edge.settings.header_timeout + ANSWER_WITHIN)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Hand the connection to the protocol."""
        opened = cast("asyncio.Transport", transport)
        if self._transport is None:
            self.arrive(opened)
        self._transport = opened
        opened.set_write_buffer_limits(high=WRITE_BUFFER)
        self.protocol.connection_made(cast("asyncio.Transport", ConnectionTransport(self, opened)))

    def connection_lost(self, exc: Exception | None) -> None:
        """Notify the limits and the protocol."""
        self.depart()
        self._count_unfinished(-self._unfinished)
        self._pending = b""
        self.protocol.connection_lost(exc)

    def depart(self) -> None:
        """Notify the limits."""
        self.edge.limits.release(self)
        if self._timer is not None:
            self._timer.cancel()

    @property
    def priority(self) -> Priority:
        """The priority of the client's request."""
        return self.protocol.priority

    @property
    def stuck(self) -> bool:
        """Whether it is closing, and the client has read none of its pending output since the last check."""
        before, self._left_to_write = self._left_to_write, self._transport.get_write_buffer_size()
        return self._transport.is_closing() and before == self._left_to_write

    def abort(self) -> None:
        """Close it at once."""
        self._transport.abort()

    def close(self) -> None:
        """Close it once everything has been sent.

        A client that is still sending gets time to read the answer, and its input is discarded: closing a socket with
        unread input resets the connection, and the client loses the answer.
        """
        if self._lingering:
            return
        if not self.protocol.unread or self._transport.is_closing():
            self._transport.close()
            return
        self._lingering = LINGER_BYTES
        self._pending = b""
        self._count_unfinished(-self._unfinished)
        if self._transport.can_write_eof():  # TLS cannot
            self._transport.write_eof()
        self._arrange_reading()
        self._abort_in(self.edge.settings.header_timeout)

    @property
    def closing(self) -> bool:
        """Whether the connection is closing or lingering."""
        return bool(self._lingering) or self._transport.is_closing()

    def _abort_in(self, seconds: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(seconds, self.abort)

    # Input.

    def get_buffer(self, sizehint: int) -> memoryview:
        """Return the buffer for the next piece."""
        return self.edge.scheduler.buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Handle a piece, now or in turn."""
        data = bytes(self.edge.scheduler.buffer[:nbytes])
        urgent = not self._pending and not self._lingering and self.protocol.is_urgent(data)
        self._pending += data
        if not self._queued and (urgent or self.edge.scheduler.free):
            self.edge.scheduler.run(self._handle)
        else:
            self.enqueue()

    def enqueue(self) -> None:
        """Queue the pending input, and pause reading until it is handled."""
        if not self._queued:
            self._queued = True
            self._arrange_reading()
            self.edge.scheduler.enqueue(self._handle_in_turn)

    def _handle_in_turn(self) -> None:
        self._queued = False
        self._handle()
        self._arrange_reading()

    def _handle(self) -> None:
        data, self._pending = self._pending, b""
        if self._transport.is_closing():
            return
        if self._lingering:
            self._lingering -= len(data)
            if self._lingering <= 0:
                self._transport.abort()
            return
        try:
            if data:
                self.protocol.data_received(data)
                self._limit_unfinished(len(data))
            else:
                self.protocol.handle_events()
        except Exception:
            log.exception("a connection broke")
            self._transport.abort()

    def _limit_unfinished(self, size: int) -> None:
        receiving = self.protocol.receiving and not self.closing
        self._count_unfinished(size if receiving else -self._unfinished)
        body, unfinished = self.edge.settings.max_body_bytes, self.edge.unfinished
        if self._unfinished > SHARE and (
            unfinished[self.address] > UNFINISHED_OF_ADDRESS * body or unfinished.total() > UNFINISHED_BODIES * body
        ):
            self.protocol.refuse_input()

    def _count_unfinished(self, size: int) -> None:
        self._unfinished += size
        self.edge.unfinished[self.address] += size
        if not self.edge.unfinished[self.address]:
            del self.edge.unfinished[self.address]

    def pause_reading(self) -> None:
        """Stop reading until the protocol wants more."""
        self._paused = True
        self._arrange_reading()

    def resume_reading(self) -> None:
        """Resume reading."""
        self._paused = False
        self._arrange_reading()

    def _arrange_reading(self) -> None:
        if self._transport.is_closing():
            return
        if self._queued or (self._paused and not self._lingering):
            self._transport.pause_reading()
        else:
            self._transport.resume_reading()

    # Output.

    def pause_writing(self) -> None:
        """Stop writing: the client reads too slowly."""
        self.protocol.pause_writing()

    def resume_writing(self) -> None:
        """Resume writing: the client has caught up."""
        self.protocol.resume_writing()


class ConnectionTransport:
    """The transport as the protocols see it."""

    def __init__(self, connection: GuardedConnection, transport: asyncio.Transport) -> None:
        self.connection = connection
        self._transport = transport
        self.write: Callable[[bytes], None] = transport.write
        self.close = connection.close
        self.abort = connection.abort
        self.pause_reading = connection.pause_reading
        self.resume_reading = connection.resume_reading

    def is_closing(self) -> bool:
        """Whether the connection is closing or lingering."""
        return self.connection.closing

    def set_protocol(self, protocol: InnerProtocol) -> None:
        """Switch to another protocol."""
        self.connection.protocol = protocol

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)
