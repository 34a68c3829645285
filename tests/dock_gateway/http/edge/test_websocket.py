"""WebSockets at the edge: what a client may send, what it is told if that is too much, handshakes that are none."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import Any

import pytest
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import connect
from websockets.frames import Frame, Opcode

from dock_gateway.http.edge import connection
from dock_gateway.http.edge import websocket as edge_websocket
from tests.support.edge import HOST, Edge, code, hello, serving
from tests.support.waiting import until

UPGRADE = b"Connection: Upgrade\r\nUpgrade: websocket\r\n"
KEY = b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"


async def echo(websocket: WebSocket) -> None:
    await websocket.accept()
    try:
        while True:
            await websocket.send_text(await websocket.receive_text())
    except WebSocketDisconnect:
        pass


UNLIMITED = {"max_frames_per_second": 10_000_000, "max_frame_bytes_per_second": 1_000_000_000}
app = Starlette(routes=[WebSocketRoute("/", echo), Route("/http", hello)])


@asynccontextmanager
async def raw_websocket(edge: Edge) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    """A WebSocket whose frames are written by hand."""
    async with edge.connect() as (reader, writer):
        writer.write(b"GET / HTTP/1.1\r\n" + HOST + UPGRADE + KEY + b"\r\n")
        assert b" 101 " in await reader.readuntil(b"\r\n\r\n")
        yield reader, writer


async def flood(writer: asyncio.StreamWriter, first: Frame | None, then: Frame) -> None:
    """Send frames as fast as they are taken."""
    if first is not None:
        writer.write(first.serialize(mask=True))
    some = then.serialize(mask=True) * (1 + 10_000 // len(then.data or b"x"))
    with suppress(ConnectionError):
        while True:
            writer.write(some)
            await writer.drain()
            await asyncio.sleep(0)


async def closed(reader: asyncio.StreamReader) -> int:
    """The code that the server closes with."""
    async with asyncio.timeout(10):
        data = await reader.read()
    while True:
        opcode, length = data[0] & 0x0F, data[1]
        start = {126: 4, 127: 10}.get(length, 2)
        length = int.from_bytes(data[2:start]) if start > 2 else length
        if opcode == Opcode.CLOSE:
            return int.from_bytes(data[start : start + 2])
        data = data[start + length :]


FLOODS: dict[str, tuple[Frame | None, Frame, dict[str, Any], int]] = {
    "fragments": (
        Frame(Opcode.TEXT, b"{", fin=False),
        Frame(Opcode.CONT, b"", fin=False),
        {"max_frames_per_second": 20},
        1008,
    ),
    "few fragments a second": (
        Frame(Opcode.TEXT, b"{", fin=False),
        Frame(Opcode.CONT, b"", fin=False),
        {"max_frames_per_second": 10_000_000},
        1009,
    ),
    "pings": (None, Frame(Opcode.PING, b""), {}, 1008),
    "pongs": (None, Frame(Opcode.PONG, b""), {}, 1008),
    "messages": (None, Frame(Opcode.TEXT, b"{}"), {}, 1008),
    "bytes": (None, Frame(Opcode.TEXT, b"x" * 50_000), {"max_frame_bytes_per_second": 65_536}, 1008),
    "a large message": (
        Frame(Opcode.TEXT, b"x" * 10_000, fin=False),
        Frame(Opcode.CONT, b"x" * 10_000, fin=False),
        {"max_body_bytes": 100_000},
        1009,
    ),
    "text that is none": (None, Frame(Opcode.TEXT, b"\xff"), {}, 1007),
}


@pytest.mark.parametrize("name", FLOODS)
async def test_floods_are_cut_off_with_a_reason(name: str, caplog: pytest.LogCaptureFixture) -> None:
    first, then, settings, expected = FLOODS[name]
    async with serving(app, **settings) as edge, raw_websocket(edge) as (reader, writer):
        flooding = asyncio.create_task(flood(writer, first, then))
        assert await closed(reader) == expected
        flooding.cancel()
        async with connect(edge.websocket) as other:
            await other.send("hello")
            assert await other.recv() == "hello"
    assert not [record for record in caplog.records if record.levelname in ("WARNING", "ERROR")]


async def test_a_burst_within_the_limits_is_answered_in_full() -> None:
    async with serving(app) as edge, connect(edge.websocket, max_queue=None) as client:
        for number in range(500):
            await client.send(str(number))
        assert [await client.recv() for _ in range(500)] == [str(number) for number in range(500)]
        await client.send(iter(["in ", "a few ", "pieces"]))
        assert await client.recv() == "in a few pieces"
        large = "x" * 900_000
        await client.send(large)
        assert await client.recv() == large


async def test_the_limit_is_one_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr(edge_websocket, "monotonic", lambda: now)
    rate = edge_websocket.Rate(10)
    assert [rate.exceeded(5) for _ in range(3)] == [False, False, True]
    now = 1.0
    assert not rate.exceeded(10)


async def test_a_message_that_is_not_finished() -> None:
    for half in (
        Frame(Opcode.TEXT, b"{", fin=False).serialize(mask=True),
        Frame(Opcode.TEXT, b"{}").serialize(mask=True)[:3],
    ):
        async with serving(app, body_timeout=0.3) as edge, raw_websocket(edge) as (reader, writer):
            writer.write(half)
            assert await closed(reader) == 1008


async def test_a_message_that_is_finished_in_time() -> None:
    async with serving(app, body_timeout=0.5) as edge, connect(edge.websocket) as client:
        client.transport.write(Frame(Opcode.TEXT, b"a", fin=False).serialize(mask=True))
        await asyncio.sleep(0.1)
        client.transport.write(Frame(Opcode.CONT, b"b").serialize(mask=True))
        assert await client.recv() == "ab"
        await asyncio.sleep(0.7)
        await client.send("c")
        assert await client.recv() == "c"


async def test_all_clients_together_send_too_much() -> None:
    async with AsyncExitStack() as stack:
        edge = await stack.enter_async_context(serving(app, max_body_bytes=100_000))
        readers = []
        for _ in range(connection.UNFINISHED_BODIES + 1):
            reader, writer = await stack.enter_async_context(raw_websocket(edge))
            writer.write(Frame(Opcode.TEXT, b"x" * 90_000, fin=False).serialize(mask=True))
            readers.append(reader)
        small = await stack.enter_async_context(connect(edge.websocket))
        done, _ = await asyncio.wait(
            [asyncio.create_task(closed(one)) for one in readers], return_when=asyncio.FIRST_COMPLETED
        )
        assert [task.result() for task in done] == [1013]
        await small.send("hello")
        assert await small.recv() == "hello"


async def test_pongs_that_are_not_read_are_not_kept() -> None:
    """But for the last one, which is sent as soon as the client reads again."""
    protocols: list[edge_websocket.WebSocketProtocol] = []
    all_read = asyncio.Event()

    async def endpoint(websocket: WebSocket) -> None:
        protocols.append(websocket.scope["extensions"][edge_websocket.EXTENSION]["writer"])
        await websocket.accept()
        await websocket.receive_text()
        all_read.set()
        await websocket.receive()

    application = Starlette(routes=[WebSocketRoute("/", endpoint)])
    async with serving(application, **UNLIMITED) as edge, raw_websocket(edge) as (reader, writer):
        writer.transport.pause_reading()
        protocol = protocols[0]
        flooding = asyncio.create_task(flood(writer, None, Frame(Opcode.PING, b"x" * 100)))
        await until(lambda: not protocol.writable.is_set())
        kept = protocol.transport.get_write_buffer_size()
        await asyncio.sleep(0.5)
        assert protocol.transport.get_write_buffer_size() <= kept + 65_536
        flooding.cancel()
        for frame in (Frame(Opcode.PING, b"the last one"), Frame(Opcode.TEXT, b"the end")):
            writer.write(frame.serialize(mask=True))
        async with asyncio.timeout(10):
            await all_read.wait()
        writer.transport.resume_reading()
        async with asyncio.timeout(10):
            while b"the last one" not in await reader.read(65_536):
                pass


async def test_the_loop_turns_between_messages() -> None:
    """However many came at once: otherwise an application that does not wait would take them all in one go."""
    turns = 0
    seen: list[int] = []

    async def endpoint(websocket: WebSocket) -> None:
        await websocket.accept()
        while (await websocket.receive())["type"] != "websocket.disconnect":
            seen.append(turns)

    async def count() -> None:
        nonlocal turns
        while True:
            turns += 1
            await asyncio.sleep(0)

    async with serving(Starlette(routes=[WebSocketRoute("/", endpoint)])) as edge, connect(edge.websocket) as client:
        counting = asyncio.create_task(count())
        client.transport.write(Frame(Opcode.TEXT, b"").serialize(mask=True) * 100)
        await until(lambda: len(seen) == 100)
        counting.cancel()
    assert len(set(seen)) > 90


async def test_an_application_that_goes_on_sending_logs_nothing(caplog: pytest.LogCaptureFixture) -> None:
    ended = asyncio.Event()

    async def endpoint(websocket: WebSocket) -> None:
        await websocket.accept()
        try:
            while True:
                await websocket.send_text("x")
                await asyncio.sleep(0)
        except WebSocketDisconnect:
            ended.set()

    async with (
        serving(Starlette(routes=[WebSocketRoute("/", endpoint)])) as edge,
        raw_websocket(edge) as (reader, writer),
    ):
        flooding = asyncio.create_task(flood(writer, None, Frame(Opcode.PING, b"")))
        assert await closed(reader) == 1008
        flooding.cancel()
        await asyncio.wait_for(ended.wait(), 10)
    assert not [record for record in caplog.records if record.levelname in ("WARNING", "ERROR")]


@pytest.mark.parametrize(
    ("head", "expected"),
    [
        (b"GET /?" + b"x" * 10_000 + b" HTTP/1.1\r\n" + HOST + UPGRADE + KEY, 414),
        (b"GET / HTTP/1.1\r\n" + HOST + UPGRADE + KEY + b"X: " + b"x" * 10_000 + b"\r\n", 431),
        (b"GET / HTTP/1.1\r\n" + HOST + UPGRADE + KEY + b"Content-Length: 5\r\n", 400),
        (b"GET / HTTP/1.1\r\n" + HOST + UPGRADE, 400),
        (b"GET / HTTP/1.1\r\n" + HOST + UPGRADE + b"Sec-WebSocket-Version: 12\r\n", 400),
        (b"GET /http HTTP/1.1\r\n" + HOST + UPGRADE, 400),
    ],
)
async def test_a_handshake_that_is_none(head: bytes, expected: int) -> None:
    problem = "malformed_request" if expected == 400 else "header_too_large"
    async with serving(app) as edge:
        assert code(await edge.ask(head + b"\r\n")) == (expected, problem)


async def test_floods_of_a_few_do_not_keep_others_waiting() -> None:
    async with serving(app, **UNLIMITED) as edge, AsyncExitStack() as stack:
        for _ in range(5):
            _, writer = await stack.enter_async_context(raw_websocket(edge))
            flooding = asyncio.create_task(flood(writer, None, Frame(Opcode.PONG, b"")))
            stack.callback(flooding.cancel)
        began = time.monotonic()
        for _ in range(5):
            answer = await edge.ask(b"GET /http HTTP/1.1\r\nConnection: close\r\n" + HOST + b"\r\n")
            assert answer.endswith(b"GET /http")
        assert time.monotonic() - began < 5


async def refuse(websocket: WebSocket) -> None:
    await websocket.send_denial_response(PlainTextResponse("no", 403))


async def test_a_websocket_that_is_refused_is_no_error(caplog: pytest.LogCaptureFixture) -> None:
    async with serving(Starlette(routes=[WebSocketRoute("/", refuse)])) as edge:
        answer = await edge.ask(b"GET / HTTP/1.1\r\n" + HOST + UPGRADE + KEY + b"\r\n")
    assert answer.startswith(b"HTTP/1.1 403 ")
    assert answer.endswith(b"no")
    assert not [record for record in caplog.records if record.levelname in ("WARNING", "ERROR")]
