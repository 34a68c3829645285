"""One TCP connection, whichever protocol it speaks: its limits, its input in pieces, and its end."""

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol, cast

from dock_gateway.settings import Settings
from dock_gateway.web.edge.limits import ConnectionLimits, Priority
from dock_gateway.web.edge.scheduler import InputScheduler

log = logging.getLogger(__name__)

# So many bytes that a client still sends after its answer are read and thrown away, so that the answer reaches it.
LINGER_BYTES = 64_000_000
# All clients together may have sent so many of the largest bodies in part. Then one that has sent more than its share,
# in bytes, is refused, and small requests still pass.
UNFINISHED_BODIES = 8
SHARE = 16_384
# Seconds that a connection of the reserve has for its answer, beyond the time for the head of its request.
ANSWER_WITHIN = 2.0


@dataclass
class Edge:
    """What all connections share.

    Attributes:
        unfinished: Bytes of requests and messages that have arrived in part.
    """

    settings: Settings
    limits: ConnectionLimits
    scheduler: InputScheduler = field(default_factory=InputScheduler)
    unfinished: int = 0


class InnerProtocol(Protocol):
    """A protocol of uvicorn's, as one of the subclasses here extends it."""

    @property
    def priority(self) -> Priority:
        """What the client has asked for."""

    @property
    def unread(self) -> bool:
        """Whether the client is still sending something that nobody is going to read."""

    @property
    def receiving(self) -> bool:
        """Whether a request or a message has arrived in part."""

    def refuse_input(self) -> None:
        """Tell the client that its request or message cannot be taken now."""

    def is_urgent(self, data: bytes) -> bool:
        """Whether this piece is to be handled before everything else."""

    def data_received(self, data: bytes) -> None:
        """Read a piece."""

    def handle_events(self) -> None:
        """Act on what has been read."""

    def connection_made(self, transport: asyncio.Transport) -> None:
        """The connection is there."""

    def connection_lost(self, exc: Exception | None) -> None:
        """The connection has gone."""

    def pause_writing(self) -> None:
        """The client does not read as fast as it is written to."""

    def resume_writing(self) -> None:
        """It has caught up."""


class Connection(asyncio.BufferedProtocol):
    """What stands between a transport and uvicorn's protocols: it bounds their input and lingers at the end.

    Args:
        edge: What all connections share.
        protocol: The protocol that speaks first, HTTP.
    """

    def __init__(self, edge: Edge, protocol: InnerProtocol) -> None:
        self.address = ""
        self.regular = False
        self.protocol = protocol
        self._edge = edge
        self._transport: asyncio.Transport = None  # type: ignore[assignment]
        self._pending = b""  # received, and not handled yet
        self._unfinished = 0  # bytes of a request or message that has arrived in part
        self._queued = False
        self._paused = False  # by the protocol
        self._lingering = 0  # bytes that may still come; 0: it does not linger
        self._timer: asyncio.TimerHandle | None = None
        self._left_to_write = -1

    # The connection comes and goes.

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Apply the limits, and hand the connection to the protocol."""
        self._transport = cast("asyncio.Transport", transport)
        self.address = (transport.get_extra_info("peername") or ("",))[0]
        self.regular = self._edge.limits.admit(self)
        if not self.regular:
            self._abort_in(self._edge.settings.header_timeout + ANSWER_WITHIN)
        self.protocol.connection_made(cast("asyncio.Transport", ConnectionTransport(self, self._transport)))

    def connection_lost(self, exc: Exception | None) -> None:
        """Tell the limits and the protocol."""
        self._edge.limits.release(self)
        self._count_unfinished(-self._unfinished)
        self._pending = b""
        if self._timer is not None:
            self._timer.cancel()
        self.protocol.connection_lost(exc)

    @property
    def priority(self) -> Priority:
        """What it has asked for."""
        return self.protocol.priority

    @property
    def stuck(self) -> bool:
        """Whether it is being closed, and nothing of what it still has to be sent has been read for a while."""
        before, self._left_to_write = self._left_to_write, self._transport.get_write_buffer_size()
        return self._transport.is_closing() and before == self._left_to_write

    def abort(self) -> None:
        """Close it at once."""
        self._transport.abort()

    def close(self) -> None:
        """Close it once everything has been sent.

        A client that is still sending gets time to read the answer, and what it sends is thrown away: to close a socket
        with unread input resets the connection, and the client loses the answer.
        """
        if self._lingering:
            return
        if not self.protocol.unread or self._transport.is_closing():
            self._transport.close()
            return
        self._lingering = LINGER_BYTES
        self._pending = b""
        self._count_unfinished(-self._unfinished)
        self._transport.write_eof()
        self._arrange_reading()
        self._abort_in(self._edge.settings.header_timeout)

    @property
    def closing(self) -> bool:
        """Whether there is nobody to speak to any more."""
        return bool(self._lingering) or self._transport.is_closing()

    def _abort_in(self, seconds: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(seconds, self._transport.abort)

    # Input.

    def get_buffer(self, sizehint: int) -> memoryview:
        """Where the next piece is read to."""
        return self._edge.scheduler.buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Handle a piece, now or in turn."""
        data = bytes(self._edge.scheduler.buffer[:nbytes])
        urgent = not self._pending and not self._lingering and self.protocol.is_urgent(data)
        self._pending += data
        if not self._queued and (urgent or self._edge.scheduler.free):
            self._edge.scheduler.run(self._handle)
        else:
            self.enqueue()

    def enqueue(self) -> None:
        """Have what is there handled in turn, and read nothing before that."""
        if not self._queued:
            self._queued = True
            self._arrange_reading()
            self._edge.scheduler.enqueue(self._handle_in_turn)

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
        most = UNFINISHED_BODIES * self._edge.settings.max_body_bytes
        if self._unfinished > SHARE and self._edge.unfinished > most:
            self.protocol.refuse_input()

    def _count_unfinished(self, size: int) -> None:
        self._unfinished += size
        self._edge.unfinished += size

    def pause_reading(self) -> None:
        """Read nothing, until the protocol wants more."""
        self._paused = True
        self._arrange_reading()

    def resume_reading(self) -> None:
        """Read on."""
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
        """The client does not read as fast as it is written to."""
        self.protocol.pause_writing()

    def resume_writing(self) -> None:
        """It has caught up."""
        self.protocol.resume_writing()


class ConnectionTransport:
    """The transport as the protocols see it."""

    def __init__(self, connection: Connection, transport: asyncio.Transport) -> None:
        self.connection = connection
        self._transport = transport
        self.write: Callable[[bytes], None] = transport.write
        self.close = connection.close
        self.abort = connection.abort
        self.pause_reading = connection.pause_reading
        self.resume_reading = connection.resume_reading

    def is_closing(self) -> bool:
        """Whether there is nobody to write to any more."""
        return self.connection.closing

    def set_protocol(self, protocol: InnerProtocol) -> None:
        """Go on in another protocol."""
        self.connection.protocol = protocol

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)
