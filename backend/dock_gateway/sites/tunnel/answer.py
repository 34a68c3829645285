"""A request of the hub itself: a client that keeps the whole answer."""

import asyncio
from collections.abc import Awaitable
from dataclasses import dataclass
from typing import Any

import orjson
from starlette.types import Message

from dock_gateway.sites.tunnel.channel import ChannelEnded
from dock_gateway.sites.tunnel.failures import SiteFailed, ended_early

# Bytes of an answer that the hub itself reads.
MAX_ANSWER = 32 * 1024 * 1024


@dataclass(frozen=True)
class TunnelAnswer:
    """The answer to a request of the hub itself."""

    status: int
    headers: dict[str, str]
    body: bytes

    def json(self) -> Any:
        """Return the body as JSON.

        Raises:
            SiteFailed: It is none.
        """
        try:
            return orjson.loads(self.body)
        except ValueError:
            raise SiteFailed("a site has answered with something that is no JSON") from None


class Asker:
    """The client, as an ASGI server would show it.

    Args:
        site: Name of the site, for errors.
        body: The body of the request.
    """

    def __init__(self, site: str, body: bytes) -> None:
        self._site = site
        self._unread = [{"type": "http.request", "body": body, "more_body": False}]
        self._status = 0
        self._headers: dict[str, str] = {}
        self._body = bytearray()
        self._complete = False

    @property
    def answer(self) -> TunnelAnswer:
        """The answer.

        Raises:
            SiteFailed: It is not complete.
        """
        if not self._complete:
            raise ended_early(self._site, ChannelEnded("incomplete", "the answer is not complete"))
        return TunnelAnswer(self._status, self._headers, bytes(self._body))

    async def receive(self) -> Message:
        """Return the request; afterwards wait, as a client does."""
        if self._unread:
            return self._unread.pop()
        never: Awaitable[Message] = asyncio.get_running_loop().create_future()
        return await never

    async def send(self, message: Message) -> None:
        """Take a part of the answer.

        Raises:
            SiteFailed: It is too large.
        """
        if message["type"] == "http.response.start":
            self._status = message["status"]
            self._headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in message["headers"]}
            return
        self._body += message["body"]
        if len(self._body) > MAX_ANSWER:
            raise SiteFailed(f"the site {self._site} has answered with more than {MAX_ANSWER} bytes", site=self._site)
        self._complete = not message["more_body"]
