"""The site's end of the tunnel: calls the site's own ASGI app for each stream that the hub opens."""

import logging
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from http import HTTPStatus
from typing import Any

from starlette.types import ASGIApp

from dock_gateway.core.errors import GatewayError, TooManyRequests, Unavailable
from dock_gateway.core.tasks import Tasks
from dock_gateway.sites import subjects
from dock_gateway.sites.broker import Broker
from dock_gateway.sites.identity import IdentityReused, content_of
from dock_gateway.sites.messages import Malformed, Refusal
from dock_gateway.sites.seals import unseal, without_seal
from dock_gateway.sites.subscription import BrokerSubscription, SiteMessage
from dock_gateway.sites.tunnel.call import HttpCall, WebSocketCall, scope_of, send_body, send_head
from dock_gateway.sites.tunnel.caller import TunnelAddress
from dock_gateway.sites.tunnel.channel import FINISHED, Channel, ChannelEnded, Timing
from dock_gateway.sites.tunnel.frames import STOP, Open, encode, read_open
from dock_gateway.sites.tunnel.unsealed import Unsealed

log = logging.getLogger(__name__)

# Streams at the same time, and requests whose stream has ended but that the app has not left yet.
MAX_STREAMS = 500
# Streams that have just ended, and whose last frames may still be on their way.
REMEMBERED = 1_000
INTERNAL = GatewayError("internal error; the site's log has the details")


class TunnelServer:
    """Serves the hub, from `open` until `close`.

    Args:
        broker: The connection to the broker.
        address: This site, and this process.
        app: Called for each stream; its scope has what `admit` returned as `hub`.
        admit: Called with the token, the method, the path and the content (`content_of`) of a request. Returns who
            asks, or raises a GatewayError: the hub gets it as the refusal.
        state: What the app's requests have as their state.
        timing: When the hub counts as gone.
        max_streams: Maximum number of streams at the same time. A stop is never one too many.

    Attributes:
        key: What the hub's messages are sealed with; None: not agreed yet. One without a valid seal waits until there
            is time to verify its signature.
        calls: Number of requests that the app has not left yet.
    """

    def __init__(
        self,
        broker: Broker,
        address: TunnelAddress,
        app: ASGIApp,
        admit: Callable[[str, str, str, str], Any],
        state: Mapping[str, Any],
        *,
        timing: Timing | None = None,
        max_streams: int = MAX_STREAMS,
    ) -> None:
        self._broker = broker
        self._address = address
        self._app = app
        self._admit = admit
        self._state = state
        self._timing = timing or Timing()
        self._max_streams = max_streams
        self._channels: dict[str, Channel] = {}
        self._past = deque[str](maxlen=REMEMBERED)
        self.key: bytes | None = None
        self.calls = 0
        self._tasks = Tasks("serving the hub")
        self._listening = ExitStack()
        self._subscriptions: list[BrokerSubscription] = []
        self._unsealed: Unsealed | None = None

    @property
    def streams(self) -> int:
        """Number of open streams."""
        return len(self._channels)

    async def open(self) -> None:
        """Begin to serve."""
        self._listening.enter_context(self._broker.on_loss.adding(self._lose_all))
        self._unsealed = Unsealed(lambda received: self._open(received, without_seal(received.data)), self._drop)
        site, instance = self._address.site, self._address.instance
        # Two, so that no frame waits for requests, nor is dropped with them.
        self._subscriptions = [
            await self._broker.subscribe(subjects.open_stream(site, instance), self._receive_open),
            await self._broker.subscribe(subjects.stream_to_site(site, instance, "*"), self._receive_frame),
        ]

    async def close(self) -> None:
        """End all streams, at the hub, too."""
        if self._unsealed is not None:
            while self._subscriptions:
                await self._subscriptions.pop().close()
            await self._unsealed.close()
            self._unsealed = None
            self._listening.close()
        for channel in list(self._channels.values()):
            await channel.abort("site_leaving", "the site is shutting down, or no longer connected to this hub")
        await self._tasks.drain()
        await self._tasks.close()

    def _lose_all(self) -> None:
        for channel in list(self._channels.values()):
            channel.end("broker_unavailable", "the connection to the broker was lost")

    async def _receive_frame(self, received: SiteMessage) -> None:
        stream = subjects.read_stream_to_site(received.subject)
        if stream is None:
            self._broker.refuse("malformed", received.subject, "the subject is none of the tunnel")
        elif (channel := self._channels.get(stream)) is not None:
            channel.offer(received.data)
        elif stream not in self._past:
            self._broker.refuse("unknown_stream", received.subject, "there is no such stream")

    async def _receive_open(self, received: SiteMessage) -> None:
        message = unseal(self.key, received.data)
        if message is not None:
            self._open(received, message)
        elif self._unsealed is not None:
            self._unsealed.put(received)

    def _drop(self, received: SiteMessage) -> None:
        self._broker.refuse("too_many_unsealed", received.subject, "too many requests wait until they are verified")

    def _open(self, received: SiteMessage, message: bytes) -> None:
        try:
            opened, body = read_open(message)
        except Malformed as error:
            self._broker.refuse(error.reason, received.subject, error.detail)
            self._answer(
                received, Refusal(code="malformed_request", detail=error.detail, status=HTTPStatus.BAD_REQUEST)
            )
            return
        if opened.id in self._channels or opened.id in self._past:
            self._broker.refuse("duplicate", received.subject, f"the stream {opened.id} was opened already")
            return
        try:
            if self.calls >= self._max_streams and (opened.method, opened.path) != STOP:
                raise TooManyRequests(f"the site serves {self._max_streams} requests already", code="too_many_streams")
            content = content_of(opened.query, None if opened.more else body)
            hub = self._admit(opened.token, opened.method, opened.path, content)
        except IdentityReused as error:  # the network has delivered the request twice
            self._broker.refuse(error.code, received.subject, error.detail)
        except GatewayError as error:
            self._broker.refuse(error.code, received.subject, error.detail)
            self._answer(received, Refusal(code=error.code, detail=error.detail, status=error.status))
        else:
            self.calls += 1
            self._tasks.spawn(self._serve(received, opened, self._channel(opened.id), body, hub))

    def _answer(self, received: SiteMessage, refusal: Refusal) -> None:
        self._tasks.spawn(received.reply(refusal.encode()))

    def _channel(self, stream: str) -> Channel:
        subject = subjects.stream_to_hub(self._address.site, stream)

        def on_end() -> None:
            del self._channels[stream]
            self._past.append(stream)

        channel = self._channels[stream] = Channel(
            partial(self._broker.publish, subject),
            max_payload=self._broker.max_payload,
            refuse=lambda reason, detail: self._broker.refuse(reason, subject, detail),
            on_end=on_end,
            timing=self._timing,
        )
        return channel

    async def _serve(self, received: SiteMessage, opened: Open, channel: Channel, body: bytes, hub: Any) -> None:
        call = HttpCall(channel, body, more=opened.more) if opened.kind == "http" else WebSocketCall(channel)
        try:
            try:
                await received.reply(encode({"ok": True}))
            except Unavailable as error:
                channel.end(error.code, error.detail)
                return
            await self._app(scope_of(opened, hub, self._state), call.receive, call.send)
            if channel.ended is None:
                await channel.abort("no_answer", "the site's application has not completed its answer")
        except Exception as error:
            if channel.ended is None or channel.ended.reason == FINISHED:
                log.exception("while handling %s %s for the hub", opened.method, opened.path)
                await self._fail(channel, answered=call.answered)
            else:  # the request was canceled
                log.debug("after the end of %s %s for the hub: %r", opened.method, opened.path, error)
        finally:
            channel.finish()
            self.calls -= 1

    async def _fail(self, channel: Channel, *, answered: bool) -> None:
        try:
            if answered:
                await channel.abort(INTERNAL.code, INTERNAL.detail)
            else:
                headers = [(b"content-type", b"application/problem+json")]
                await send_head(channel, {"status": INTERNAL.status, "headers": headers})
                await send_body(channel, {"body": encode(INTERNAL.problem()).rstrip()})
        except ChannelEnded:
            return
