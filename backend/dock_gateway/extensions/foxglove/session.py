"""One connection of a viewer: tells it of the graph, reads its operations, and answers each.

What a client may do is what it may do at `/ws`.
"""

import logging
import os
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Sequence
from contextlib import nullcontext, suppress
from typing import Any, TypeVar
from uuid import uuid4

from fastapi import WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError, NotFound, TooManyRequests
from dock_gateway.core.grant import Role
from dock_gateway.core.work import in_turns
from dock_gateway.extensions.foxglove import protocol
from dock_gateway.extensions.foxglove.graph_view import GraphView
from dock_gateway.extensions.foxglove.parameters import ClientParameters
from dock_gateway.extensions.foxglove.protocol import (
    Advertise,
    Call,
    ChannelSubscription,
    GetParameters,
    Json,
    Level,
    ParameterNames,
    SetParameters,
    Subscribe,
    Unadvertise,
    Unsubscribe,
    read_binary,
    read_operation,
)
from dock_gateway.extensions.foxglove.publications import FoxglovePublications
from dock_gateway.extensions.foxglove.services import FoxgloveServices
from dock_gateway.extensions.foxglove.subscriptions import FoxgloveSubscriptions
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.publishing import Publishing
from dock_gateway.http.bodies import read_fields
from dock_gateway.http.edge.websocket import frame_writer
from dock_gateway.http.parts import Parts
from dock_gateway.operations.topics import subscribe
from dock_gateway.streams.socket_session import Request, SocketSession

log = logging.getLogger(__name__)

CAPABILITIES = ("services", "parameters", "parametersSubscribe", "connectionGraph")
# Errors in one status message.
MAX_ERRORS = 10

# The ids of channels mean the same for as long as the gateway runs.
SESSION = uuid4().hex

Item = TypeVar("Item")


class FoxgloveSession(SocketSession):
    """One connection; arguments as those of `SocketSession`."""

    def __init__(self, websocket: WebSocket, parts: Parts, principal: Principal) -> None:
        super().__init__(websocket, parts, principal)
        self._subscriptions = FoxgloveSubscriptions(parts, principal, frame_writer(websocket))
        self._services = FoxgloveServices(parts, self.rights)
        self._publications = FoxglovePublications(parts, self.rights)
        self._parameters = ClientParameters(parts, self.rights)
        self._view = GraphView(parts[GraphCache], self.rights, self._services, self._subscriptions, self._send)
        self._in_order = self._view.changing

    def senders(self) -> Sequence[Coroutine[Any, Any, None]]:
        """Return what shows the graph, and sends messages of topics and parameters."""
        return (
            self._show_graph(),
            self._subscriptions.send_all(self._send_bytes),
            self._parameters.send_all(self._send_parameters),
        )

    async def release(self) -> None:
        """End the subscriptions."""
        async with self._in_order:
            await self._subscriptions.close()
            await self._parameters.close()

    async def _show_graph(self) -> None:
        publishes = self.parts[Publishing].listed and self.rights.grant.role.includes(Role.OPERATOR)
        capabilities = [*CAPABILITIES, *(["clientPublish"] if publishes else [])]
        metadata = {"ROS_DISTRO": os.environ.get("ROS_DISTRO", "jazzy")}
        await self._send(protocol.server_info(capabilities, metadata, SESSION))
        await self._view.follow()

    # ------------------------------------------------------------------ operations

    async def refuse(self, request: Request, error: GatewayError) -> None:
        """Say why in a status message, or in the answer to a call."""
        if (call := _call_in(request.message)) is not None:
            await self._send(protocol.service_call_failure(call, error.detail))
        else:
            await self._report(f"{request.op}: {error.detail}" if request.op else error.detail)

    def is_urgent(self, message: Message) -> bool:
        """Return whether a message stops something."""
        call = _call_in(message)
        service = None if call is None else self._services.find(call.service)
        return service is not None and service.draft.urgent

    async def carry_out(self, request: Request) -> None:
        """Carry out an operation."""
        if (text := request.message.get("text")) is None:
            await self._handle_binary(request.message.get("bytes") or b"")
            return
        op, fields = read_operation(text)
        if op in IN_ORDER:
            request.op = op
            async with self._in_order:
                if not self.closed:
                    await IN_ORDER[op](self, fields)
        elif op in OTHERS:
            request.op = op
            await OTHERS[op](self, fields)
        else:
            known = ", ".join((*IN_ORDER, *OTHERS))
            await self._report(f"unknown operation {op[:60]!r}: expected one of {known}")

    async def _handle_binary(self, data: bytes) -> None:
        message = read_binary(data)
        if isinstance(message, Call):
            await self._call(message)
        else:
            async with self._in_order:
                await self._publications.publish(message)

    async def _call(self, call: Call) -> None:
        service = self._services.find(call.service)
        with self.reads.one() if service is not None and service.draft.reads else nullcontext():
            response = await self._services.call(call)
        await self._send_bytes(protocol.service_call_response(call, response))

    async def subscribe(self, fields: Json) -> None:
        """Send the messages of channels."""
        errors = await do_each(read_fields(Subscribe, fields).subscriptions, self._subscribe)
        await self._report_all("subscribe", errors)

    async def _subscribe(self, wanted: ChannelSubscription) -> None:
        self._subscriptions.require_room()
        if (channel := self._view.channels.find(wanted.channel)) is None:
            raise NotFound(f"there is no channel {wanted.channel}", code="channel_not_found")
        await self.rights.require(subscribe, {"topic": channel.topic})
        await self._subscriptions.subscribe(wanted.id, channel)

    async def unsubscribe(self, fields: Json) -> None:
        """Send no more messages of channels."""
        async for identity in in_turns(read_fields(Unsubscribe, fields).subscriptions):
            await self._subscriptions.unsubscribe(identity)

    async def advertise(self, fields: Json) -> None:
        """Prepare for messages on channels of the client."""
        errors = await do_each(read_fields(Advertise, fields).channels, self._publications.advertise)
        await self._report_all("advertise", errors)

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
        with self.reads.one():
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
        await self.connection.send({"type": "websocket.send", "text": message.decode()})

    async def _send_bytes(self, message: bytes) -> None:
        await self.connection.send({"type": "websocket.send", "bytes": message})


def _call_in(received: Message) -> Call | None:
    """Return the call of a service that a message is."""
    try:
        message = read_binary(received.get("bytes") or b"")
    except GatewayError:
        return None
    return message if isinstance(message, Call) else None


Operate = Callable[[FoxgloveSession, Json], Awaitable[None]]

# Operations that wait for one another.
IN_ORDER: dict[str, Operate] = {
    "subscribe": FoxgloveSession.subscribe,
    "unsubscribe": FoxgloveSession.unsubscribe,
    "advertise": FoxgloveSession.advertise,
    "unadvertise": FoxgloveSession.unadvertise,
    "subscribeParameterUpdates": FoxgloveSession.subscribe_parameters,
    "unsubscribeParameterUpdates": FoxgloveSession.unsubscribe_parameters,
    "subscribeConnectionGraph": FoxgloveSession.subscribe_connections,
    "unsubscribeConnectionGraph": FoxgloveSession.unsubscribe_connections,
}
OTHERS: dict[str, Operate] = {
    "getParameters": FoxgloveSession.get_parameters,
    "setParameters": FoxgloveSession.set_parameters,
}


async def do_each(items: Iterable[Item], do: Callable[[Item], Awaitable[None]]) -> list[str]:
    """Do something with each item, until there are too many; others have their turn in between.

    Returns:
        Why it was not possible, for each item with which it was not.
    """
    errors: list[str] = []
    async for item in in_turns(items):
        try:
            await do(item)
        except TooManyRequests as error:
            errors.append(error.detail)
            break
        except GatewayError as error:
            errors.append(error.detail)
    return errors
