"""Passes a client of the hub on to a stream, and the answer back: for HTTP and for WebSockets."""

import asyncio
import contextlib
import logging
import re
from typing import Any

from starlette.types import Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.tasks import Tasks
from dock_gateway.sites.tunnel.channel import FINISHED, Channel, ChannelEnded
from dock_gateway.sites.tunnel.failures import ended_early, silent_for
from dock_gateway.sites.tunnel.frames import Accept, Close, Data, End, Head, Message
from dock_gateway.sites.tunnel.headers import read_headers

log = logging.getLogger(__name__)

# Headers of an answer that go on to the client. No others: the page is the hub's, with the hub's cookies and rules.
PASSED_ON = frozenset({
    "accept-ranges", "allow", "cache-control", "content-disposition", "content-encoding", "content-language",
    "content-range", "content-type", "etag", "event-id", "expires", "last-modified", "link", "location",
    "retry-after", "vary", "x-accel-buffering", "x-request-id", "x-timestamp",
})  # fmt: skip
# Statuses of answers without a body.
BODILESS = frozenset({204, 304})
# A site's answer is never a page with scripts of the hub's origin, nor a script or a style of such a page.
ACTIVE = re.compile(r"script|css|wasm", re.IGNORECASE)
ADDED = ((b"content-security-policy", b"sandbox; default-src 'none'"), (b"x-content-type-options", b"nosniff"))
CLIENT_GONE = ("client_gone", "the client at the hub has gone")
BAD_GATEWAY, FORBIDDEN = 1014, 403


async def forward_http(
    site: str, channel: Channel, rest: bytes, *, more: bool, receive: Receive, send: Send, silence: float
) -> None:
    """Pass the rest of a request on, and the answer back. Returns at once when the client has gone.

    If the site is lost within its answer, that ends without being complete.

    Args:
        site: Name of the site, for errors.
        channel: The stream.
        rest: Bytes of the body that have been read from the client.
        more: Whether the client has more of it.
        receive: Reads from the client.
        send: Sends to the client.
        silence: Seconds without a sign of life until the answer begins, after which the site counts as gone.

    Raises:
        GatewayError: The site did not answer.
    """
    pump = Tasks("passing on a request to a site")
    pump.spawn(_pump_body(channel, rest, more=more, receive=receive))
    started = False
    try:
        try:
            frame, _ = await channel.receive_first(silence)
        except TimeoutError:
            raise silent_for(site, silence) from None
        if not isinstance(frame, Head):
            await channel.abort("malformed", f"a frame {frame.type!r} in place of the answer")
            raise ended_early(site, channel.ended or ChannelEnded(*CLIENT_GONE))
        started = True
        await send({"type": "http.response.start", "status": frame.status, "headers": _answer_headers(frame)})
        await _pass_body(channel, "http.response.body", send, empty=frame.status in BODILESS)
    except ChannelEnded as ended:
        if ended.reason != CLIENT_GONE[0]:
            if not started:
                raise ended_early(site, ended) from None
            log.info("an answer of the site %s is not complete: %s", site, ended.detail)
    except OSError:
        await channel.abort(*CLIENT_GONE)
    finally:
        await pump.close()


async def _pump_body(channel: Channel, rest: bytes, *, more: bool, receive: Receive) -> None:
    with contextlib.suppress(ChannelEnded):
        await channel.send_data(rest)
        unfinished = bool(rest) or more
        while more:
            message = await receive()
            if message["type"] == "http.disconnect":
                await channel.abort(*CLIENT_GONE)
                return
            await channel.send_data(message.get("body", b""))
            more = message.get("more_body", False)
        if unfinished:
            await channel.send("end")
        while (await receive())["type"] != "http.disconnect":
            pass
        await channel.abort(*CLIENT_GONE)


async def _pass_body(channel: Channel, kind: str, send: Send, *, empty: bool = False) -> None:
    while True:
        frame, body = await channel.receive()
        if isinstance(frame, End):
            channel.finish()
            await send({"type": kind, "body": b"", "more_body": False})
            return
        if not isinstance(frame, Data):
            await channel.abort("malformed", f"a frame {frame.type!r} within an answer")
            raise ChannelEnded("malformed", "a frame that has no place in an answer")
        if not empty:
            await send({"type": kind, "body": body, "more_body": True})


def _answer_headers(head: Head) -> list[tuple[bytes, bytes]]:
    """Return the headers for the client. The length is not one of them: the server counts what really comes."""
    passed_on = [(name, value) for name, value in head.headers if name in PASSED_ON and not _leads_away(name, value)]
    return [*read_headers(passed_on), *ADDED]


def _leads_away(name: str, value: str) -> bool:
    return (name == "location" and not value.startswith("/")) or (name == "content-type" and bool(ACTIVE.search(value)))


async def forward_websocket(
    site: str, channel: Channel, scope: ConnectionScope, receive: Receive, send: Send, *, deadline: float
) -> None:
    """Pass the messages of a WebSocket on, both ways, until either end closes it.

    Args:
        site: Name of the site, for errors.
        channel: The stream.
        scope: The client's handshake.
        receive: Reads from the client.
        send: Sends to the client.
        deadline: Seconds until the site must have answered the handshake.

    Raises:
        GatewayError: The site did not answer the handshake.
    """
    try:
        async with asyncio.timeout(deadline):
            frame, _ = await channel.receive()
    except TimeoutError:
        raise silent_for(site, deadline) from None
    except ChannelEnded as ended:
        raise ended_early(site, ended) from None
    if isinstance(frame, Accept):
        await send({"type": "websocket.accept", "subprotocol": frame.subprotocol, "headers": []})
        await _converse(channel, receive, send)
    elif isinstance(frame, Head):
        await _deny(channel, frame, scope, send)
    else:
        await channel.abort("malformed", f"a frame {frame.type!r} in place of the handshake")
        raise ended_early(site, channel.ended or ChannelEnded(*CLIENT_GONE))


async def _deny(channel: Channel, head: Head, scope: ConnectionScope, send: Send) -> None:
    if "websocket.http.response" not in (scope.get("extensions") or {}):
        channel.finish()
        await send({"type": "websocket.close", "code": 1008})
        return
    await send({"type": "websocket.http.response.start", "status": head.status, "headers": _answer_headers(head)})
    try:
        await _pass_body(channel, "websocket.http.response.body", send)
    except ChannelEnded:
        await send({"type": "websocket.http.response.body", "body": b"", "more_body": False})


async def _converse(channel: Channel, receive: Receive, send: Send) -> None:
    pump = Tasks("passing on a WebSocket to a site")
    pump.spawn(_pump_messages(channel, receive))
    try:
        while True:
            frame, body = await channel.receive()
            if isinstance(frame, Message):
                message = await channel.receive_message(frame, body)
                await send(_websocket_send(message))
            elif isinstance(frame, Close):
                channel.finish()
                await send({"type": "websocket.close", "code": frame.code, "reason": frame.reason})
                return
            else:
                await channel.abort("malformed", f"a frame {frame.type!r} within a WebSocket")
    except ChannelEnded as ended:
        if ended.reason != FINISHED:
            with contextlib.suppress(OSError):
                await send({"type": "websocket.close", "code": BAD_GATEWAY, "reason": ended.reason[:100]})
    except OSError:
        await channel.abort(*CLIENT_GONE)
    finally:
        await pump.close()


def _websocket_send(message: str | bytes) -> dict[str, Any]:
    return {"type": "websocket.send", "text" if isinstance(message, str) else "bytes": message}


async def _pump_messages(channel: Channel, receive: Receive) -> None:
    with contextlib.suppress(ChannelEnded):
        while (message := await receive())["type"] == "websocket.receive":
            text = message.get("text")
            await channel.send_message(message["bytes"] if text is None else text)
        await channel.send("close", code=message.get("code") or 1000, reason=(message.get("reason") or "")[:40])
        channel.finish()
