"""`/ws`: commands and events on one socket. Each answer carries the id of its command.

Goals belong to the gateway: they survive a broken socket. The gateway never repeats a command.
"""

import asyncio
import logging
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from fastapi import APIRouter, Depends, WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.access.authorization import authorize_command, subscribed
from dock_gateway.access.carry_out import Fields, carry_out
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
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Role
from dock_gateway.core.json_text import decode_json
from dock_gateway.core.tasks import cancel
from dock_gateway.http.bodies import read_fields
from dock_gateway.http.operation import Audit, Operation, Scope, operation, operation_of
from dock_gateway.http.parts import AllParts, Parts
from dock_gateway.http.principal import TICKET, principal_of
from dock_gateway.http.problems import INTERNAL
from dock_gateway.http.requests import known_query
from dock_gateway.stop.order import says
from dock_gateway.streams.command_schema import SubscribeCommand, UnsubscribeCommand
from dock_gateway.streams.commands import COMMANDS, STOP, read_command
from dock_gateway.streams.events import CLOSE_CODES, send_text, until_one_ends
from dock_gateway.streams.feed import end_of, feed
from dock_gateway.streams.incoming import carry_out_all
from dock_gateway.streams.queries import read_after, read_event_filter, read_max_rate

log = logging.getLogger(__name__)

router = APIRouter()

MAX_SUBSCRIPTIONS = 32


@router.websocket("/ws", dependencies=[Depends(known_query(TICKET))])
@operation(Role.VIEWER, Scope.LISTED)
async def socket(websocket: WebSocket, parts: AllParts) -> None:
    """Receive commands, send acks and events."""
    principal = principal_of(websocket)
    session = Session(websocket, parts, principal)
    # A socket counts as a subscriber even without a subscription, and is woken at shutdown.
    with subscribed(parts, principal, EventFilter(topics=frozenset())) as place:
        try:
            await websocket.accept()
            await session.run(place)
        finally:
            await session.close()


@dataclass
class Subscription:
    """One subscription of a socket. It lasts as long as its task, which holds a place in the fan-out."""

    task: asyncio.Task[None]
    acknowledged: bool = False


class Session:
    """One connection of `/ws`.

    Args:
        websocket: The connection.
        parts: Carry out the commands.
        principal: The user who sends them.
        max_commands: Maximum number of commands in progress; more are refused.
        max_stops: Stops in addition to them. They are never refused: beyond this, the socket is not read until one is
            answered.
    """

    def __init__(
        self,
        websocket: WebSocket,
        parts: Parts,
        principal: Principal,
        *,
        max_commands: int = 64,
        max_stops: int = 64,
    ) -> None:
        self._max_commands = max_commands
        self._max_stops = max_stops
        self._websocket = websocket
        self._parts = parts
        self._principal = principal
        self._sending = asyncio.Lock()
        self._subscriptions: dict[str, Subscription] = {}
        self._closed = False

    async def run(self, place: Subscriber) -> None:
        """Run until the client disconnects, does not read or may no longer read, or the gateway closes."""
        await until_one_ends(self.read(), self._farewell(place))

    async def close(self) -> None:
        """End the subscriptions. Other commands in progress continue."""
        self._closed = True
        await cancel(*self._tasks())

    async def _farewell(self, place: Subscriber) -> None:
        while not (self._parts[Fanout].closing or place.expelled):
            await place.take(60.0)
        if tasks := self._tasks():  # each of them sends `closing` first
            await asyncio.wait(tasks)
        await self._close(end_of(place))

    def _tasks(self) -> list[asyncio.Task[None]]:
        return [subscription.task for subscription in self._subscriptions.values()]

    async def read(self) -> None:
        """Carry out what the client sends, until it disconnects."""
        await carry_out_all(
            self._websocket,
            self.handle,
            lambda _, error: self._answer_error(None, error),
            _is_stop,
            most=self._max_commands,
            most_urgent=self._max_stops,
            what="commands",
        )

    async def handle(self, received: Message) -> None:
        """Carry out one command, and answer it."""
        identity: str | None = None
        try:
            op, identity, request = _read(received)
            if op == "subscribe":
                await self._authorize(op, request)
                self.subscribe(identity, request)  # it sends its own answer
            else:
                await self._answer("ack", identity, await self._do(op, request))
        except GatewayError as error:
            await self._answer_error(identity, error)
        except (WebSocketDisconnect, TimeoutError, RuntimeError) as error:
            log.debug("an answer could not be sent: %s", error)
        except Exception:
            log.exception("a command failed")
            await self._answer_error(identity, INTERNAL)

    async def _authorize(self, op: str, fields: Fields) -> None:
        await authorize_command(self._parts, self._principal, op, OPERATIONS[op], fields)

    async def _do(self, op: str, request: Any) -> Fields:
        if op == "unsubscribe":
            await self._authorize(op, request)
            return await self.unsubscribe(request)
        command = COMMANDS.get(op)
        if command is None:
            expected = f"one of subscribe, unsubscribe, {', '.join(COMMANDS)}"
            raise InvalidField([FieldError("op", expected, f"got {op[:60]!r}")])
        return await carry_out(self._parts, self._principal, command, request, self._websocket.scope)

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
        after, max_rate = read_after(query), read_max_rate(query)
        if self._closed:
            raise Unavailable("the socket is closed", code="shutting_down")
        task = asyncio.create_task(self._run_subscription(identity, query, after, max_rate))
        self._subscriptions[identity] = Subscription(task)
        task.add_done_callback(lambda _: self._subscriptions.pop(identity))

    async def _run_subscription(
        self, identity: str, query: dict[str, str], after: str | None, max_rate: float | None
    ) -> None:
        try:
            event_filter = await read_event_filter(self._parts, query, self._principal.grant)
            with subscribed(self._parts, self._principal, event_filter) as subscriber:
                await self._answer("ack", identity, {"subscription": identity})
                self._subscriptions[identity].acknowledged = True
                async for event in feed(self._parts, subscriber, after=after, max_rate=max_rate):
                    await self._send(event.text)
                if subscriber.overrun:
                    await self._close("too_slow")
        except GatewayError as error:
            await self._answer_error(identity, error)
        except (WebSocketDisconnect, TimeoutError, RuntimeError):
            await self._close("too_slow")
        except Exception:
            log.exception("a subscription failed")
            await self._answer_error(identity, INTERNAL)

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

    async def _answer_error(self, identity: str | None, error: GatewayError) -> None:
        try:
            await self._answer("error", identity, error.problem())
        except (WebSocketDisconnect, TimeoutError, RuntimeError) as broken:
            log.debug("an answer could not be sent: %s", broken)

    async def _close(self, reason: str) -> None:
        with suppress(WebSocketDisconnect, RuntimeError):  # it is closed already
            await self._websocket.close(CLOSE_CODES[reason], reason)

    async def _send(self, text: str) -> None:
        async with self._sending:
            await send_text(self._websocket, self._parts, text)


# What each command needs, by its name.
OPERATIONS: dict[str, Operation] = {
    command.__name__: operation_of(command) for command in (Session.subscribe, Session.unsubscribe, *COMMANDS.values())
}


def _is_stop(received: Message) -> bool:
    try:
        return _read(received)[0] == STOP
    except GatewayError:
        return False


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
