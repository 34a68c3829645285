"""The hub's end of the tunnel: sends requests and WebSockets to the app of a site."""

import asyncio
from collections import Counter, deque
from collections.abc import AsyncIterator, Iterable
from contextlib import ExitStack, asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

from starlette.types import Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.errors import TooManyRequests, Unavailable
from dock_gateway.core.tasks import Tasks
from dock_gateway.sites import subjects
from dock_gateway.sites.broker import Broker, NoResponder
from dock_gateway.sites.identity import content_of
from dock_gateway.sites.messages import Malformed, read_refusal
from dock_gateway.sites.seals import seal
from dock_gateway.sites.subscription import BrokerSubscription, SiteMessage
from dock_gateway.sites.tunnel.answer import Asker, TunnelAnswer
from dock_gateway.sites.tunnel.channel import Channel, ChannelEnded, Timing, piece_of
from dock_gateway.sites.tunnel.conversation import Conversation, shake_hands
from dock_gateway.sites.tunnel.failures import SiteFailed, SiteUnreachable, ended_early, refused, silent_for
from dock_gateway.sites.tunnel.forward import CLIENT_GONE, forward_http, forward_websocket
from dock_gateway.sites.tunnel.frames import STOP, encode
from dock_gateway.sites.tunnel.headers import write_request_headers

# Streams of clients at the same time: in all, and of one site, which takes some more, for the hub itself.
MAX_STREAMS, MAX_STREAMS_OF_SITE = 5_000, 450
# Streams that have just ended, and whose last frames may still be on their way.
REMEMBERED = 1_000


@dataclass(frozen=True)
class TunnelAddress:
    """A process of a site's gateway."""

    site: str
    instance: str


class Caller:
    """All streams from the hub to its sites, from `open` until `close`.

    Args:
        broker: The connection to the broker.
        timing: When a site counts as gone.
        max_streams: Maximum number of streams at the same time, in all and of one site, beyond which only the hub
            itself opens more, and only stops are passed on.
        patience: Seconds for which a request is retried while no site takes it: a site says hello a little before it
            listens, and servers of a cluster do not know at once of all that listen.

    Attributes:
        keys: What requests to a process of a site are sealed with, where that is agreed.
    """

    def __init__(
        self,
        broker: Broker,
        *,
        timing: Timing | None = None,
        max_streams: tuple[int, int] = (MAX_STREAMS, MAX_STREAMS_OF_SITE),
        patience: float = 1.0,
    ) -> None:
        self.keys: dict[TunnelAddress, bytes] = {}
        self._broker = broker
        self._timing = timing or Timing()
        self._max_streams = max_streams
        self._patience = patience
        self._channels: dict[tuple[str, str], Channel] = {}
        self._past = deque[tuple[str, str]](maxlen=REMEMBERED)
        self._of_site: Counter[str] = Counter()
        self._tasks = Tasks("ending streams of sites")
        self._listening = ExitStack()
        self._subscriptions: dict[str, BrokerSubscription] = {}  # by site
        self._subscribing = asyncio.Lock()

    @property
    def streams(self) -> int:
        """Number of open streams."""
        return len(self._channels)

    async def open(self) -> None:
        """Begin. A site is listened to from its first request on."""
        self._listening.enter_context(self._broker.on_loss.adding(self._lose_all))

    async def close(self) -> None:
        """End all streams."""
        self._listening.close()
        while self._subscriptions:
            await self._subscriptions.popitem()[1].close()
        for channel in list(self._channels.values()):
            await channel.abort("hub_leaving", "the hub is shutting down")
        await self._tasks.close()

    def _lose_all(self) -> None:
        for channel in list(self._channels.values()):
            channel.end("broker_unavailable", "the connection to the broker was lost")

    async def _receive(self, received: SiteMessage) -> None:
        key = subjects.read_stream_to_hub(received.subject)
        if key is None:
            self._broker.refuse("malformed", received.subject, "the subject is none of the tunnel")
        elif (channel := self._channels.get(key)) is not None:
            channel.offer(received.data)
        elif key not in self._past:
            self._broker.refuse("unknown_stream", received.subject, "there is no such stream")

    # Requests.

    def content_of(self, query: str, body: bytes = b"") -> str:
        """Return what is signed of a request besides its method and path; its body only if it comes in one piece."""
        return content_of(query, body if len(body) <= piece_of(self._broker.max_payload) else None)

    async def forward(
        self,
        address: TunnelAddress,
        scope: ConnectionScope,
        receive: Receive,
        send: Send,
        *,
        path: str,
        token: str,
        deadline: float,
        headers: Iterable[tuple[bytes, bytes]] | None = None,
        own: bool = False,
    ) -> None:
        """Pass a request or a WebSocket of a client on to a site, and what it answers back.

        Args:
            address: The site.
            scope: As ASGI has it. Method, query, headers, subprotocols and client are read from it.
            receive: As ASGI has it.
            send: As ASGI has it.
            path: The path at the site, decoded.
            token: Who asks, signed.
            deadline: Seconds until the site must have begun, and without a sign of life until its answer begins.
            headers: Those of the request, if others than in the scope.
            own: Whether it is a request of the hub itself.

        Raises:
            SiteUnreachable: The site did not get the request.
            SiteTimeout: The site did not answer. Whether it has acted is not known.
            GatewayError: The site refuses it, or there are too many requests. Nothing has been sent to the client.
        """
        first = await receive()
        if first["type"] in {"http.disconnect", "websocket.disconnect"}:
            return
        client = scope.get("client")
        fields = {
            "token": token,
            "kind": scope["type"],
            "method": scope.get("method", "GET"),
            "path": path,
            "query": scope.get("query_string", b"").decode("latin-1"),
            "headers": write_request_headers(scope["headers"] if headers is None else headers),
            "subprotocols": scope.get("subprotocols") or [],
            "client": "" if client is None else client[0],
        }
        body, more = first.get("body", b""), first.get("more_body", False)
        piece = piece_of(self._broker.max_payload)
        now, rest = body[:piece], body[piece:]
        channel = await self._open(address, {**fields, "more": more or bool(rest)}, now, deadline, own=own)
        try:
            if scope["type"] == "http":
                await forward_http(address.site, channel, rest, more=more, receive=receive, send=send, silence=deadline)
            else:
                await forward_websocket(address.site, channel, scope, receive, send, deadline=deadline)
        finally:
            self._give_up(channel)

    async def request(
        self,
        address: TunnelAddress,
        method: str,
        path: str,
        *,
        token: str,
        deadline: float,
        query: str = "",
        headers: Iterable[tuple[bytes, bytes]] = (),
        body: bytes = b"",
    ) -> TunnelAnswer:
        """Send a request of the hub itself, and return the whole answer.

        Args:
            address: The site.
            method: Such as `POST`.
            path: The path at the site, decoded.
            token: Who asks, signed.
            deadline: Seconds until the answer must be there.
            query: The query, encoded.
            headers: More headers.
            body: The body.

        Raises:
            SiteUnreachable: The site did not get the request.
            SiteTimeout: The site did not answer in time. Whether it has acted is not known.
            GatewayError: The site refuses it, or there are too many requests.
        """
        scope = {"type": "http", "method": method, "query_string": query.encode(), "headers": list(headers)}
        client = Asker(address.site, body)
        try:
            async with asyncio.timeout(deadline):
                await self.forward(
                    address, scope, client.receive, client.send, path=path, token=token, deadline=deadline, own=True
                )
        except TimeoutError:
            raise silent_for(address.site, deadline) from None
        return client.answer

    @asynccontextmanager
    async def websocket(
        self, address: TunnelAddress, path: str, *, token: str, query: str = "", deadline: float = 10.0
    ) -> AsyncIterator[Conversation]:
        """Open a WebSocket of the hub itself, and close it at the end.

        Args:
            address: The site.
            path: The path at the site, decoded.
            token: Who asks, signed, for the method GET.
            query: The query, encoded.
            deadline: Seconds until the WebSocket must be open.

        Raises:
            SiteUnreachable: The site did not get the request.
            SiteTimeout: The site did not answer in time.
            GatewayError: The site refuses it.
        """
        fields = {"token": token, "kind": "websocket", "method": "GET", "path": path, "query": query}
        channel = await self._open(address, fields, b"", deadline, own=True)
        try:
            try:
                async with asyncio.timeout(deadline):
                    await shake_hands(address.site, channel)
            except ChannelEnded as ended:
                raise ended_early(address.site, ended) from None
            except TimeoutError:
                raise silent_for(address.site, deadline) from None
            conversation = Conversation(address.site, channel)
            yield conversation
            await conversation.close()
        finally:
            self._give_up(channel)

    async def _open(
        self, address: TunnelAddress, fields: dict[str, Any], body: bytes, deadline: float, *, own: bool
    ) -> Channel:
        most, most_of_site = self._max_streams
        full = len(self._channels) >= most or self._of_site[address.site] >= most_of_site
        if full and not own and (fields["method"], fields["path"]) != STOP:
            raise TooManyRequests(
                f"too many requests to the site {address.site} at the same time", code="too_many_streams"
            )
        stream = subjects.new_id()
        await self._listen(address.site)
        channel = self._channel(address, stream)
        subject = subjects.open_stream(address.site, address.instance)
        try:
            message = encode({"id": stream, **fields}, body)
            if (key := self.keys.get(address)) is not None:
                message = seal(key, message)
            refusal = read_refusal(await self._deliver(subject, message, deadline))
        except Unavailable as error:
            channel.finish()
            detail = (
                "its gateway does not run or has no connection to a NATS server"
                if isinstance(error, NoResponder)
                else error.detail
            )
            raise SiteUnreachable(address.site, detail) from None
        except TimeoutError:
            self._give_up(channel)
            raise silent_for(address.site, deadline) from None
        except Malformed as error:
            self._give_up(channel)
            raise SiteFailed(f"the site {address.site} has answered with nonsense: {error.detail}") from None
        except asyncio.CancelledError:
            self._give_up(channel)
            raise
        if refusal is not None:
            channel.finish()
            raise refused(address.site, refusal)
        return channel

    async def _deliver(self, subject: str, message: bytes, deadline: float) -> bytes:
        clock = asyncio.get_running_loop().time
        until = clock() + min(self._patience, deadline)
        while True:
            try:
                return await self._broker.request(subject, message, deadline)
            except NoResponder:
                if clock() > until:
                    raise
            await asyncio.sleep(0.05)

    async def _listen(self, site: str) -> None:
        async with self._subscribing:
            if site not in self._subscriptions:
                self._subscriptions[site] = await self._broker.subscribe(subjects.streams_to_hub(site), self._receive)

    def _channel(self, address: TunnelAddress, stream: str) -> Channel:
        key = address.site, stream
        subject = subjects.stream_to_site(address.site, address.instance, stream)

        def on_end() -> None:
            del self._channels[key]
            self._past.append(key)
            self._of_site[address.site] -= 1
            if not self._of_site[address.site]:
                del self._of_site[address.site]

        self._of_site[address.site] += 1
        channel = self._channels[key] = Channel(
            partial(self._broker.publish, subject),
            max_payload=self._broker.max_payload,
            refuse=lambda reason, detail: self._broker.refuse(reason, subject, detail),
            on_end=on_end,
            timing=self._timing,
        )
        return channel

    def _give_up(self, channel: Channel) -> None:
        if channel.ended is None:
            self._tasks.spawn(channel.abort(*CLIENT_GONE))
