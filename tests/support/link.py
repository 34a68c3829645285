"""A link to a NATS server that misbehaves: cut, silent, with messages that come twice or in another order."""

import asyncio
import random
import threading
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

from tests.support.nats import NatsServer

T = TypeVar("T")
# Messages with a payload, whose size is the last word of their first line.
WITH_PAYLOAD = (b"PUB", b"HPUB", b"MSG", b"HMSG")
# Seconds for which a message is held back at most, to let a later one pass.
HELD = 0.05


class Link:
    """A way to a server, for one client: it can be cut, fall silent, repeat messages and change their order.

    Args:
        upstream: The port of the server.
        duplicated: The share of messages, in either direction, that arrive twice.
        reordered: The share that a later one overtakes.
        seed: Of what happens by chance.
    """

    def __init__(self, upstream: int, *, duplicated: float = 0.0, reordered: float = 0.0, seed: int = 1) -> None:
        self.duplicated, self.reordered = duplicated, reordered
        self.repeated = self.overtaken = 0
        self._upstream = upstream
        self._random = random.Random(seed)
        self._tasks: set[asyncio.Task[None]] = set()
        self._broken = False
        self._loop = asyncio.new_event_loop()
        self._audible = asyncio.Event()
        self._audible.set()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._server = self._run(asyncio.start_server(self._serve, "127.0.0.1", 0))
        self.port: int = self._server.sockets[0].getsockname()[1]

    def _run(self, coroutine: Coroutine[Any, Any, T]) -> T:
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(30)

    @contextmanager
    def cut(self) -> Iterator[None]:
        """No connection, and none can be made."""
        self._broken = True
        self._run(self._drop())
        try:
            yield
        finally:
            self._broken = False

    @contextmanager
    def silent(self) -> Iterator[None]:
        """Connections stay, and nothing comes through; then all of it does."""
        self._loop.call_soon_threadsafe(self._audible.clear)
        try:
            yield
        finally:
            self._loop.call_soon_threadsafe(self._audible.set)

    async def _drop(self) -> None:
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._tasks.add(task)
        try:
            if self._broken:
                return
            there, back = await asyncio.open_connection("127.0.0.1", self._upstream)
            try:
                async with asyncio.TaskGroup() as group:
                    group.create_task(self._pump(reader, back))
                    group.create_task(self._pump(there, writer))
            finally:
                back.close()
        except (OSError, EOFError, ExceptionGroup, asyncio.CancelledError):
            return
        finally:
            self._tasks.discard(task)
            writer.close()

    async def _pump(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        held = b""
        while True:
            try:
                async with asyncio.timeout(HELD if held else None):
                    line = await reader.readline()
            except TimeoutError:
                line = b""
            else:
                if not line:
                    raise EOFError
            message = line
            if line.split(b" ", 1)[0] in WITH_PAYLOAD:
                message += await reader.readexactly(int(line.split()[-1]) + 2)
                chance = self._random.random()
                if chance < self.duplicated:
                    message += message
                    self.repeated += 1
                elif not held and chance < self.duplicated + self.reordered:
                    held = message
                    self.overtaken += 1
                    continue
            await self._audible.wait()
            writer.write(message + held)
            held = b""
            await writer.drain()

    def close(self) -> None:
        """End all connections."""
        self._server.close()
        self._run(self._drop())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(5)
        with suppress(RuntimeError):
            self._loop.close()


@contextmanager
def link_to(server: NatsServer, *, duplicated: float = 0.0, reordered: float = 0.0, seed: int = 1) -> Iterator[Link]:
    """A link that is there until the block ends."""
    link = Link(server.port, duplicated=duplicated, reordered=reordered, seed=seed)
    try:
        yield link
    finally:
        link.close()
