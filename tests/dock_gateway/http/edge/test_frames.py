"""The short way to a WebSocket, beside the standard one."""

import asyncio
from typing import Any

import pytest
from starlette.applications import Starlette
from starlette.routing import WebSocketRoute
from starlette.testclient import TestClient
from starlette.websockets import WebSocket
from websockets.asyncio.client import connect

from dock_gateway.core.event import Event
from dock_gateway.http.edge.websocket import frame_writer
from tests.support.edge import serving


def frame(size: int) -> bytes:
    return Event(b"x" * size, "goals").frame


def routes(endpoint: Any) -> Starlette:
    return Starlette(routes=[WebSocketRoute("/", endpoint)])


@pytest.mark.parametrize("size", [0, 125, 126, 65_535, 65_536, 200_000])
async def test_a_frame_reads_as_the_text(size: int) -> None:
    async def endpoint(websocket: WebSocket) -> None:
        await websocket.accept()
        way = frame_writer(websocket)
        assert way is not None
        assert way.write_frame(frame(size))
        await websocket.close()

    async with serving(routes(endpoint)) as edge, connect(edge.websocket) as client:
        assert await client.recv() == "x" * size


async def test_on_another_server_there_is_the_standard_way_alone() -> None:
    async def endpoint(websocket: WebSocket) -> None:
        await websocket.accept()
        await websocket.send_text(str(frame_writer(websocket)))

    with TestClient(routes(endpoint)) as client, client.websocket_connect("/") as connection:
        assert connection.receive_text() == "None"


async def test_nothing_is_written_to_a_reader_that_does_not_read_or_has_gone() -> None:
    outcome: asyncio.Future[list[bool]] = asyncio.get_running_loop().create_future()

    async def endpoint(websocket: WebSocket) -> None:
        way = frame_writer(websocket)
        assert way is not None
        answers = [way.write_frame(frame(1))]  # not accepted yet
        await websocket.accept()
        while way.write_frame(frame(1_000_000)):  # until its buffer is full
            answers.append(True)
        await websocket.receive()  # it left
        outcome.set_result([*answers, way.write_frame(frame(1))])

    async with serving(routes(endpoint)) as edge:
        async with connect(edge.websocket, max_queue=1, close_timeout=0.1) as client:
            await client.recv()
            client.transport.abort()
        first, *written, last = await asyncio.wait_for(outcome, 10)
    assert not first
    assert written
    assert not last
