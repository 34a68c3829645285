"""A WebSocket of the hub itself at a site."""

from http import HTTPStatus
from typing import Self

import orjson

from dock_gateway.core.errors import GatewayError
from dock_gateway.sites.tunnel.channel import Channel, ChannelEnded
from dock_gateway.sites.tunnel.failures import SiteFailed, SiteUnreachable
from dock_gateway.sites.tunnel.frames import Accept, Close, Data, End, Head, Message


class Conversation:
    """An open WebSocket; iterate over its messages.

    Args:
        site: Name of the site, for errors.
        channel: The stream.

    Attributes:
        close_code: The code that the site has closed it with; None while it is open.
        close_reason: The reason that the site has given.
    """

    def __init__(self, site: str, channel: Channel) -> None:
        self.close_code: int | None = None
        self.close_reason = ""
        self._site = site
        self._channel = channel

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> str | bytes:
        """Wait for the next message. The iteration ends when the site has closed the WebSocket.

        Raises:
            SiteUnreachable: The connection to the site was lost.
            SiteFailed: The site has sent something else.
        """
        if self.close_code is not None:
            raise StopAsyncIteration
        try:
            frame, body = await self._channel.receive()
            if isinstance(frame, Message):
                return await self._channel.receive_message(frame, body)
        except ChannelEnded as ended:
            raise SiteUnreachable(self._site, ended.detail) from None
        if not isinstance(frame, Close):
            await self._channel.abort("malformed", f"a frame {frame.type!r} within a WebSocket")
            raise SiteFailed(f"the site {self._site} has sent something that is no message", site=self._site)
        self.close_code, self.close_reason = frame.code, frame.reason
        self._channel.finish()
        raise StopAsyncIteration

    async def send(self, message: str | bytes) -> None:
        """Send a message.

        Raises:
            SiteUnreachable: The WebSocket is closed, or the connection to the site was lost.
        """
        try:
            await self._channel.send_message(message)
        except ChannelEnded as ended:
            raise SiteUnreachable(self._site, ended.detail) from None

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Close the WebSocket. Idempotent."""
        if self._channel.ended is None:
            try:
                await self._channel.send("close", code=code, reason=reason)
            except ChannelEnded:
                return
            self._channel.finish()


async def shake_hands(site: str, channel: Channel) -> None:
    """Wait until the site has opened the WebSocket.

    Raises:
        GatewayError: It refuses it.
        ChannelEnded: The stream has ended.
    """
    frame, body = await channel.receive()
    if isinstance(frame, Accept):
        return
    if not isinstance(frame, Head):
        raise SiteFailed(f"the site {site} has answered a handshake with something else", site=site)
    status, parts = frame.status, list[bytes]()
    while not isinstance(frame, End):
        frame, body = await channel.receive()
        if isinstance(frame, Data) and len(parts) < 100:
            parts.append(body)
    channel.finish()
    raise _problem(site, status, b"".join(parts))


def _problem(site: str, status: int, body: bytes) -> GatewayError:
    try:
        problem = orjson.loads(body)
        return GatewayError(str(problem["detail"]), code=str(problem["code"]), status=HTTPStatus(status), site=site)
    except (ValueError, KeyError, TypeError):
        return SiteFailed(f"the site {site} has refused a WebSocket with status {status}", site=site)
