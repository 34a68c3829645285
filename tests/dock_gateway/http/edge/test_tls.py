"""TLS at the edge: requests and WebSockets, clients that are not TLS, and clients that complete no handshake."""

import asyncio
import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import httpx2
import orjson
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from dock_gateway.http.edge.connection import WRITE_BUFFER
from tests.support.certificates import Authority, Pair
from tests.support.edge import HOST, Edge, serving
from tests.support.waiting import PATIENCE

HSTS = "strict-transport-security"
LARGE = b"x" * 3_000_000


async def hello(request: Request) -> Response:
    return PlainTextResponse(request.url.scheme)


async def count(request: Request) -> Response:
    return PlainTextResponse(str(len(await request.body())))


async def refuse(request: Request) -> Response:
    return PlainTextResponse("too large", 413, {"Connection": "close"})


async def echo(websocket: WebSocket) -> None:
    await websocket.accept()
    async for text in websocket.iter_text():
        await websocket.send_text(f"{websocket.url.scheme} {text}")


app = Starlette(
    routes=[
        Route("/", hello, methods=["GET", "POST"]),
        Route("/count", count, methods=["POST"]),
        Route("/refuse", refuse, methods=["POST"]),
        Route("/page", lambda _: PlainTextResponse(LARGE)),
        WebSocketRoute("/ws", echo),
    ]
)


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    return Authority(tmp_path)


@pytest.fixture
def pair(authority: Authority) -> Pair:
    return authority.issue()


def client(edge: Edge, context: ssl.SSLContext) -> httpx2.AsyncClient:
    return httpx2.AsyncClient(base_url=edge.url, verify=context, trust_env=False, timeout=PATIENCE)


@asynccontextmanager
async def reader(
    edge: Edge, context: ssl.SSLContext
) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    """A TLS connection whose bytes are written and read by hand."""
    reader, writer = await asyncio.open_connection("127.0.0.1", edge.port, ssl=context, limit=1024)
    try:
        yield reader, writer
    finally:
        writer.transport.abort()


async def test_requests(authority: Authority, pair: Pair) -> None:
    async with serving(app, **pair.settings) as edge, client(edge, authority.context()) as http:
        for _ in range(2):
            answer = await http.get("/")
            assert (answer.text, answer.headers[HSTS]) == ("https", "max-age=31536000")
        assert (await http.post("/count", content=LARGE[:900_000])).text == "900000"
        assert (await http.get("/page")).content == LARGE


async def test_no_hsts_without_tls() -> None:
    async with serving(app, trusted_proxies="127.0.0.1") as edge, httpx2.AsyncClient(trust_env=False) as http:
        for scheme in ("http", "https"):  # from a proxy that speaks TLS, whose own matter it is
            answer = await http.get(edge.url, headers={"X-Forwarded-Proto": scheme})
            assert answer.text == scheme
            assert HSTS not in answer.headers
        assert HSTS.encode() not in (await edge.ask(b"what is this\r\n\r\n")).lower()


async def test_websockets(authority: Authority, pair: Pair) -> None:
    async with serving(app, **pair.settings) as edge:
        async with connect(f"{edge.websocket}/ws", ssl=authority.context()) as socket:
            await socket.send("x" * 100_000)
            assert await socket.recv() == "wss " + "x" * 100_000
        with pytest.raises(InvalidStatus) as refused:
            async with connect(
                f"{edge.websocket}/ws", ssl=authority.context(), additional_headers={"Sec-WebSocket-Version": "7"}
            ):
                pass
        assert HSTS in refused.value.response.headers


async def test_what_is_no_request_is_refused_with_all_headers(authority: Authority, pair: Pair) -> None:
    async with serving(app, **pair.settings) as edge, reader(edge, authority.context()) as (answer, writer):
        writer.write(b"what is this\r\n\r\n")
        head = (await asyncio.wait_for(answer.readuntil(b"\r\n\r\n"), PATIENCE)).lower()
        assert head.startswith(b"http/1.1 400")
        assert HSTS.encode() in head


async def test_the_answer_reaches_a_client_that_still_sends(authority: Authority, pair: Pair) -> None:
    async with serving(app, **pair.settings) as edge, reader(edge, authority.context()) as (answer, writer):
        writer.write(b"POST /refuse HTTP/1.1\r\n" + HOST + b"Content-Length: 3000000\r\n\r\n")
        writer.write(LARGE)
        await asyncio.wait_for(writer.drain(), PATIENCE)
        assert (await asyncio.wait_for(answer.readuntil(b"\r\n"), PATIENCE)).startswith(b"HTTP/1.1 413")


@pytest.mark.parametrize(
    "sent",
    [
        b"GET / HTTP/1.1\r\n" + HOST + b"\r\n",
        b"POST /stop HTTP/1.1\r\n" + HOST + b"Content-Length: 2\r\n\r\n{}",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        b"x",
    ],
)
async def test_plain_http_is_told_to_use_https(pair: Pair, sent: bytes) -> None:
    async with serving(app, **pair.settings) as edge:
        head, _, body = (await edge.ask(sent)).partition(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 400 ")
        assert HSTS.encode() not in head.lower()
        problem = orjson.loads(body)
        assert problem["code"] == "tls_required"
        assert "use https://" in problem["detail"]


async def test_clients_that_complete_no_handshake_are_dropped_and_others_are_served(
    authority: Authority, pair: Pair
) -> None:
    """More of them than are accepted in one turn of the loop."""
    async with serving(app, **pair.settings, header_timeout=3) as edge, client(edge, authority.context()) as http:
        silent = [await asyncio.open_connection("127.0.0.1", edge.port) for _ in range(100)]
        for number, (_, writer) in enumerate(silent):
            writer.write((b"", b"\x16", b"\x16\x03\x01\x02\x00\x01")[number % 3])
        assert (await http.get("/")).status_code == 200
        for answer, writer in silent:
            assert await asyncio.wait_for(answer.read(), PATIENCE) == b""
            writer.close()
        assert (await http.get("/")).status_code == 200


async def test_clients_that_complete_no_handshake_take_no_place_from_others(authority: Authority, pair: Pair) -> None:
    limits = {"max_connections": 32, "max_connections_per_address": 8, "header_timeout": 60}
    async with serving(app, **pair.settings, **limits) as edge:
        silent = [await asyncio.open_connection("127.0.0.1", edge.port) for _ in range(40)]
        async with client(edge, authority.context()) as http:
            assert (await http.get("/")).text == "https"
        closed = [answer for answer, _ in silent if answer.at_eof()]
        assert len(closed) >= 40 - 8 - 8
        for _, writer in silent:
            writer.close()


async def test_a_client_that_leaves_before_or_in_its_handshake_is_forgotten(authority: Authority, pair: Pair) -> None:
    """Only connections that are not in the reserve may have a WebSocket."""
    limits = {"max_connections": 32, "max_connections_per_address": 8, "header_timeout": 60}
    async with serving(app, **pair.settings, **limits) as edge:
        for number in range(30):
            _, writer = await asyncio.open_connection("127.0.0.1", edge.port)
            writer.write((b"", b"\x16", b"\x16\x03\x01\x00\x01\x00")[number % 3])
            await writer.drain()
            writer.transport.abort()
        async with asyncio.timeout(PATIENCE):
            for _ in range(8):
                socket = None
                while socket is None:
                    with suppress(InvalidStatus):
                        socket = await connect(f"{edge.websocket}/ws", ssl=authority.context())
                await socket.close()


async def test_an_old_version_of_tls_is_refused(authority: Authority, pair: Pair) -> None:
    context = authority.context()
    context.set_ciphers("DEFAULT@SECLEVEL=0")
    with pytest.warns(DeprecationWarning, match="deprecated"):
        context.minimum_version = ssl.TLSVersion.TLSv1_1
    with pytest.warns(DeprecationWarning, match="deprecated"):
        context.maximum_version = ssl.TLSVersion.TLSv1_1
    async with serving(app, **pair.settings) as edge, client(edge, context) as http:
        with pytest.raises(httpx2.ConnectError):
            await http.get("/")


@pytest.mark.parametrize("version", [ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3])
async def test_mutual_tls(authority: Authority, pair: Pair, tmp_path: Path, version: ssl.TLSVersion) -> None:
    (folder := tmp_path / "other").mkdir()
    stranger = Authority(folder).issue("stranger")
    async with serving(app, **pair.settings, tls_client_ca=str(authority.file)) as edge:
        for own, served in ((None, False), (stranger, False), (authority.issue("robot"), True)):
            context = authority.context(own)
            context.maximum_version = version
            async with client(edge, context) as http:
                if served:
                    assert (await http.get("/")).text == "https"
                else:
                    with pytest.raises(httpx2.TransportError):
                        await http.get("/")


async def test_a_client_that_does_not_read_holds_no_more_than_without_tls(authority: Authority, pair: Pair) -> None:
    written = 0
    full = asyncio.Event()

    async def flood(websocket: WebSocket) -> None:
        nonlocal written
        await websocket.accept()
        writer = websocket.scope["extensions"]["dock_gateway.frames"]["writer"]
        frame = b"\x81\x7e\x03\xe8" + b"x" * 1000
        before = -1
        while written != before:  # until the sockets' own buffers are full, too
            before = written
            while writer.write_frame(frame):
                written += len(frame)
            await asyncio.sleep(0.2)
        transport = writer.transport
        assert transport.get_write_buffer_size() <= WRITE_BUFFER + 20_000
        full.set()
        await websocket.receive()

    flooding = Starlette(routes=[WebSocketRoute("/ws", flood), Route("/", hello)])
    async with serving(flooding, **pair.settings) as edge, reader(edge, authority.context()) as (_, writer):
        writer.write(
            b"GET /ws HTTP/1.1\r\n" + HOST + b"Upgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        )
        await asyncio.wait_for(full.wait(), PATIENCE)
        async with client(edge, authority.context()) as http:
            assert (await http.get("/")).status_code == 200


async def test_the_certificate_of_new_connections(authority: Authority, pair: Pair) -> None:
    def name(writer: asyncio.StreamWriter) -> str:
        subject = dict(item for part in writer.get_extra_info("peercert")["subject"] for item in part)
        return str(subject["commonName"])

    async with serving(app, **pair.settings) as edge, reader(edge, authority.context()) as (answer, writer):
        authority.issue("renewed", into=pair)
        assert edge.certificates is not None
        edge.certificates.refresh()
        async with reader(edge, authority.context()) as (_, new):
            assert (name(writer), name(new)) == ("gateway", "renewed")
        writer.write(b"GET / HTTP/1.1\r\n" + HOST + b"\r\n")
        assert (await asyncio.wait_for(answer.readuntil(b"\r\n"), PATIENCE)).startswith(b"HTTP/1.1 200")


@pytest.mark.parametrize(("proxies", "scheme"), [("127.0.0.1", "https"), ("127.0.0.0/8", "https"), (None, "http")])
async def test_only_trusted_proxies_say_what_the_scheme_is(proxies: str | None, scheme: str) -> None:
    settings = {} if proxies is None else {"trusted_proxies": proxies}
    async with serving(app, **settings) as edge, httpx2.AsyncClient(trust_env=False) as http:
        assert (await http.get(edge.url, headers={"X-Forwarded-Proto": "https"})).text == scheme
