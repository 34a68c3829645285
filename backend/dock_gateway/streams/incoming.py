"""What a client sends over a WebSocket: each message in a task of its own, up to a limit that lets stops pass."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from contextlib import contextmanager
from typing import Any

from fastapi import WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.work import SMALL

# Bytes of the long messages of a client that are in progress at a time, unless there is only one. Decoded, they take
# twenty times as much memory.
MOST_BYTES = 250_000


class Reads:
    """Operations of one client that only read, which may take minutes: they end with its connection."""

    def __init__(self) -> None:
        self._tasks: set[asyncio.Task[Any]] = set()
        self._closed = False

    @contextmanager
    def one(self) -> Iterator[None]:
        """Run a block for as long as the client is connected.

        Raises:
            WebSocketDisconnect: It is not any more.
        """
        task = asyncio.current_task()
        if self._closed or task is None:
            raise WebSocketDisconnect
        self._tasks.add(task)
        try:
            yield
        finally:
            self._tasks.discard(task)

    def close(self) -> None:
        """End all of them."""
        self._closed = True
        for task in self._tasks:
            task.cancel()


async def carry_out_all(
    websocket: WebSocket,
    handle: Callable[[Message], Coroutine[Any, Any, None]],
    refuse: Callable[[Message, TooManyRequests], Awaitable[None]],
    is_urgent: Callable[[Message], bool],
    *,
    collect: Callable[[Message], Awaitable[Message | None]] | None = None,
    most: int,
    most_urgent: int,
    what: str,
) -> None:
    """Carry out what a client sends, each message in a task of its own, until it disconnects.

    Args:
        websocket: The connection.
        handle: Carries out a message, and answers it.
        refuse: Answers a message that is one too many.
        is_urgent: Whether a message must not be refused, as it stops something.
        collect: Puts messages together that come in pieces; None until one is whole.
        most: Maximum number of messages in progress; more are refused.
        most_urgent: Urgent ones in addition to them. Beyond this, the socket is not read until one is answered.
        what: What the messages are called, such as `commands`.
    """
    tasks: dict[asyncio.Task[None], int] = {}
    while True:
        received = await websocket.receive()
        if received["type"] == "websocket.disconnect":
            return
        if collect is not None:
            whole = await collect(received)
            if whole is None:
                continue
            received = whole
        size = len(received.get("text") or received.get("bytes") or b"")
        many = len(tasks) >= most
        long = sum(each for each in tasks.values() if each > SMALL)
        large = size > SMALL and long > 0 and long + size > MOST_BYTES
        if (many or large) and not is_urgent(received):
            in_progress = f"{most} {what}" if many else f"{what} of {MOST_BYTES:,} bytes"
            await refuse(received, TooManyRequests(f"{in_progress} are already in progress"))
            continue
        while len(tasks) >= most + most_urgent:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        task = asyncio.create_task(handle(received))
        tasks[task] = size
        task.add_done_callback(tasks.pop)
