"""The API of a site. Each request is signed for its user, one site, one process and one path."""

import time
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from typing import Any, Protocol

import orjson
from starlette.types import Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.grant import Grant, Role
from dock_gateway.sites.identity import Signer
from dock_gateway.sites.tunnel.answer import TunnelAnswer
from dock_gateway.sites.tunnel.caller import Caller, TunnelAddress
from dock_hub.fields import ForeignDocumentError

# Seconds that a site may take to begin with a request, and may show no sign of life until it answers. For a request of
# the hub itself, the answer has to be complete by then.
DEADLINE = 10.0
# What the hub itself needs at a site.
READER = Grant(Role.VIEWER)
JSON = [(b"content-type", b"application/json")]


@dataclass(frozen=True)
class SiteRequest:
    """A request to a site.

    Attributes:
        method: The method.
        path: The path at the site, decoded.
        query: The query, encoded.
        body: The body.
        user: Name of the user of the hub; None for the hub itself, or if it needs no login.
        grant: What the user may do, in the site's own names.
        headers: The headers; by default those of a JSON body.
        deadline: Seconds that the site may take.
    """

    method: str
    path: str
    query: str = ""
    body: bytes = b""
    user: str | None = None
    grant: Grant = READER
    headers: list[tuple[bytes, bytes]] = field(default_factory=JSON.copy)
    deadline: float = DEADLINE


class Conversation(Protocol):
    """A WebSocket of a site."""

    def __aiter__(self) -> AsyncIterator[str | bytes]:
        """Yield the messages."""


class SiteClient:
    """One process of one site.

    Args:
        caller: Sends requests.
        signer: Signs them.
        address: The process.
        clock: Returns the time of the site's clock, in seconds since 1970.
    """

    def __init__(self, caller: Caller, signer: Signer, address: TunnelAddress, clock: Callable[[], float]) -> None:
        self._caller = caller
        self._signer = signer
        self.address = address
        self._clock = clock

    def _sign(self, request: SiteRequest) -> str:
        """Return who asks, signed for a request that the site begins within `DEADLINE`."""
        (site, instance), now = (self.address.site, self.address.instance), self._clock()
        content = self._caller.content_of(request.query, request.body)
        said = site, instance, request.user, request.grant, request.method, request.path, now
        return self._signer.sign(*said, content=content, lifetime=DEADLINE)

    async def ask(self, request: SiteRequest) -> TunnelAnswer:
        """Make a request; return the answer.

        Raises:
            SiteUnreachable, SiteTimeout: There is no answer.
        """
        return await self._caller.request(
            self.address,
            request.method,
            request.path,
            token=self._sign(request),
            query=request.query,
            headers=request.headers,
            body=request.body,
            deadline=request.deadline,
        )

    async def forward(self, request: SiteRequest, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Carry a request or a WebSocket of a client to the site, and its answer back; arguments as ASGI has them.

        Raises:
            GatewayError: As `Caller.forward`.
        """
        await self._caller.forward(
            self.address,
            {**scope, "query_string": request.query.encode("latin-1")},
            receive,
            send,
            path=request.path,
            token=self._sign(request),
            headers=request.headers,
            deadline=request.deadline,
        )

    def events(self, after: str | None) -> AbstractAsyncContextManager[Conversation]:
        """Follow the site: a snapshot or what was missed since an event, then everything as it happens."""
        query = "include=fleet&feedback=false" + ("" if after is None else f"&after={after}")
        request = SiteRequest("GET", "/ws/feedback", query)
        return self._caller.websocket(self.address, request.path, token=self._sign(request), query=query)

    async def get(self, path: str, query: str = "") -> tuple[int, Any]:
        """Return the status and the document of an answer.

        Raises:
            ForeignDocumentError: It is not JSON.
            SiteUnreachable, SiteTimeout: There is no answer.
        """
        answer = await self.ask(SiteRequest("GET", path, query, headers=[]))
        try:
            return answer.status, orjson.loads(answer.body)
        except orjson.JSONDecodeError:
            raise ForeignDocumentError(f"the answer to GET {path} is not JSON") from None

    async def measure(self) -> float:
        """Return the seconds that a small answer takes."""
        began = time.monotonic()
        await self.get("/healthz")
        return time.monotonic() - began
