"""What a client sends over a WebSocket."""

import asyncio
from typing import Any

import pytest
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.core.errors import TooManyRequests
from dock_gateway.streams.incoming import MOST_BYTES, Reads, carry_out_all


async def test_what_only_reads_ends_with_its_connection() -> None:
    reads, began = Reads(), asyncio.Event()

    async def read(*, for_ever: bool) -> None:
        with reads.one():
            if for_ever:
                began.set()
                await asyncio.Event().wait()

    await read(for_ever=False)
    reading = asyncio.create_task(read(for_ever=True))
    await began.wait()
    reads.close()
    with pytest.raises(asyncio.CancelledError):
        await reading
    with pytest.raises(WebSocketDisconnect):
        await read(for_ever=False)


class Client:
    """Sends messages as they are received, then disconnects."""

    def __init__(self, *texts: str) -> None:
        self._messages = [{"type": "websocket.receive", "text": text} for text in texts]

    async def receive(self) -> Message:
        await asyncio.sleep(0)
        return self._messages.pop(0) if self._messages else {"type": "websocket.disconnect"}


async def test_what_is_in_progress_has_a_limit_in_bytes_that_lets_stops_pass() -> None:
    handled, refused, go = [], [], asyncio.Event()

    async def handle(received: Message) -> None:
        handled.append(received["text"][:4])
        await go.wait()

    async def refuse(received: Message, error: TooManyRequests) -> None:
        refused.append((received["text"][:4], error.detail))

    huge, large = "huge" + "x" * 2 * MOST_BYTES, "more" + "x" * MOST_BYTES
    client: Any = Client("tiny", huge, "tiny", large, "stop" + "x" * MOST_BYTES)
    await carry_out_all(
        client, handle, refuse, lambda each: each["text"].startswith("stop"), most=9, most_urgent=9, what="commands"
    )
    await asyncio.sleep(0)
    assert handled == ["tiny", "huge", "tiny", "stop"]  # one of any size, small ones, and what stops something
    assert refused == [("more", "commands of 250,000 bytes are already in progress")]
    go.set()
