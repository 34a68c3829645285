"""One stream at a site, as an ASGI app sees it: an HTTP request or a WebSocket."""

from collections.abc import Mapping
from typing import Any
from urllib.parse import quote

from starlette.types import Message as AsgiMessage
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.access import FORWARDED
from dock_gateway.sites.tunnel.channel import Channel, ChannelEnded
from dock_gateway.sites.tunnel.frames import (
    Accept,
    Close,
    Data,
    End,
    Frame,
    Head,
    Message,
    Open,
)
from dock_gateway.sites.tunnel.headers import read_request_headers, write_answer_headers

ABNORMAL_CLOSE, FORBIDDEN = 1006, 403


def scope_of(opened: Open, principal: Any, state: Mapping[str, Any]) -> ConnectionScope:
    """Return the ASGI scope of a stream.

    Args:
        opened: What the hub asks for.
        principal: Who asks, as it was verified.
        state: The application's state.
    """
    scope: ConnectionScope = {
        "type": opened.kind,
        "asgi": {"version": "3.0", "spec_version": "2.3" if opened.kind == "http" else "2.4"},
        "http_version": "1.1",
        "scheme": "http" if opened.kind == "http" else "ws",
        "path": opened.path,
        "raw_path": quote(opened.path).encode(),
        "root_path": "",
        "query_string": opened.query.encode(),
        "headers": [(b"host", b"localhost"), *read_request_headers(opened.headers)],
        "client": (opened.client, 0),
        "server": ("localhost", 80),
        "state": dict(state),
        FORWARDED: principal,
    }
    if opened.kind == "http":
        scope.update(method=opened.method, extensions={})
    else:
        scope.update(subprotocols=opened.subprotocols, extensions={"websocket.http.response": {}})
    return scope


class HttpCall:
    """An HTTP request at the site's app.

    Args:
        channel: The stream.
        body: The first bytes of the request's body.
        more: Whether more follows.
    """

    def __init__(self, channel: Channel, body: bytes, *, more: bool) -> None:
        self.answered = False
        self._channel = channel
        self._first: bytes | None = body
        self._more = more

    async def receive(self) -> AsgiMessage:
        """Return the next part of the body, then that the client has gone."""
        if self._first is not None:
            body, self._first = self._first, None
            return {"type": "http.request", "body": body, "more_body": self._more}
        if self._more:
            try:
                frame, body = await self._channel.receive()
            except ChannelEnded:
                return {"type": "http.disconnect"}
            if isinstance(frame, Data | End):
                self._more = isinstance(frame, Data)
                return {"type": "http.request", "body": body, "more_body": self._more}
            await _unexpected(self._channel, frame)
        await self._channel.wait_ended()
        return {"type": "http.disconnect"}

    async def send(self, message: AsgiMessage) -> None:
        """Send a part of the answer.

        Raises:
            ChannelEnded: The request was canceled.
        """
        if message["type"] == "http.response.start":
            await send_head(self._channel, message)
            self.answered = True
        elif message["type"] == "http.response.body":
            await send_body(self._channel, message)


class WebSocketCall:
    """A WebSocket at the site's app."""

    def __init__(self, channel: Channel) -> None:
        self.answered = False
        self._channel = channel
        self._connected = False

    async def receive(self) -> AsgiMessage:
        """Return the handshake, then the client's messages, then that it has gone."""
        if not self._connected:
            self._connected = True
            return {"type": "websocket.connect"}
        try:
            frame, body = await self._channel.receive()
            if isinstance(frame, Message):
                message = await self._channel.receive_message(frame, body)
                return {"type": "websocket.receive", "text" if isinstance(message, str) else "bytes": message}
        except ChannelEnded as ended:
            return {"type": "websocket.disconnect", "code": ABNORMAL_CLOSE, "reason": ended.reason}
        if isinstance(frame, Close):
            self._channel.finish()
            return {"type": "websocket.disconnect", "code": frame.code, "reason": frame.reason}
        await _unexpected(self._channel, frame)
        return {"type": "websocket.disconnect", "code": ABNORMAL_CLOSE, "reason": "unexpected_frame"}

    async def send(self, message: AsgiMessage) -> None:
        """Send a message, accept or refuse the handshake, or close.

        Raises:
            ChannelEnded: The client has gone.
        """
        kind = message["type"]
        if kind == "websocket.send":
            text = message.get("text")
            await self._channel.send_message(message["bytes"] if text is None else text)
        elif kind == "websocket.accept":
            headers = write_answer_headers(message.get("headers", ()))
            await self._channel.send("accept", subprotocol=message.get("subprotocol"), headers=headers)
            self.answered = True
        elif kind == "websocket.close" and self.answered:
            reason = (message.get("reason") or "").encode()[:123].decode(errors="ignore")
            await self._channel.send("close", code=message.get("code") or 1000, reason=reason)
            self._channel.finish()
        elif kind == "websocket.close":
            await send_head(self._channel, {"status": FORBIDDEN})
            await send_body(self._channel, {})
        elif kind == "websocket.http.response.start":
            await send_head(self._channel, message)
        elif kind == "websocket.http.response.body":
            await send_body(self._channel, message)


async def send_head(channel: Channel, message: Mapping[str, Any]) -> None:
    """Send status and headers of an answer.

    Raises:
        ChannelEnded: The request was canceled.
    """
    headers = write_answer_headers(message.get("headers", ()))
    await channel.send("head", status=int(message["status"]), headers=headers)


async def send_body(channel: Channel, message: Mapping[str, Any]) -> None:
    """Send a part of the body of an answer.

    Raises:
        ChannelEnded: The request was canceled.
    """
    await channel.send_data(message.get("body", b""))
    if not message.get("more_body", False):
        await channel.send("end")
        channel.finish()


async def _unexpected(channel: Channel, frame: Frame) -> None:
    assert isinstance(frame, Head | Data | End | Accept | Message | Close)
    await channel.abort("malformed", f"a frame {frame.type!r} has no place here")
