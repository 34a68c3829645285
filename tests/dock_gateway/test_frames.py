"""The short way to a WebSocket, beside the standard one."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.routing import WebSocketRoute
from starlette.websockets import WebSocket
from websockets.asyncio.client import connect

from dock_gateway.api.frames import FramesProtocol, short_way
from dock_gateway.events import Event


def event(size: int) -> Event:
    return Event(b"x" * size, "goals")


@asynccontextmanager
async def serving(endpoint: Any, **settings: Any) -> AsyncIterator[str]:
    app = Starlette(routes=[WebSocketRoute("/", endpoint)])
    server = uvicorn.Server(uvicorn.Config(app, port=0, log_config=None, lifespan="off", **settings))
    task = asyncio.create_task(server._serve())
    while not server.started:  # noqa: ASYNC110 - it has no event for that
        await asyncio.sleep(0.01)
    try:
        yield f"ws://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    finally:
        server.should_exit = True
        await task


@pytest.mark.parametrize("size", [0, 125, 126, 65_535, 65_536, 200_000])
async def test_a_frame_reads_as_the_text(size: int) -> None:
    async def endpoint(websocket: WebSocket) -> None:
        await websocket.accept()
        way = short_way(websocket)
        assert way is not None
        assert way(event(size))
        await websocket.close()

    async with serving(endpoint, ws=FramesProtocol, ws_per_message_deflate=False) as url, connect(url) as client:
        assert await client.recv() == "x" * size


@pytest.mark.parametrize(
    "settings",
    [
        {"ws": "websockets-sansio", "ws_per_message_deflate": False},  # another server
        {"ws": FramesProtocol, "ws_per_message_deflate": True},  # frames differ from reader to reader
    ],
)
async def test_without_the_extension_there_is_the_standard_way_alone(settings: dict[str, Any]) -> None:
    async def endpoint(websocket: WebSocket) -> None:
        await websocket.accept()
        await websocket.send_text(str(short_way(websocket)))
        await websocket.close()

    async with serving(endpoint, **settings) as url, connect(url) as client:
        assert await client.recv() == "None"


async def test_nothing_is_written_to_a_reader_that_does_not_read_or_has_gone() -> None:
    outcome: asyncio.Future[list[bool]] = asyncio.get_running_loop().create_future()

    async def endpoint(websocket: WebSocket) -> None:
        way = short_way(websocket)
        assert way is not None
        answers = [way(event(1))]  # not accepted yet
        await websocket.accept()
        while way(event(1_000_000)):  # until its buffer is full
            answers.append(True)
        await websocket.receive()  # it left
        outcome.set_result([*answers, way(event(1))])

    async with serving(endpoint, ws=FramesProtocol, ws_per_message_deflate=False) as url:
        async with connect(url, max_queue=1, close_timeout=0.1) as client:
            await client.recv()
            client.transport.abort()
        first, *written, last = await asyncio.wait_for(outcome, 10)
    assert not first
    assert written
    assert not last
