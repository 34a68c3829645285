"""A loop that sends gives way, though the socket takes all that is sent: others have their turn meanwhile."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import httpx2 as httpx
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import StreamingResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from websockets.asyncio.client import connect

from dock_gateway.http.edge.scheduler import SEND_COST, TurnScheduler
from tests.support.edge import Edge, serving

PIECES = 2_000
# What is sent in a turn; two may fall into one as it is counted here.
IN_A_TURN = round(TurnScheduler.TURN / SEND_COST) + 1


class Turns:
    """Counts what is sent in each turn of the loop."""

    def __init__(self) -> None:
        self.most = 0
        self._sent = 0

    def sent(self) -> None:
        if not self._sent:
            asyncio.get_running_loop().call_soon(self._turn)
        self._sent += 1
        self.most = max(self.most, self._sent)

    def _turn(self) -> None:
        self._sent = 0


@asynccontextmanager
async def sending(turns: Turns) -> AsyncIterator[Edge]:
    """An application that sends many pieces, and counts them."""

    async def socket(websocket: WebSocket) -> None:
        await websocket.accept()
        for _ in range(PIECES):
            turns.sent()
            await websocket.send_text("piece")
        await websocket.close()

    async def stream(_: Request) -> StreamingResponse:
        async def pieces() -> AsyncIterator[bytes]:
            for _ in range(PIECES):
                turns.sent()
                yield b"piece"

        return StreamingResponse(pieces())

    async with serving(Starlette(routes=[WebSocketRoute("/socket", socket), Route("/stream", stream)])) as edge:
        yield edge


async def read_socket(edge: Edge) -> int:
    async with connect(f"{edge.websocket}/socket") as connection:
        return len([message async for message in connection])


async def read_stream(edge: Edge) -> int:
    async with httpx.AsyncClient() as client:
        return len((await client.get(f"{edge.url}/stream")).content) // len(b"piece")


@pytest.mark.parametrize("read", [read_socket, read_stream])
@pytest.mark.parametrize("readers", [1, 5])
async def test_few_pieces_are_sent_in_a_turn_of_the_loop(read: Callable[[Edge], object], readers: int) -> None:
    turns = Turns()
    async with sending(turns) as edge:
        counts = await asyncio.gather(*(read(edge) for _ in range(readers)))  # type: ignore[call-overload]
    assert counts == [PIECES] * readers
    assert turns.most <= 2 * IN_A_TURN + readers
