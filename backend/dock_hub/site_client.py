"""The API of a site, as the hub asks it: each request is signed, for one site, one process and one path."""

import time
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager
from typing import Any, Protocol

import orjson
from starlette.types import Receive, Scope, Send

from dock_gateway.core.grant import Grant, Role
from dock_gateway.sites.identity import Signer
from dock_gateway.sites.tunnel.answer import TunnelAnswer
from dock_gateway.sites.tunnel.caller import Address, Caller
from dock_hub.fields import ForeignDocumentError

# Seconds that a site may take to begin with a request, and may show no sign of life until it answers. For a request of
# the hub itself, the answer has to be complete by then.
DEADLINE = 10.0
# What the hub itself needs at a site.
READER = Grant(Role.VIEWER)


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

    def __init__(self, caller: Caller, signer: Signer, address: Address, clock: Callable[[], float]) -> None:
        self._caller = caller
        self._signer = signer
        self.address = address
        self._clock = clock

    def sign(  # noqa: PLR0917 - what a token says
        self, method: str, path: str, query: str, body: bytes = b"", name: str | None = None, grant: Grant = READER
    ) -> str:
        """Return who asks, signed for a request that the site begins within `DEADLINE`; by default the hub itself."""
        (site, instance), now = (self.address.site, self.address.instance), self._clock()
        content = self._caller.content_of(query, body)
        return self._signer.sign(site, instance, name, grant, method, path, now, content=content, lifetime=DEADLINE)

    def events(self, after: str | None) -> AbstractAsyncContextManager[Conversation]:
        """Follow the site: a snapshot or what was missed since an event, then everything as it happens."""
        path = "/ws/feedback"
        query = "include=robots&feedback=false" + ("" if after is None else f"&after={after}")
        return self._caller.websocket(self.address, path, token=self.sign("GET", path, query), query=query)

    async def get(self, path: str, query: str = "") -> tuple[int, Any]:
        """Return the status and the document of an answer.

        Raises:
            ForeignDocumentError: It is not JSON.
            SiteUnreachable, SiteTimeout: There is no answer.
        """
        token = self.sign("GET", path, query)
        answer = await self._caller.request(self.address, "GET", path, token=token, query=query, deadline=DEADLINE)
        try:
            return answer.status, orjson.loads(answer.body)
        except orjson.JSONDecodeError:
            raise ForeignDocumentError(f"the answer to GET {path} is not JSON") from None

    async def ask(
        self, method: str, path: str, body: bytes, *, name: str | None, grant: Grant, deadline: float, query: str = ""
    ) -> TunnelAnswer:
        """Make a request for a user of the hub; return the answer.

        Args:
            method: The method.
            path: The path at the site.
            body: JSON; may be empty.
            name: Their name; None if the hub needs no login.
            grant: What they may do, in the site's own names.
            deadline: Seconds that the site may take.
            query: The query.

        Raises:
            SiteUnreachable, SiteTimeout: There is no answer.
        """
        token = self.sign(method, path, query, body, name, grant)
        headers = [(b"content-type", b"application/json")]
        return await self._caller.request(
            self.address, method, path, token=token, query=query, headers=headers, body=body, deadline=deadline
        )

    async def forward(
        self,
        scope: Scope,
        receive: Receive,
        send: Send,
        *,
        path: str,
        token: str,
        headers: list[tuple[bytes, bytes]],
        deadline: float,
    ) -> None:
        """Carry a request or a WebSocket of a client; arguments as `Caller.forward`."""
        await self._caller.forward(
            self.address, scope, receive, send, path=path, token=token, headers=headers, deadline=deadline
        )

    async def measure(self) -> float:
        """Return the seconds that a small answer takes."""
        began = time.monotonic()
        await self.get("/healthz")
        return time.monotonic() - began
