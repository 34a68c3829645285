"""HTTP at the edge: heads that are too large or too slow, bodies that nobody reads, and what is no request at all."""

import asyncio
import socket
import time
import urllib.error
import urllib.request
from asyncio.trsock import TransportSocket
from collections.abc import Callable
from contextlib import AsyncExitStack, suppress
from http.client import HTTPConnection

import httpx2
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from dock_gateway.http.edge import http
from tests.support.edge import HOST, code, hello, serving

START = b"GET / HTTP/1.1\r\n" + HOST
PAGE = 20_000_000
LARGE = b"x" * 20_000_000


async def echo(request: Request) -> Response:
    return PlainTextResponse(str(len(await request.body())))


async def refuse(request: Request) -> Response:
    headers = {"Connection": "close"} if "close" in request.query_params else {}
    return PlainTextResponse("too large", 413, headers)


app = Starlette(
    routes=[
        Route("/", hello, methods=["GET", "POST"]),
        Route("/echo", echo, methods=["POST"]),
        Route("/refuse", refuse, methods=["POST"]),
        Route("/page", lambda _: PlainTextResponse("x" * PAGE)),
    ]
)


def code_of(answer: bytes) -> int:
    """Status of an answer."""
    return int(answer.split(b" ", 2)[1])


@pytest.mark.parametrize(
    "head",
    {
        "one line": START + b"X: " + b"x" * 5_000_000,
        "one whole line": START + b"X: " + b"x" * 5_000_000 + b"\r\n\r\n",
        "the request line": b"GET /" + b"x" * 5_000_000,
        "many lines": START + b"a: b\r\n" * 1_000_000,
        "a few too many lines": START + b"a: b\r\n" * http.MAX_HEADERS + b"\r\n",
    }.values(),
)
async def test_a_head_that_is_too_large(head: bytes) -> None:
    async with serving(app) as edge:
        assert code(await edge.ask(head)) == (431, "header_too_large")


async def test_a_head_that_is_large_enough() -> None:
    headers = b"".join(b"X-%d: %s\r\n" % (number, b"x" * 500) for number in range(http.MAX_HEADERS - 2))
    async with serving(app) as edge:
        assert (await edge.ask(START + headers + b"Connection: close\r\n\r\n")).endswith(b"GET /")


async def test_a_setting_for_the_size_of_a_head() -> None:
    async with serving(app, max_header_bytes=8192) as edge:
        assert code(await edge.ask(START + b"X: " + b"x" * 12_000)) == (431, "header_too_large")


async def test_a_head_that_does_not_arrive() -> None:
    async with serving(app, header_timeout=0.3) as edge:
        assert code(await edge.ask(START)) == (408, "request_timeout")


async def test_a_head_that_arrives_byte_by_byte() -> None:
    async with serving(app, header_timeout=0.5) as edge, edge.connect() as (reader, writer):
        answer = asyncio.create_task(reader.read())
        writer.write(START)
        while not answer.done():
            writer.write(b"x")
            await asyncio.sleep(0.05)
        assert code(await answer) == (408, "request_timeout")


async def test_a_second_head_that_does_not_arrive() -> None:
    async with serving(app, header_timeout=0.3) as edge:
        first, _, second = (await edge.ask(START + b"\r\n", START)).partition(b"GET /")
        assert b" 200 " in first
        assert code(second) == (408, "request_timeout")


async def test_who_says_nothing_is_let_go() -> None:
    async with serving(app, header_timeout=0.3) as edge:
        assert await edge.ask(b"") == b""


@pytest.mark.parametrize("path", ["/refuse", "/refuse?close", "/nowhere"])
@pytest.mark.parametrize("client", ["http.client", "urllib", "httpx2", "chunked"])
async def test_an_answer_before_the_body_is_read(path: str, client: str) -> None:
    """Also by clients that send the whole body first: closing at once would reset the connection."""
    status = 404 if path == "/nowhere" else 413
    async with serving(app) as edge:
        assert await asyncio.to_thread(CLIENTS[client], f"{edge.url}{path}") == status


def by_http_client(url: str) -> int:
    connection = HTTPConnection(url.split("/")[2], timeout=10)
    connection.request("POST", "/" + url.split("/", 3)[3], LARGE)
    status = connection.getresponse().status
    connection.close()
    return status


def by_urllib(url: str) -> int:
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(urllib.request.Request(url, LARGE, method="POST"), timeout=10)
    with refused.value as error:
        return error.status


def by_httpx2(url: str) -> int:
    return httpx2.post(url, content=LARGE, trust_env=False).status_code


def by_chunks(url: str) -> int:
    return httpx2.post(url, content=(LARGE[:65_536] for _ in range(300)), trust_env=False).status_code


CLIENTS: dict[str, Callable[[str], int]] = {
    "http.client": by_http_client,
    "urllib": by_urllib,
    "httpx2": by_httpx2,
    "chunked": by_chunks,
}


async def test_a_connection_goes_on_after_a_body_that_was_not_read() -> None:
    body = b"POST /refuse HTTP/1.1\r\nContent-Length: 100000\r\n" + HOST + b"\r\n" + b"x" * 100_000
    async with serving(app) as edge:
        answer = await edge.ask(body, START + b"Connection: close\r\n\r\n")
        assert answer.count(b"HTTP/1.1 ") == 2
        assert answer.endswith(b"GET /")


@pytest.mark.parametrize("close", [b"", b"Connection: close\r\n"])
async def test_a_body_without_end_after_the_answer(close: bytes) -> None:
    head = b"POST /refuse HTTP/1.1\r\nContent-Length: 100000000000\r\n" + close + HOST + b"\r\n"
    async with serving(app) as edge, edge.connect() as (reader, writer):
        writer.write(head)
        assert b" 413 " in await reader.readline()
        with pytest.raises(ConnectionError):  # noqa: PT012 - it takes a while
            while True:
                writer.write(b"x" * 65_536)
                await writer.drain()
                await asyncio.sleep(0)


async def test_a_slow_body_without_end_after_the_answer() -> None:
    head = b"POST /refuse HTTP/1.1\r\nContent-Length: 100000000000\r\n" + HOST + b"\r\n"
    async with serving(app, header_timeout=0.5) as edge, edge.connect() as (reader, writer):
        ended = asyncio.create_task(reader.read())
        writer.write(head)
        while not ended.done():
            writer.write(b"x")
            await asyncio.sleep(0.05)
        with suppress(ConnectionError):
            await ended


async def test_after_a_websocket_that_is_none_the_connection_is_no_tunnel() -> None:
    """Such as one by POST. A careless proxy would pass on whatever its client sends next."""
    head = (
        b"POST /echo HTTP/1.1\r\n"
        + HOST
        + b"Content-Length: 5\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\r\nhello"
    )
    async with serving(app) as edge:
        answer = await edge.ask(head, START + b"\r\n")
    assert answer.endswith(b"\r\n\r\n5")
    assert answer.count(b"HTTP/1.1 ") == 1


@pytest.mark.parametrize("upgrade", [b"websocket", b"h2c", b"anything"])
@pytest.mark.parametrize("method", [b"POST", b"DELETE"])
async def test_an_upgrade_that_is_not_offered_is_ignored(upgrade: bytes, method: bytes) -> None:
    head = method + b" /echo HTTP/1.1\r\n" + HOST + b"Content-Length: 5\r\nConnection: close, Upgrade\r\nUpgrade: "
    async with serving(app) as edge:
        answer = await edge.ask(head + upgrade + b"\r\n\r\nhello")
        assert (answer.endswith(b"5"), b" 405 " in answer) == (method == b"POST", method != b"POST")


@pytest.mark.parametrize(
    "garbage",
    [
        b"\x16\x03\x01\x02\x00garbage\r\n\r\n",
        b"dock please\r\n\r\n",
        START + b"no colon\r\n\r\n",
        START + b"Content-Length: 1\r\nContent-Length: 2\r\n\r\n",
        b"GET / HTTP/1.1\r\n\r\n",  # no Host
        START + HOST + b"\r\n",  # two
    ],
)
async def test_what_is_no_request(garbage: bytes, caplog: pytest.LogCaptureFixture) -> None:
    async with serving(app) as edge:
        assert code(await edge.ask(garbage)) == (400, "malformed_request")
    assert not [record for record in caplog.records if record.levelname in ("WARNING", "ERROR")]


async def test_a_transfer_coding_that_is_not_known() -> None:
    async with serving(app) as edge:
        assert code(await edge.ask(START + b"Transfer-Encoding: gzip\r\n\r\n")) == (501, "malformed_request")


async def test_a_body_that_breaks_off_in_garbage() -> None:
    head = b"POST /echo HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n"
    async with serving(app) as edge:
        assert code(await edge.ask(head, b"5\r\nhello\r\n", b"no number\r\n")) == (400, "malformed_request")
        assert (await edge.ask(START + b"Connection: close\r\n\r\n")).endswith(b"GET /")


async def test_requests_that_come_at_once_are_answered_one_after_the_other() -> None:
    requests = b"".join(b"GET /%d HTTP/1.1\r\n" % number + HOST + b"\r\n" for number in range(300))
    async with serving(Starlette(routes=[Route("/{number}", hello)])) as edge:
        answer = await edge.ask(requests + b"GET /last HTTP/1.1\r\nConnection: close\r\n" + HOST + b"\r\n")
    assert [int(part.partition(b"HTTP")[0]) for part in answer.split(b"GET /")[1:-1]] == list(range(300))


async def test_who_does_not_read_the_answer_is_let_go() -> None:
    async with serving(app, subscriber_timeout=0.3) as edge, edge.connect() as (reader, writer):
        writer.transport.pause_reading()
        writer.write(b"GET /page HTTP/1.1\r\nConnection: close\r\n" + HOST + b"\r\n")
        await asyncio.sleep(1.5)
        writer.transport.resume_reading()
        assert len(await asyncio.wait_for(reader.read(), 10)) < PAGE


async def test_all_clients_together_send_too_much() -> None:
    head = b"POST /echo HTTP/1.1\r\nConnection: close\r\nContent-Length: %d\r\n" + HOST + b"\r\n"
    async with serving(app, max_body_bytes=125_000) as edge, AsyncExitStack() as stack:
        for number in range(10):
            _, writer = await stack.enter_async_context(edge.connect(f"127.0.0.{2 + number % 2}"))
            writer.write(head % 1_000_000 + b"x" * 99_000)
        while b" 429 " not in (answer := await edge.ask(head % 200_000 + b"x" * 200_000)):
            assert answer.endswith(b"200000")  # what the others sent has not been read yet
        assert code(answer) == (429, "too_much_input")
        assert (await edge.ask(head % 15_000 + b"x" * 15_000)).endswith(b"15000")
        await stack.aclose()
        while b" 429 " in (answer := await edge.ask(head % 200_000 + b"x" * 200_000)):
            pass
        assert answer.endswith(b"200000")


async def test_what_clients_at_one_address_send_leaves_room_for_others() -> None:
    head = b"POST /echo HTTP/1.1\r\nConnection: close\r\nContent-Length: %d\r\n" + HOST + b"\r\n"
    body = head % 200_000 + b"x" * 200_000
    async with serving(app, max_body_bytes=125_000) as edge, AsyncExitStack() as stack:
        for _ in range(20):
            _, writer = await stack.enter_async_context(edge.connect("127.0.0.2"))
            writer.write(head % 1_000_000 + b"x" * 99_000)
        refused = False
        for _ in range(50):  # what was sent is read in turns
            async with edge.connect("127.0.0.2") as (reader, writer):
                writer.write(body)
                refused = refused or code_of(await asyncio.wait_for(reader.read(), 10)) == 429
            assert (await edge.ask(body)).endswith(b"200000")
        assert refused


async def test_a_connection_of_the_reserve_has_one_request_and_no_websocket() -> None:
    upgrade = b"GET / HTTP/1.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n" + HOST
    async with serving(app, max_connections_per_address=8, header_timeout=2) as edge, AsyncExitStack() as stack:
        regular = [await stack.enter_async_context(edge.connect()) for _ in range(8)]
        for _, writer in regular:  # answered, so that they have been counted, and kept alive
            writer.write(START + b"\r\n")
        for reader, _ in regular:
            assert b" 200 " in await reader.readuntil(b"GET /")
        assert (await edge.ask(START + b"\r\n")).endswith(b"GET /")
        assert code(await edge.ask(upgrade + b"\r\n")) == (429, "too_many_connections")
        assert code(await edge.ask(START)) == (408, "request_timeout")


async def test_tiny_chunks_do_not_keep_others_waiting() -> None:
    head = b"POST /echo HTTP/1.1\r\n" + HOST + b"Transfer-Encoding: chunked\r\n\r\n"
    chunks = b"1\r\nx\r\n" * 50_000

    async def flood(writer: asyncio.StreamWriter) -> None:
        while True:
            writer.write(chunks)
            await writer.drain()

    async with serving(app) as edge, edge.connect() as (_, writer):
        writer.write(head)
        flooding = asyncio.create_task(flood(writer))
        began = time.monotonic()
        for _ in range(5):
            assert (await edge.ask(START + b"Connection: close\r\n\r\n")).endswith(b"GET /")
        assert time.monotonic() - began < 5
        flooding.cancel()
        writer.transport.abort()


def test_a_client_that_has_left_before_its_stream_begins_is_no_error() -> None:
    with socket.socket() as left:
        pass
    request = Request({"type": "http", "extensions": {http.EXTENSION: {"socket": TransportSocket(left)}}})
    http.limit_unsent(request, 1)


async def test_a_request_that_is_canceled_at_shutdown_is_answered() -> None:
    running: asyncio.Future[asyncio.Task[object]] = asyncio.get_running_loop().create_future()

    async def wait(_: Request) -> Response:
        task = asyncio.current_task()
        assert task is not None
        running.set_result(task)
        await asyncio.Event().wait()
        raise AssertionError

    async with serving(Starlette(routes=[Route("/", wait)])) as edge:
        asking = asyncio.create_task(edge.ask(START + b"\r\n"))
        (await running).cancel()
        assert code(await asking) == (503, "shutting_down")
