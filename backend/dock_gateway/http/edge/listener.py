"""Accepts TCP connections."""

import asyncio
import logging
import socket
from collections.abc import Callable, Coroutine
from typing import Any

log = logging.getLogger(__name__)

Opener = Callable[[socket.socket], Coroutine[Any, Any, object]]

BACKLOG = 2048
# Connections accepted per turn of the event loop. uvloop accepts one: a stop behind 600 connections that had closed
# again waited for 600 turns.
AT_ONCE = 32
# Seconds without accepting after the process has run out of file descriptors.
PAUSE = 0.1


class PortListener:
    """Accepts connections on every address of a host. uvicorn treats it as one of its servers.

    Raises:
        OSError: The address cannot be bound.
    """

    def __init__(self, host: str, port: int) -> None:
        self.sockets: list[socket.socket] = []
        self._arriving: set[asyncio.Task[object]] = set()
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        try:
            for family, _, _, _, address in dict.fromkeys(addresses):
                listener = socket.create_server(address[:2], family=family, backlog=BACKLOG)
                listener.setblocking(False)
                self.sockets.append(listener)
        except OSError:
            self.close()
            raise

    def start(self, open_connection: Opener) -> None:
        """Start accepting. `open_connection` takes each accepted socket."""
        for listener in self.sockets:
            self._listen(listener, open_connection)

    def _listen(self, listener: socket.socket, open_connection: Opener) -> None:
        if listener in self.sockets:
            asyncio.get_running_loop().add_reader(listener, self._accept, listener, open_connection)

    def _accept(self, listener: socket.socket, open_connection: Opener) -> None:
        loop = asyncio.get_running_loop()
        for _ in range(AT_ONCE):
            try:
                connection, _ = listener.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                log.error("no connection can be accepted: %s", error)
                loop.remove_reader(listener)
                loop.call_later(PAUSE, self._listen, listener, open_connection)
                return
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.setblocking(False)
            task = loop.create_task(open_connection(connection))
            self._arriving.add(task)
            task.add_done_callback(self._arrived)

    def _arrived(self, task: asyncio.Task[object]) -> None:
        self._arriving.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            log.debug("a connection was closed before it was open: %r", error)

    def close(self) -> None:
        """Stop accepting."""
        while self.sockets:
            listener = self.sockets.pop()
            asyncio.get_running_loop().remove_reader(listener)
            listener.close()
        for task in self._arriving:
            task.cancel()

    async def wait_closed(self) -> None:
        """Do nothing: uvicorn closes the connections."""
