"""`/ws`: commands and events on one socket. Each answer carries the id of its command.

Goals belong to the gateway: they survive a broken socket. The gateway never repeats a command.
"""

import asyncio
import logging
from dataclasses import dataclass
from functools import partial
from typing import Any

from fastapi import APIRouter, Depends, WebSocket
from starlette.types import Message

from dock_gateway.access.authorization import subscribed
from dock_gateway.access.carry_out import Fields
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import (
    Conflict,
    FieldError,
    GatewayError,
    InvalidField,
    MalformedRequest,
    TooManyRequests,
    Unavailable,
)
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Role
from dock_gateway.core.json_text import decode_json
from dock_gateway.core.tasks import cancel
from dock_gateway.http.bodies import read_fields
from dock_gateway.http.operation import Audit, Operation, Scope, operation, operation_of
from dock_gateway.http.parts import AllParts, Parts
from dock_gateway.http.principal import TICKET, principal_of
from dock_gateway.http.unexpected import known_query
from dock_gateway.stop.order import says
from dock_gateway.streams.command_schema import SubscribeCommand, UnsubscribeCommand
from dock_gateway.streams.commands import COMMANDS, STOP, read_command
from dock_gateway.streams.feed import feed
from dock_gateway.streams.queries import read_after, read_event_filter, read_max_rate
from dock_gateway.streams.socket_session import Request, SocketSession

log = logging.getLogger(__name__)

router = APIRouter()

MAX_SUBSCRIPTIONS = 32


@router.websocket("/ws", dependencies=[Depends(known_query(TICKET))])
@operation(Role.VIEWER, Scope.LISTED)
async def socket(websocket: WebSocket, parts: AllParts) -> None:
    """Receive commands, send acks and events."""
    await CommandSession(websocket, parts, principal_of(websocket)).serve()


@dataclass
class EventSubscription:
    """One subscription of a socket. It lasts as long as its task, which holds a place in the fan-out."""

    task: asyncio.Task[None]
    acknowledged: bool = False


class CommandSession(SocketSession):
    """One connection of `/ws`; arguments as those of `SocketSession`."""

    what = "commands"

    def __init__(self, websocket: WebSocket, parts: Parts, principal: Principal) -> None:
        super().__init__(websocket, parts, principal)
        self._subscriptions: dict[str, EventSubscription] = {}

    async def release(self) -> None:
        """End the subscriptions."""
        await cancel(*self._tasks())

    async def say_goodbye(self) -> None:
        """Wait for the subscriptions: each of them sends `closing` first."""
        if tasks := self._tasks():
            await asyncio.wait(tasks)

    def _tasks(self) -> list[asyncio.Task[None]]:
        return [subscription.task for subscription in self._subscriptions.values()]

    def is_urgent(self, message: Message) -> bool:
        """Return whether a message is a stop."""
        try:
            return _read(message)[0] == STOP
        except GatewayError:
            return False

    async def carry_out(self, request: Request) -> None:
        """Carry out one command, and answer it."""
        op, identity, fields = _read(request.message)
        request.identity = identity
        if op == "subscribe":
            await self.rights.require(CommandSession.subscribe, fields)
            self.subscribe(identity, fields)  # it sends its own answer
        elif op == "unsubscribe":
            await self.rights.require(CommandSession.unsubscribe, fields)
            await self._answer("ack", identity, await self.unsubscribe(fields))
        elif op in COMMANDS:
            await self._answer("ack", identity, await self.rights.command(op, fields))
        else:
            expected = f"one of subscribe, unsubscribe, {', '.join(COMMANDS)}"
            raise InvalidField([FieldError("op", expected, f"got {op[:60]!r}")])

    async def refuse(self, request: Request, error: GatewayError) -> None:
        """Answer with the error."""
        await self._answer("error", request.identity, {"error": error.problem()})

    @operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
    def subscribe(self, identity: str | None, fields: Fields) -> None:
        """Start a subscription. Nothing is awaited here, so the checks still hold when its id is registered."""
        read_fields(SubscribeCommand, {"id": identity, **fields})
        if not identity:
            raise InvalidField([FieldError("id", "a string, which names the subscription", "got none")])
        if identity in self._subscriptions:
            raise Conflict(f"the subscription {identity} already exists", code="subscription_exists")
        if len(self._subscriptions) >= MAX_SUBSCRIPTIONS:
            raise TooManyRequests(f"this socket already has {MAX_SUBSCRIPTIONS} subscriptions")
        query = {name: str(value) for name, value in fields.items() if value is not None}
        if "include" in query:
            query["include"] = ",".join(fields["include"])
        after, max_rate = read_after(query), read_max_rate(query)
        if self.closed:
            raise Unavailable("the socket is closed", code="shutting_down")
        run = partial(self._run_subscription, query, after, max_rate)
        task = asyncio.create_task(self.attempt(Request({}, "subscribe", identity), run))
        self._subscriptions[identity] = EventSubscription(task)
        task.add_done_callback(lambda _: self._subscriptions.pop(identity))

    async def _run_subscription(
        self, query: dict[str, str], after: str | None, max_rate: float | None, request: Request
    ) -> None:
        identity = request.identity
        event_filter = await read_event_filter(self.parts, query, self.rights.grant)
        with subscribed(self.parts, self.rights.principal, event_filter) as subscriber:
            await self._answer("ack", identity, {"subscription": identity})
            self._subscriptions[identity].acknowledged = True
            mark = f'{{"subscription":{encode(identity).decode()},'
            async for event in feed(self.parts, subscriber, after=after, max_rate=max_rate):
                await self._send(mark + event.text[1:])  # it is encoded once for all readers
            if subscriber.overrun:
                await self.connection.close("too_slow")

    @operation(Role.VIEWER, Scope.ANY, Audit.NEVER)
    async def unsubscribe(self, fields: Fields) -> Fields:
        """End a subscription."""
        identity = read_fields(UnsubscribeCommand, fields).subscription
        subscription = self._subscriptions.get(identity)
        if subscription is None or not subscription.acknowledged:
            raise InvalidField([FieldError("subscription", "the id of a subscription", f"got {identity[:60]!r}")])
        await cancel(subscription.task)
        return {"subscription": identity}

    async def _answer(self, op: str, identity: str | None, fields: Fields) -> None:
        await self._send(encode({"op": op, "id": identity, **fields}).decode())

    async def _send(self, text: str) -> None:
        await self.connection.send({"type": "websocket.send", "text": text})


# What each command needs, by its name.
OPERATIONS: dict[str, Operation] = {
    command.__name__: operation_of(command)
    for command in (CommandSession.subscribe, CommandSession.unsubscribe, *COMMANDS.values())
}


def _read(received: Message) -> tuple[str, str | None, Any]:
    """Return op, id and fields of a command. Of a stop that cannot be read, why not."""
    text = received.get("text")
    raw: str | bytes = (received.get("bytes") or b"") if text is None else text
    try:
        return read_command(_decode(text, raw))
    except MalformedRequest as error:
        if not says(raw, "op", STOP):
            raise
        return STOP, None, error


def _decode(text: str | None, raw: str | bytes) -> Any:
    message = decode_json(raw, "the message")
    if text is None and not (isinstance(message, dict) and message.get("op") == STOP):
        raise MalformedRequest("a text message is expected, not a binary one")
    return message
