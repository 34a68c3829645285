"""`/ws`: commands and events on one socket, each command answered under the caller's id.

Goals belong to the gateway: a socket that breaks takes none with it, and no command is ever repeated by us.
"""

import asyncio
import logging
from dataclasses import dataclass
from typing import Any

import orjson
from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect

from dock_gateway.api.answers import TheGateway
from dock_gateway.api.commands import COMMANDS, Fields, check_fields, read_command
from dock_gateway.api.feed import feed
from dock_gateway.api.interests import read_after, read_interest, read_max_rate
from dock_gateway.api.problems import problem_response
from dock_gateway.api.requests import known_query
from dock_gateway.api.stream import SERVICE_RESTART, TRY_AGAIN_LATER, send_text, until_one_ends
from dock_gateway.errors import Conflict, FieldError, GatewayError, InvalidField, MalformedRequest, TooManyRequests
from dock_gateway.gateway import Gateway
from dock_gateway.goals import encode
from dock_gateway.hub import Subscriber
from dock_gateway.interest import Interest
from dock_gateway.tasks import cancel

log = logging.getLogger(__name__)

router = APIRouter()

MAX_SUBSCRIPTIONS = 32
MAX_COMMANDS = 64
MAX_STOPS = 64  # beside them: a stop does not queue behind goals that an action server does not answer
SUBSCRIPTION_TEXTS = ("goal_id", "action", "robot", "include", "after")


@router.websocket("/ws")
async def socket(websocket: WebSocket, gateway: TheGateway) -> None:
    """Take commands, send acks and events."""
    try:
        await known_query()(websocket)
        # A socket counts as a subscriber, also without a subscription, and is woken for the farewell.
        place = gateway.hub.subscribe(Interest(topics=frozenset()))
    except GatewayError as error:
        await websocket.send_denial_response(problem_response(error))
        return
    session = Session(websocket, gateway)
    try:
        await websocket.accept()
        await session.run(place)
    finally:
        gateway.hub.unsubscribe(place)
        await session.close()


@dataclass(frozen=True)
class Subscription:
    """One subscription of a socket; its events flow once its ack has been sent."""

    subscriber: Subscriber
    acknowledged: asyncio.Event
    pump: asyncio.Task[None]


class Session:
    """One connection of `/ws`."""

    def __init__(self, websocket: WebSocket, gateway: Gateway) -> None:
        self._websocket = websocket
        self._gateway = gateway
        self._sending = asyncio.Lock()
        self._subscriptions: dict[str, Subscription] = {}
        self._commands: set[asyncio.Task[None]] = set()

    async def run(self, place: Subscriber) -> None:
        """Go on until the client leaves, does not read, or the gateway closes."""
        await until_one_ends(self._read(), self._farewell(place))

    async def close(self) -> None:
        """End the subscriptions; commands that are under way go on without us."""
        for identity in list(self._subscriptions):
            await self._unsubscribe(identity)

    async def _farewell(self, place: Subscriber) -> None:
        while not self._gateway.hub.closing:
            await place.take(60.0)
        await asyncio.sleep(0)  # subscriptions say `closing` first
        await self._websocket.close(SERVICE_RESTART, "shutting_down")

    async def _read(self) -> None:
        while True:
            received = await self._websocket.receive()
            if received["type"] == "websocket.disconnect":
                return
            most = MAX_COMMANDS
            if len(self._commands) >= most and _is_stop(received.get("text")):
                most += MAX_STOPS
            if len(self._commands) >= most:
                await self._answer_error(None, TooManyRequests(f"{MAX_COMMANDS} commands are under way already"))
                continue
            task = asyncio.create_task(self._handle(received.get("text")))
            self._commands.add(task)
            task.add_done_callback(self._commands.discard)

    async def _handle(self, text: str | None) -> None:
        identity: str | None = None
        try:
            op, identity, fields = read_command(_decode(text))
            await self._answer("ack", identity, await self._do(op, identity, fields))
            if op == "subscribe" and (subscription := self._subscriptions.get(identity or "")):
                subscription.acknowledged.set()
        except GatewayError as error:
            await self._answer_error(identity, error)
        except (WebSocketDisconnect, TimeoutError, RuntimeError) as error:
            log.debug("an answer could not be sent: %s", error)
        except Exception:
            log.exception("a command failed")
            await self._answer_error(identity, GatewayError("an error inside of the gateway; its log has the details"))

    async def _do(self, op: str, identity: str | None, fields: Fields) -> Fields:
        if op == "subscribe":
            return await self._subscribe(identity, fields)
        if op == "unsubscribe":
            check_fields(fields, ("subscription",))
            name = fields.get("subscription") or ""
            if name not in self._subscriptions:
                raise InvalidField([FieldError("subscription", "the id of a subscription", f"got {name[:60]!r}")])
            await self._unsubscribe(name)
            return {"subscription": name}
        command = COMMANDS.get(op)
        if command is None:
            expected = f"one of subscribe, unsubscribe, {', '.join(COMMANDS)}"
            raise InvalidField([FieldError("op", expected, f"got {op[:60]!r}")])
        return await command(self._gateway, fields)

    async def _subscribe(self, identity: str | None, fields: Fields) -> Fields:
        check_fields(fields, SUBSCRIPTION_TEXTS, ("max_rate", "feedback"))
        if not identity:
            raise InvalidField([FieldError("id", "a string, which names the subscription", "got none")])
        if identity in self._subscriptions:
            raise Conflict(f"there is a subscription {identity} already", code="subscription_exists")
        if len(self._subscriptions) >= MAX_SUBSCRIPTIONS:
            raise TooManyRequests(f"this socket has {MAX_SUBSCRIPTIONS} subscriptions already")
        query = {name: str(value) for name, value in fields.items() if value is not None}
        after, max_rate = read_after(query), read_max_rate(query)
        subscriber = self._gateway.hub.subscribe(await read_interest(self._gateway, query))
        acknowledged = asyncio.Event()
        pump = asyncio.create_task(self._pump(subscriber, acknowledged, after, max_rate))
        self._subscriptions[identity] = Subscription(subscriber, acknowledged, pump)
        return {"subscription": identity}

    async def _pump(
        self, subscriber: Subscriber, acknowledged: asyncio.Event, after: str | None, max_rate: float | None
    ) -> None:
        await acknowledged.wait()
        try:
            async for event in feed(self._gateway, subscriber, after=after, max_rate=max_rate):
                await self._send(event.text)
            if subscriber.overrun:
                await self._websocket.close(TRY_AGAIN_LATER, "too_slow")
        except (WebSocketDisconnect, TimeoutError, RuntimeError):
            await self._websocket.close(TRY_AGAIN_LATER, "too_slow")

    async def _unsubscribe(self, identity: str) -> None:
        subscription = self._subscriptions.pop(identity)
        self._gateway.hub.unsubscribe(subscription.subscriber)
        await cancel(subscription.pump)

    async def _answer(self, op: str, identity: str | None, fields: Fields) -> None:
        await self._send(encode({"op": op, "id": identity, **fields}).decode())

    async def _answer_error(self, identity: str | None, error: GatewayError) -> None:
        try:
            await self._answer("error", identity, error.problem())
        except (WebSocketDisconnect, TimeoutError, RuntimeError) as broken:
            log.debug("an answer could not be sent: %s", broken)

    async def _send(self, text: str) -> None:
        async with self._sending:
            await send_text(self._websocket, self._gateway, text)


def _is_stop(text: str | None) -> bool:
    try:
        message = _decode(text)
    except MalformedRequest:
        return False
    return isinstance(message, dict) and message.get("op") == "stop"


def _decode(text: str | None) -> Any:
    if text is None:
        raise MalformedRequest("a text message is expected, not a binary one")
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise MalformedRequest(f"the message is not JSON: {error}") from None
