"""The gateway's own server in front of any ASGI application, in this process and event loop."""

import asyncio
import socket
import struct
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass

import orjson
import uvicorn
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp

from dock_gateway.cli.server import Server
from dock_gateway.http.edge.certificates import Certificates, load_certificates
from dock_gateway.http.edge.forwarded import ForwardedHeaders
from dock_gateway.http.edge.options import edge_options
from dock_gateway.http.edge.security import SECURITY_HEADERS, SecurityHeaders
from dock_gateway.settings import Settings
from tests.support.waiting import PATIENCE

HOST = b"Host: localhost\r\n"


@dataclass(frozen=True)
class Edge:
    """Where it listens."""

    port: int
    scheme: str = "http"
    certificates: Certificates | None = None

    @property
    def url(self) -> str:
        return f"{self.scheme}://127.0.0.1:{self.port}"

    @property
    def websocket(self) -> str:
        return self.url.replace("http", "ws")

    @asynccontextmanager
    async def connect(
        self, address: str = "127.0.0.1"
    ) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
        """A connection from an address of this machine, whose bytes are written and read by hand."""
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port, local_addr=(address, 0))
        try:
            yield reader, writer
        finally:  # with a reset, so that nothing is left to be read of what was sent
            with suppress(OSError):
                linger = struct.pack("ii", 1, 0)
                writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
            writer.transport.abort()
            with suppress(OSError):
                await writer.wait_closed()

    async def ask(self, *pieces: bytes) -> bytes:
        """Send something and read to the end of the connection."""
        async with self.connect() as (reader, writer):
            for piece in pieces:
                writer.write(piece)
                with suppress(OSError):
                    await writer.drain()
            return await asyncio.wait_for(reader.read(), PATIENCE)


@asynccontextmanager
async def serving(app: ASGIApp, **settings: object) -> AsyncIterator[Edge]:
    """Serve an application, with settings of the gateway's."""
    checked = Settings.model_validate(settings)
    options = edge_options(checked)
    outermost = ForwardedHeaders(SecurityHeaders(app, tls=checked.tls), checked.trusted_proxies)
    config = uvicorn.Config(outermost, port=0, lifespan="off", log_config=None, server_header=False, **options)
    config.load()
    certificates = load_certificates(checked)
    server = Server(config, certificates)
    server.lifespan = config.lifespan_class(config)
    await server.startup()
    try:
        yield Edge(server.servers[0].sockets[0].getsockname()[1], "https" if checked.tls else "http", certificates)
    finally:
        server.force_exit = True
        await server.shutdown()
        while server.server_state.connections:
            for connection in server.server_state.connections:
                connection.transport.abort()
            await asyncio.sleep(0)


async def hello(request: Request) -> Response:
    """Answer what was asked for."""
    return PlainTextResponse(f"{request.method} {request.url.path}")


def code(answer: bytes) -> tuple[int, str]:
    """Status and code of a refusal, which has all headers that it needs."""
    head, _, body = answer.partition(b"\r\n\r\n")
    lines = head.decode().split("\r\n")
    headers = dict(line.split(": ", 1) for line in lines[1:])
    assert headers["Content-Type"] == "application/problem+json"
    assert headers.items() >= SECURITY_HEADERS.items()
    assert headers["Connection"] == "close"
    problem = orjson.loads(body)
    assert problem["detail"]
    return problem["status"], problem["code"]
