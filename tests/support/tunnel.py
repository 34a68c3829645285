"""Both ends of the tunnel over a real NATS server, and clients at the hub's end."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

from starlette.types import ASGIApp, Message

from dock_gateway.sites import subjects
from dock_gateway.sites.broker import Broker, BrokerOptions, open_broker
from dock_gateway.sites.tunnel.caller import Caller, TunnelAddress
from dock_gateway.sites.tunnel.channel import Timing
from dock_gateway.sites.tunnel.server import TunnelServer
from tests.support.waiting import until

SITE = "berlin"


def accept_all(token: str, method: str, path: str, _: str) -> Any:
    """Believe whatever the hub says."""
    return {"token": token, "method": method, "path": path}


def options_of(url: str, name: str) -> BrokerOptions:
    """How a site, or the hub, connects; soon after a loss."""
    return BrokerOptions((url,), None, None, name, subjects.inbox(name), waits=(0.01, 0.1))


@dataclass
class Tunnel:
    """Both ends."""

    hub: Broker
    site: Broker
    caller: Caller
    server: TunnelServer
    address: TunnelAddress


@asynccontextmanager
async def open_tunnel(
    url: str,
    app: ASGIApp,
    *,
    admit: Callable[[str, str, str, str], Any] = accept_all,
    timing: Timing | None = None,
    site_url: str = "",
    max_streams: int = 500,
) -> AsyncIterator[Tunnel]:
    """Open both ends, and wait until both are connected."""
    address = TunnelAddress(SITE, subjects.new_id())
    async with open_broker(options_of(url, "hub")) as hub, open_broker(options_of(site_url or url, SITE)) as site:
        caller = Caller(hub, timing=timing, patience=0.1)
        server = TunnelServer(
            site, address, app, admit, {"settings": "of the site"}, timing=timing, max_streams=max_streams
        )
        await caller.open()
        await server.open()
        await until(lambda: hub.connected and site.connected)
        try:
            yield Tunnel(hub, site, caller, server, address)
        finally:
            await server.close()
            await caller.close()


@dataclass
class Client:
    """A client of the hub, as its ASGI server shows it. It reads nothing while `reads` is not set."""

    kind: str = "http"
    method: str = "GET"
    query: bytes = b""
    headers: list[tuple[bytes, bytes]] = field(default_factory=list)
    subprotocols: list[str] = field(default_factory=list)
    denials: bool = True
    incoming: asyncio.Queue[Message] = field(default_factory=asyncio.Queue)
    sent: list[Message] = field(default_factory=list)
    reads: asyncio.Event = field(default_factory=asyncio.Event)

    def __post_init__(self) -> None:
        self.reads.set()
        if self.kind == "websocket":
            self.put({"type": "websocket.connect"})

    @property
    def scope(self) -> dict[str, Any]:
        """Its request, or its handshake."""
        scope = {
            "type": self.kind, "query_string": self.query, "headers": self.headers, "client": ("192.0.2.7", 4242),
            "subprotocols": self.subprotocols, "extensions": {"websocket.http.response": {}} if self.denials else {},
        }  # fmt: skip
        return scope | ({"method": self.method} if self.kind == "http" else {})

    def put(self, *messages: Message) -> None:
        """Let it send."""
        for message in messages:
            self.incoming.put_nowait(message)

    def body(self, *pieces: bytes) -> None:
        """Let it send a body."""
        for number, piece in enumerate(pieces, 1):
            self.put({"type": "http.request", "body": piece, "more_body": number < len(pieces)})

    async def send(self, message: Message) -> None:
        """Take a message of the hub."""
        await self.reads.wait()
        self.sent.append(message)

    @property
    def status(self) -> int:
        """The status of the answer; 0 if there is none yet."""
        return next((m["status"] for m in self.sent if m["type"].endswith("response.start")), 0)

    @property
    def answer(self) -> bytes:
        """What has arrived of the answer's body."""
        return b"".join(m["body"] for m in self.sent if m["type"].endswith("response.body"))

    @property
    def answer_headers(self) -> dict[str, str]:
        """The headers of the answer."""
        head = next(m for m in self.sent if m["type"].endswith("response.start"))
        return {name.decode(): value.decode() for name, value in head["headers"]}

    @property
    def complete(self) -> bool:
        """Whether the answer is complete."""
        return bool(self.sent) and self.sent[-1].get("more_body") is False

    def forward(self, tunnel: Tunnel, path: str, *, deadline: float = 60, token: str = "token") -> asyncio.Task[None]:
        """Let the hub pass it on."""
        return asyncio.create_task(
            tunnel.caller.forward(
                tunnel.address, self.scope, self.incoming.get, self.send, path=path, token=token, deadline=deadline
            )
        )
