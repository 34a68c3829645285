"""What a client sends over a WebSocket."""

import asyncio

import pytest
from starlette.websockets import WebSocketDisconnect

from dock_gateway.streams.incoming import Reads


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
