"""One connection of a viewer: tells it of the graph, reads its operations, and answers each.

What a client may do is what it may do at `/ws`.
"""

import asyncio
import logging
import os
from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress
from typing import TypeVar
from uuid import uuid4

from fastapi import WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError, NotFound, TooManyRequests
from dock_gateway.core.grant import Role
from dock_gateway.core.graph import Seen
from dock_gateway.core.hub import FrameWriter, Hub, Subscriber
from dock_gateway.foxglove import protocol
from dock_gateway.foxglove.channels import Channels
from dock_gateway.foxglove.protocol import (
    Json,
    Level,
    Subscribe,
    Subscription,
    Unsubscribe,
    read_binary,
    read_operation,
)
from dock_gateway.foxglove.subscriptions import Subscriptions
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.relays import Relays
from dock_gateway.http.bodies import read_fields
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.http.problems import INTERNAL
from dock_gateway.settings import Settings
from dock_gateway.streams.connection import ClientConnection
from dock_gateway.streams.events import until_one_ends
from dock_gateway.streams.feed import end_of
from dock_gateway.streams.incoming import carry_out_all
from dock_gateway.streams.rights import Rights

log = logging.getLogger(__name__)

# Operations in progress, and cancels and stops in addition to them.
MAX_OPERATIONS, MAX_URGENT = 64, 64
# Seconds between two looks at the graph.
LOOK = 2.0
# Channels in one message: a definition has kilobytes.
CHANNELS_AT_ONCE = 100
# Errors in one status message.
MAX_ERRORS = 10

# The ids of channels mean the same for as long as the gateway runs.
SESSION = uuid4().hex

Item = TypeVar("Item")


class Session:
    """One connection.

    Args:
        websocket: The connection.
        parts: Carry out the operations.
        principal: The user who sends them.
        writer: Writes frames past the queue; None if the connection cannot.
        look: Seconds between two looks at the graph.
    """

    def __init__(
        self,
        websocket: WebSocket,
        parts: Parts,
        principal: Principal,
        writer: FrameWriter | None,
        look: float = LOOK,
    ) -> None:
        self._websocket = websocket
        self._parts = parts
        self._look = look
        self._rights = Rights(websocket.scope, parts, principal)
        self._channels = Channels(principal.grant)
        self._subscriptions = Subscriptions(parts[Relays], writer)
        self._connection = ClientConnection(websocket, parts[Settings].subscriber_timeout)
        self._in_order = asyncio.Lock()
        self._closed = False

    async def run(self, place: Subscriber) -> None:
        """Run until the client disconnects, does not read or may no longer read, or the gateway closes."""
        await until_one_ends(
            self._read(), self._watch_graph(), self._subscriptions.send_all(self._send_bytes), self._follow(place)
        )
        await self._connection.close("too_slow")

    async def close(self) -> None:
        """End the subscriptions. Operations in progress continue, and goals that are running."""
        self._closed = True
        async with self._in_order:
            await self._subscriptions.close()

    async def _follow(self, place: Subscriber) -> None:
        hub = self._parts[Hub]
        while not (hub.closing or place.expelled):
            await place.take(60.0)
        await self._connection.close(end_of(place))

    # ------------------------------------------------------------------ the graph

    async def _watch_graph(self) -> None:
        """Tell the client what there is, and what has changed."""
        await self._send(protocol.server_info((), {"ROS_DISTRO": os.environ.get("ROS_DISTRO", "jazzy")}, SESSION))
        await self._send(protocol.advertise(()))
        graph, tag = self._parts[GraphCache], ""
        while True:
            try:
                view = await graph.graph()
            except GatewayError as error:
                log.info("cannot read the ROS graph: %s", error.detail)
            else:
                if view.tag != tag:
                    await self._show(view.seen)
                    tag = view.tag
            await asyncio.sleep(self._look)

    async def _show(self, seen: Seen) -> None:
        async with self._in_order:
            new, gone = await self._channels.update(seen)
            for channel in gone:
                await self._subscriptions.leave(channel)
        if gone:
            await self._send(protocol.unadvertise(channel.id for channel in gone))
        for at in range(0, len(new), CHANNELS_AT_ONCE):
            await self._send(protocol.advertise(channel.document() for channel in new[at : at + CHANNELS_AT_ONCE]))

    # ------------------------------------------------------------------ operations

    async def _read(self) -> None:
        """Carry out what the client sends, until it disconnects."""
        await carry_out_all(
            self._websocket,
            self._handle,
            self._refuse,
            lambda _: False,
            most=MAX_OPERATIONS,
            most_urgent=MAX_URGENT,
            what="operations",
        )

    async def _refuse(self, error: TooManyRequests) -> None:
        await self._report(Level.error, error.detail)

    async def _handle(self, received: Message) -> None:
        op = ""
        try:
            if (text := received.get("text")) is None:
                read_binary(received.get("bytes") or b"")
                raise NotFound("the gateway offers this client no services, and no channels to publish on")
            op, fields = read_operation(text)
            operate = OPERATIONS.get(op)
            if operate is None:
                known = ", ".join(OPERATIONS)
                await self._report(Level.error, f"unknown operation {op[:60]!r}: expected one of {known}")
                return
            async with self._in_order:
                await operate(self, fields)
        except GatewayError as error:
            await self._report(Level.error, f"{op}: {error.detail}" if op else error.detail)
        except (WebSocketDisconnect, TimeoutError, RuntimeError) as error:
            log.debug("an answer could not be sent: %s", error)
        except Exception:
            log.exception("an operation failed")
            await self._report(Level.error, f"{op}: {INTERNAL.detail}")

    async def subscribe(self, fields: Json) -> None:
        """Send the messages of channels."""
        await self._each("subscribe", read_fields(Subscribe, fields).subscriptions, self._subscribe)

    async def _subscribe(self, wanted: Subscription) -> None:
        self._subscriptions.require_room()
        if (channel := self._channels.find(wanted.channel)) is None:
            raise NotFound(f"there is no channel {wanted.channel}", code="channel_not_found")
        await self._rights.require(Session.read_topic, {"topic": channel.topic})
        if not self._closed:
            await self._subscriptions.subscribe(wanted.id, channel)

    @operation(Role.VIEWER, Scope.TOPIC, Audit.NEVER)
    def read_topic(self) -> None:
        """What a subscription needs."""

    async def unsubscribe(self, fields: Json) -> None:
        """Send no more messages of channels."""
        for identity in read_fields(Unsubscribe, fields).subscriptions:
            await self._subscriptions.unsubscribe(identity)

    async def _each(self, op: str, items: Iterable[Item], do: Callable[[Item], Awaitable[None]]) -> None:
        """Do something with each item, and report those with which it was not possible."""
        errors: list[str] = []
        for item in items:
            try:
                await do(item)
            except TooManyRequests as error:
                errors.append(error.detail)
                break
            except GatewayError as error:
                errors.append(error.detail)
        if errors:
            more = f"; and {len(errors) - MAX_ERRORS} more" if len(errors) > MAX_ERRORS else ""
            await self._report(Level.error, f"{op}: {'; '.join(errors[:MAX_ERRORS])}{more}")

    # ------------------------------------------------------------------ sending

    async def _report(self, level: Level, text: str) -> None:
        with suppress(WebSocketDisconnect, TimeoutError, RuntimeError):
            await self._send(protocol.status(level, text))

    async def _send(self, message: bytes) -> None:
        await self._connection.send({"type": "websocket.send", "text": message.decode()})

    async def _send_bytes(self, message: bytes) -> None:
        await self._connection.send({"type": "websocket.send", "bytes": message})


Operate = Callable[[Session, Json], Awaitable[None]]

OPERATIONS: dict[str, Operate] = {"subscribe": Session.subscribe, "unsubscribe": Session.unsubscribe}
