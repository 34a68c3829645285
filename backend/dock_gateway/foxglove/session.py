"""One connection of a viewer: tells it of the graph, reads its operations, and answers each.

What a client may do is what it may do at `/ws`.
"""

import logging
import os
from collections.abc import Awaitable, Callable, Iterable
from contextlib import nullcontext, suppress
from typing import TypeVar
from uuid import uuid4

from fastapi import WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError, NotFound, TooManyRequests
from dock_gateway.core.fanout import Fanout, FrameWriter, Subscriber
from dock_gateway.core.grant import Role
from dock_gateway.core.work import in_turns
from dock_gateway.foxglove import protocol
from dock_gateway.foxglove.graph_view import GraphView
from dock_gateway.foxglove.parameters import ClientParameters
from dock_gateway.foxglove.protocol import (
    Advertise,
    Call,
    GetParameters,
    Json,
    Level,
    ParameterNames,
    SetParameters,
    Subscribe,
    Subscription,
    Unadvertise,
    Unsubscribe,
    read_binary,
    read_operation,
)
from dock_gateway.foxglove.publications import Publications
from dock_gateway.foxglove.services import Services
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
from dock_gateway.streams.incoming import Reads, carry_out_all
from dock_gateway.streams.rights import Rights

log = logging.getLogger(__name__)

# Operations in progress, and cancels and stops in addition to them.
MAX_OPERATIONS, MAX_URGENT = 64, 64
CAPABILITIES = ("services", "parameters", "parametersSubscribe", "connectionGraph")
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
    """

    def __init__(
        self,
        websocket: WebSocket,
        parts: Parts,
        principal: Principal,
        writer: FrameWriter | None,
    ) -> None:
        self._websocket = websocket
        self._parts = parts
        self._rights = Rights(websocket.scope, parts, principal)
        self._subscriptions = Subscriptions(parts[Relays], writer)
        self._connection = ClientConnection(websocket, parts[Settings].subscriber_timeout)
        self._services = Services(parts, self._rights)
        self._publications = Publications(parts, self._rights)
        self._parameters = ClientParameters(parts, self._rights)
        self._view = GraphView(parts[GraphCache], self._rights, self._services, self._subscriptions, self._send)
        self._in_order = self._view.changing
        self._reads = Reads()
        self._closed = False

    async def run(self, place: Subscriber) -> None:
        """Run until the client disconnects, does not read or may no longer read, or the gateway closes."""
        await until_one_ends(
            self._read(),
            self._show_graph(),
            self._subscriptions.send_all(self._send_bytes),
            self._parameters.send_all(self._send_parameters),
            self._follow(place),
        )
        await self._connection.close("too_slow")

    async def close(self) -> None:
        """End the subscriptions and what only reads. Other operations in progress continue, and running goals."""
        self._closed = True
        self._reads.close()
        async with self._in_order:
            await self._subscriptions.close()
            await self._parameters.close()

    async def _follow(self, place: Subscriber) -> None:
        fanout = self._parts[Fanout]
        while not (fanout.closing or place.expelled):
            await place.take(60.0)
        await self._connection.close(end_of(place))

    async def _show_graph(self) -> None:
        publishes = self._parts[Settings].publish and self._rights.grant.role.includes(Role.OPERATOR)
        capabilities = [*CAPABILITIES, *(["clientPublish"] if publishes else [])]
        metadata = {"ROS_DISTRO": os.environ.get("ROS_DISTRO", "jazzy")}
        await self._send(protocol.server_info(capabilities, metadata, SESSION))
        await self._view.follow()

    # ------------------------------------------------------------------ operations

    async def _read(self) -> None:
        """Carry out what the client sends, until it disconnects."""
        await carry_out_all(
            self._websocket,
            self._handle,
            self._refuse,
            self._is_urgent,
            most=MAX_OPERATIONS,
            most_urgent=MAX_URGENT,
            what="operations",
        )

    async def _refuse(self, received: Message, error: TooManyRequests) -> None:
        if (call := _call_in(received)) is None:
            await self._report(error.detail)
        else:
            await self._send(protocol.service_call_failure(call, error.detail))

    def _is_urgent(self, received: Message) -> bool:
        """Whether a message stops something."""
        call = _call_in(received)
        service = None if call is None else self._services.find(call.service)
        return service is not None and service.draft.urgent

    async def _handle(self, received: Message) -> None:
        op = ""
        try:
            if (text := received.get("text")) is None:
                await self._handle_binary(received.get("bytes") or b"")
                return
            op, fields = read_operation(text)
            if op in IN_ORDER:
                async with self._in_order:
                    if not self._closed:
                        await IN_ORDER[op](self, fields)
            elif op in OTHERS:
                await OTHERS[op](self, fields)
            else:
                known = ", ".join((*IN_ORDER, *OTHERS))
                await self._report(f"unknown operation {op[:60]!r}: expected one of {known}")
        except GatewayError as error:
            await self._report(f"{op}: {error.detail}" if op else error.detail)
        except (WebSocketDisconnect, TimeoutError, RuntimeError) as error:
            log.debug("an answer could not be sent: %s", error)
        except Exception:
            log.exception("an operation failed")
            await self._report(f"{op}: {INTERNAL.detail}")

    async def _handle_binary(self, data: bytes) -> None:
        message = read_binary(data)
        if isinstance(message, Call):
            await self._call(message)
        else:
            async with self._in_order:
                await self._publications.publish(message)

    async def _call(self, call: Call) -> None:
        service = self._services.find(call.service)
        try:
            with self._reads.one() if service is not None and service.draft.reads else nullcontext():
                response = await self._services.call(call)
        except GatewayError as error:
            await self._send(protocol.service_call_failure(call, error.detail))
        except WebSocketDisconnect:
            raise
        except Exception:
            log.exception("a call of a service failed")
            await self._send(protocol.service_call_failure(call, INTERNAL.detail))
        else:
            await self._send_bytes(protocol.service_call_response(call, response))

    async def subscribe(self, fields: Json) -> None:
        """Send the messages of channels."""
        await self._each("subscribe", read_fields(Subscribe, fields).subscriptions, self._subscribe)

    async def _subscribe(self, wanted: Subscription) -> None:
        self._subscriptions.require_room()
        if (channel := self._view.channels.find(wanted.channel)) is None:
            raise NotFound(f"there is no channel {wanted.channel}", code="channel_not_found")
        await self._rights.require(Session.read_topic, {"topic": channel.topic})
        await self._subscriptions.subscribe(wanted.id, channel)

    @operation(Role.VIEWER, Scope.TOPIC, Audit.NEVER)
    def read_topic(self) -> None:
        """What a subscription needs."""

    async def unsubscribe(self, fields: Json) -> None:
        """Send no more messages of channels."""
        async for identity in in_turns(read_fields(Unsubscribe, fields).subscriptions):
            await self._subscriptions.unsubscribe(identity)

    async def advertise(self, fields: Json) -> None:
        """Prepare for messages on channels of the client."""
        await self._each("advertise", read_fields(Advertise, fields).channels, self._publications.advertise)

    async def unadvertise(self, fields: Json) -> None:
        """Forget channels of the client."""
        async for identity in in_turns(read_fields(Unadvertise, fields).channels):
            self._publications.unadvertise(identity)

    async def get_parameters(self, fields: Json) -> None:
        """Send the values of parameters."""
        request = read_fields(GetParameters, fields)
        await self._answer_parameters("getParameters", request.names, request.id, [])

    async def set_parameters(self, fields: Json) -> None:
        """Set parameters, then send their values."""
        request = read_fields(SetParameters, fields)
        errors = await self._parameters.set(request.parameters)
        names = [each.name for each in request.parameters]
        if names and request.id is not None:
            await self._answer_parameters("setParameters", names, request.id, errors)
        else:
            await self._report_all("setParameters", errors)

    async def _answer_parameters(self, op: str, names: list[str], identity: str | None, errors: list[str]) -> None:
        with self._reads.one():
            found, unknown = await self._parameters.get(names)
        await self._send(protocol.parameter_values(found, identity))
        await self._report_all(op, [*errors, *unknown])

    async def subscribe_parameters(self, fields: Json) -> None:
        """Send parameters when they change."""
        await self._parameters.subscribe(read_fields(ParameterNames, fields).names)

    async def unsubscribe_parameters(self, fields: Json) -> None:
        """Send changes of parameters no more."""
        await self._parameters.unsubscribe(read_fields(ParameterNames, fields).names)

    async def subscribe_connections(self, _: Json) -> None:
        """Send which nodes are at each topic and service, and changes of that."""
        await self._view.show_connections()

    async def unsubscribe_connections(self, _: Json) -> None:
        """Send nodes at topics and services no more."""
        self._view.hide_connections()

    async def _each(self, op: str, items: Iterable[Item], do: Callable[[Item], Awaitable[None]]) -> None:
        """Do something with each item, and report those with which it was not possible."""
        errors: list[str] = []
        async for item in in_turns(items):
            try:
                await do(item)
            except TooManyRequests as error:
                errors.append(error.detail)
                break
            except GatewayError as error:
                errors.append(error.detail)
        await self._report_all(op, errors)

    # ------------------------------------------------------------------ sending

    async def _report_all(self, op: str, errors: list[str]) -> None:
        if errors:
            more = f"; and {len(errors) - MAX_ERRORS} more" if len(errors) > MAX_ERRORS else ""
            await self._report(f"{op}: {'; '.join(errors[:MAX_ERRORS])}{more}")

    async def _report(self, error: str) -> None:
        with suppress(WebSocketDisconnect, TimeoutError, RuntimeError):
            await self._send(protocol.status(Level.error, error))

    async def _send_parameters(self, parameters: list[Json]) -> None:
        await self._send(protocol.parameter_values(parameters))

    async def _send(self, message: bytes) -> None:
        await self._connection.send({"type": "websocket.send", "text": message.decode()})

    async def _send_bytes(self, message: bytes) -> None:
        await self._connection.send({"type": "websocket.send", "bytes": message})


def _call_in(received: Message) -> Call | None:
    """Return the call of a service that a message is."""
    try:
        message = read_binary(received.get("bytes") or b"")
    except GatewayError:
        return None
    return message if isinstance(message, Call) else None


Operate = Callable[[Session, Json], Awaitable[None]]

# Operations that wait for one another.
IN_ORDER: dict[str, Operate] = {
    "subscribe": Session.subscribe,
    "unsubscribe": Session.unsubscribe,
    "advertise": Session.advertise,
    "unadvertise": Session.unadvertise,
    "subscribeParameterUpdates": Session.subscribe_parameters,
    "unsubscribeParameterUpdates": Session.unsubscribe_parameters,
    "subscribeConnectionGraph": Session.subscribe_connections,
    "unsubscribeConnectionGraph": Session.unsubscribe_connections,
}
OTHERS: dict[str, Operate] = {"getParameters": Session.get_parameters, "setParameters": Session.set_parameters}
