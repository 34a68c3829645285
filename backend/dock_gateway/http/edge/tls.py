"""The TLS handshake of an accepted connection."""

import asyncio
import socket
import ssl
from contextlib import suppress
from typing import Any

from dock_gateway.http.edge.connection import GuardedConnection

# The first byte that a client sends: the type of a TLS handshake record.
HANDSHAKE = b"\x16"
# Seconds that a handshake costs, with an RSA key of 2048 bits.
HANDSHAKE_COST = 0.001


class HandshakeTransport(asyncio.Transport):
    """The transport of a connection until its handshake is complete: it can only be aborted."""

    def __init__(self, sock: socket.socket) -> None:
        super().__init__({"peername": sock.getpeername()})
        self._sock = sock

    def abort(self) -> None:
        """Shut the socket down: what waits for its input ends."""
        with suppress(OSError):
            self._sock.shutdown(socket.SHUT_RDWR)

    def is_closing(self) -> bool:
        """Return False: nothing has been written yet."""
        return False

    def get_write_buffer_size(self) -> int:
        """Return 0: nothing has been written yet."""
        return 0


async def open_tls(sock: socket.socket, connection: GuardedConnection, context: ssl.SSLContext) -> None:
    """Open a connection with TLS. One that is not TLS is opened, too, for its answer: `HttpProtocol` refuses it.

    The connection counts towards the limits from the beginning, so clients that complete no handshake take no place
    that others cannot get. They are dropped after the timeout.

    Raises:
        OSError, TimeoutError: The client did not complete the handshake.
    """
    timeout = connection.edge.settings.header_timeout
    try:
        connection.arrive(HandshakeTransport(sock))
        options: dict[str, Any] = {}
        if await _first_byte(sock, timeout) == HANDSHAKE:
            await connection.edge.scheduler.wait(HANDSHAKE_COST)
            options = {"ssl": context, "ssl_handshake_timeout": timeout, "ssl_shutdown_timeout": timeout}
        await asyncio.get_running_loop().connect_accepted_socket(lambda: connection, sock, **options)
    except BaseException:
        connection.depart()
        sock.close()
        raise


async def _first_byte(sock: socket.socket, timeout: float) -> bytes:
    """Return the first byte that a client sends, and leave it in the socket."""
    loop = asyncio.get_running_loop()
    readable = asyncio.Event()
    loop.add_reader(sock, readable.set)
    try:
        async with asyncio.timeout(timeout):
            await readable.wait()
    finally:
        loop.remove_reader(sock)
    first = sock.recv(1, socket.MSG_PEEK)
    if not first:
        raise ConnectionResetError("it was closed before the first byte")
    return first
