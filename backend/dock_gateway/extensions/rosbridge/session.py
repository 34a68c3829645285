"""One connection of a rosbridge client: reads its operations, and answers each.

Goals are the gateway's: they survive a broken connection. What a client may do is what it may do at `/ws`.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Coroutine, Sequence
from contextlib import AsyncExitStack, nullcontext, suppress
from functools import partial
from typing import Any

from fastapi import WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError, TooManyRequests
from dock_gateway.core.event import Event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.work import SMALL
from dock_gateway.extensions.rosbridge import rosapi
from dock_gateway.extensions.rosbridge.encoding import Payload
from dock_gateway.extensions.rosbridge.fragments import Fragment, Fragments, split
from dock_gateway.extensions.rosbridge.goals import ClientGoals, failure
from dock_gateway.extensions.rosbridge.protocol import (
    MAX_ID,
    Advertise,
    CallService,
    CancelActionGoal,
    Identity,
    Json,
    Level,
    Publish,
    SendActionGoal,
    SetLevel,
    Subscribe,
    Unadvertise,
    Unsubscribe,
    is_stop,
    read_operation,
    service_response,
    split_name,
    status,
    stop_request,
)
from dock_gateway.extensions.rosbridge.publications import RosbridgePublications
from dock_gateway.extensions.rosbridge.services import RosbridgeServices
from dock_gateway.extensions.rosbridge.subscriptions import RosbridgeSubscriptions
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.bodies import read_fields
from dock_gateway.http.edge.websocket import frame_writer
from dock_gateway.http.parts import Parts
from dock_gateway.operations.topics import subscribe
from dock_gateway.ros.messages.interfaces import full_type
from dock_gateway.ros.messages.types import kinds
from dock_gateway.settings import Settings
from dock_gateway.streams.commands import STOP
from dock_gateway.streams.socket_session import Request, SocketSession

log = logging.getLogger(__name__)

CANCEL, FRAGMENT = "cancel_action_goal", "fragment"
# One of these is in each message that stops something; the last begins a letter that is written as a number.
URGENT_WORDS = (CANCEL, STOP, "\\u")
# What asks many nodes.
PARAMETERS = "/rosapi/get_param_names"


class RosbridgeSession(SocketSession):
    """One connection.

    Args:
        websocket, parts, principal: As those of `SocketSession`.
        cancel_on_disconnect: Whether the goals of the connection are canceled when it ends.
    """

    def __init__(
        self, websocket: WebSocket, parts: Parts, principal: Principal, *, cancel_on_disconnect: bool = False
    ) -> None:
        super().__init__(websocket, parts, principal)
        writer = frame_writer(websocket)
        self._level = Level.error
        self._goals = ClientGoals(self._send)
        self._services = RosbridgeServices(parts, self.rights)
        self._publications = RosbridgePublications(parts, self.rights)
        self._subscriptions = RosbridgeSubscriptions(parts, principal, writer)
        self._framed = writer is not None
        self._in_order = asyncio.Lock()
        self._asking = asyncio.Lock()
        self._fragments = Fragments(parts[Settings].max_body_bytes)
        self._cancel_on_disconnect = cancel_on_disconnect
        self.event_filter = self._goals.event_filter

    def senders(self) -> Sequence[Coroutine[Any, Any, None]]:
        """Return what sends the messages of topics."""
        return (self._subscriptions.send_all(self._send_payload, self._report_error),)

    async def on_events(self, events: list[Event]) -> None:
        """Send what happens to the goals of the connection."""
        await self._goals.on_events(events)

    async def release(self) -> None:
        """End the subscriptions, and the goals, if that is wanted."""
        if self._cancel_on_disconnect and not self.parts[Fanout].closing:
            await asyncio.gather(*map(self._cancel, self._goals.running))
        async with self._in_order:
            await self._subscriptions.close()

    async def _cancel(self, goal: asyncio.Future[str]) -> None:
        try:
            await self.rights.cancel(await goal)
        except (GatewayError, asyncio.CancelledError) as error:
            log.info("a goal of a client that is gone was not canceled: %s", error)

    # ------------------------------------------------------------------ operations

    def is_urgent(self, message: Message) -> bool:
        """Return whether a message stops something."""
        # What has none of the words for that is not decoded: it may be long.
        text = message.get("text") or (message.get("bytes") or b"").decode(errors="replace")
        lower = text.lower()
        if not any(word in lower for word in URGENT_WORDS):
            return False
        try:
            op, _, fields = read_operation(_text(message))
        except GatewayError:
            return False
        return op == CANCEL or is_stop(op, fields)

    async def collect(self, message: Message) -> Message | None:
        """Return a message, whole if it came in pieces; None if pieces of it are missing."""
        text = _text(message)
        if FRAGMENT not in (text if isinstance(text, str) else text.decode(errors="replace")):
            return message
        identity = None
        try:
            op, identity, fields = read_operation(text)
            if op != FRAGMENT:
                return message
            whole = self._fragments.add(read_fields(Fragment, fields), identity)
        except GatewayError as error:
            await self._report(Level.error, error.detail, identity)
            return None
        return None if whole is None else {"type": message["type"], "text": whole}

    async def refuse(self, request: Request, error: GatewayError) -> None:
        """Say why in a status message."""
        text = f"{request.op}: {error.detail}" if request.op else error.detail
        if request.op or not isinstance(error, TooManyRequests):  # roslibpy does not show why
            log.info("an operation of a client of rosbridge was refused: %s", text)
        await self._report(Level.error, text, request.identity)

    async def carry_out(self, request: Request) -> None:
        """Carry out an operation."""
        text = _text(request.message)
        async with AsyncExitStack() as stack:
            # Decoded, a long message takes twenty times as much memory: it is, once it is its turn.
            long = len(text) > SMALL and not self.is_urgent(request.message)
            if long:
                await stack.enter_async_context(self._in_order)
            op, request.identity, fields = read_operation(text)
            operate = OPERATIONS.get(op)
            if operate is None:
                known = ", ".join(OPERATIONS)
                unknown = f"unknown operation {op[:60]!r}: expected one of {known}"
                await self._report(Level.error, unknown, request.identity)
                return
            request.op = op
            if op not in IN_ORDER:
                await stack.aclose()
            elif not long:
                await stack.enter_async_context(self._in_order)
            await operate(self, fields, request.identity)

    async def subscribe(self, fields: Json, identity: Identity) -> None:
        """Send the messages of a topic."""
        request = read_fields(Subscribe, fields)
        topic = self.parts[Settings].resolve(request.topic, "")
        await self.rights.require(subscribe, {"topic": topic})
        if self.closed:
            return
        type_name = full_type(request.type) if request.type else None
        await self._subscriptions.subscribe(topic, type_name, identity, request)
        await self._report(Level.info, f"subscribed to {topic}", identity)

    async def unsubscribe(self, fields: Json, identity: Identity) -> None:
        """Send no more messages of a topic."""
        topic = self.parts[Settings].resolve(read_fields(Unsubscribe, fields).topic, "")
        await self._subscriptions.unsubscribe(topic, identity)
        await self._report(Level.info, f"unsubscribed from {topic}", identity)

    async def send_action_goal(self, fields: Json, identity: Identity) -> None:
        """Send a goal, then its feedback and its end."""
        request = read_fields(SendActionGoal, fields)
        action, identity = split_name(request.action, identity)
        name = self.parts[Settings].resolve(action, "")
        try:
            submit = partial(self._submit, {"action": name, "goal": await self._goal_fields(name, request.args)})
            type_name = await self._goals.submit(request, identity, name, submit)
        except GatewayError as error:
            await self._send(failure(request, identity, error), request.fragment_size)
            return
        if request.action_type and full_type(request.action_type, "action") != type_name:
            text = f"send_action_goal: {name} has the type {type_name}, not {request.action_type[:200]}"
            await self._report(Level.warning, text, identity)

    async def _goal_fields(self, name: str, args: Any) -> Any:
        """Return the fields of a goal by name; a client may send them in order."""
        if args in (None, []):
            return {}
        if not isinstance(args, list):
            return args
        self.rights.grant.require_action(name)
        action = await self.parts[ActionRegistry].find(name)
        return dict(zip(kinds(type(action.port.goal_codec.default())), args, strict=False))

    async def _submit(self, command: Json) -> Json:
        goal: Json = (await self.rights.command("send_goal", command))["goal"]
        return goal

    async def cancel_action_goal(self, fields: Json, identity: Identity) -> None:
        """Cancel a goal of this connection."""
        _, identity = split_name(read_fields(CancelActionGoal, fields).action or "", identity)
        await self.rights.command("cancel_goal", {"goal_id": await self._goals.goal_id(identity)})

    async def call_service(self, fields: Json, identity: Identity) -> None:
        """Call a service."""
        if is_stop("call_service", fields):
            await self._stop(fields, identity)
            return
        request = read_fields(CallService, fields)
        service, identity = split_name(request.service, identity)
        service = self.parts[Settings].resolve(service, "")
        # Answers about the graph are long: one at a time waits for a client that does not read.
        async with self._asking if service in rosapi.SERVICES else nullcontext():
            await self._call(service, request, identity)

    async def _stop(self, fields: Json, identity: Identity) -> None:
        service, identity = split_name(fields["service"], identity)
        try:
            values, result = await self.rights.command(STOP, stop_request(fields)), True
        except GatewayError as error:
            values, result = error.problem(), False
        await self._send(service_response(service[:MAX_ID], identity, values, result=result))

    async def _call(self, service: str, request: CallService, identity: Identity) -> None:
        try:
            with self.reads.one() if service == PARAMETERS else nullcontext():
                values = await self._services.call(service, request)
        except GatewayError as error:
            response = service_response(request.service, identity, error.detail, result=False)
        else:
            response = service_response(request.service, identity, values)
        await self._send(response, request.fragment_size)

    async def advertise(self, fields: Json, identity: Identity) -> None:
        """Prepare for messages on a topic."""
        request = read_fields(Advertise, fields)
        topic = self.parts[Settings].resolve(request.topic, "")
        await self._publications.advertise(topic, full_type(request.type))
        await self._report(Level.info, f"advertised {topic}", identity)

    async def unadvertise(self, fields: Json, _: Identity) -> None:
        """Publish no more on a topic."""
        self._publications.unadvertise(self.parts[Settings].resolve(read_fields(Unadvertise, fields).topic, ""))

    async def publish(self, fields: Json, _: Identity) -> None:
        """Publish a message."""
        request = read_fields(Publish, fields)
        await self._publications.publish(self.parts[Settings].resolve(request.topic, ""), request.msg)

    async def set_level(self, fields: Json, _: Identity) -> None:
        """Choose which status messages are sent."""
        self._level = Level[read_fields(SetLevel, fields).level]

    # ------------------------------------------------------------------ sending

    async def _report(self, level: Level, text: str, identity: Identity) -> None:
        if level <= self._level:
            with suppress(WebSocketDisconnect, TimeoutError, RuntimeError):
                await self._send(status(level, text, identity))

    async def _report_error(self, text: str) -> None:
        await self._report(Level.error, text, None)

    async def _send(self, message: bytes, fragment_size: int | None = None) -> None:
        for piece in split(message, fragment_size):
            await self.connection.send({"type": "websocket.send", "text": piece.decode()})

    async def _send_payload(self, payload: Payload, fragment_size: int | None) -> None:
        if not payload.binary and fragment_size is not None and payload.size > fragment_size:
            await self._send(payload.data, fragment_size)
        elif self._framed:
            await self.connection.send({"type": "websocket.send", "frame": payload.frame})
        elif payload.binary:
            await self.connection.send({"type": "websocket.send", "bytes": payload.data})
        else:
            await self._send(payload.data)


Operate = Callable[[RosbridgeSession, Json, Identity], Awaitable[None]]

OPERATIONS: dict[str, Operate] = {
    operate.__name__: operate
    for operate in (
        RosbridgeSession.subscribe,
        RosbridgeSession.unsubscribe,
        RosbridgeSession.send_action_goal,
        RosbridgeSession.cancel_action_goal,
        RosbridgeSession.call_service,
        RosbridgeSession.publish,
        RosbridgeSession.advertise,
        RosbridgeSession.unadvertise,
        RosbridgeSession.set_level,
    )
}
# Operations that wait for one another.
IN_ORDER = frozenset({"subscribe", "unsubscribe", "advertise", "unadvertise", "publish", "set_level"})


def _text(received: Message) -> str | bytes:
    text: str | None = received.get("text")
    return received.get("bytes") or b"" if text is None else text
