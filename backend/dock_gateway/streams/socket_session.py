"""One connection of a client that sends messages over a WebSocket, whatever it speaks: read, refuse, follow, close.

A door, such as `/rosbridge`, says how its messages are understood and answered. Each message is carried out in a task
of its own, up to a limit that lets stops pass.
"""

import asyncio
import logging
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from fastapi import WebSocket
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.access.authorization import subscribed
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError, TooManyRequests, fields_of_a_message
from dock_gateway.core.event import Event
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.work import SMALL
from dock_gateway.http.parts import Parts
from dock_gateway.http.problems import INTERNAL
from dock_gateway.settings import Settings
from dock_gateway.streams.connection import ClientConnection
from dock_gateway.streams.events import until_one_ends
from dock_gateway.streams.feed import end_of
from dock_gateway.streams.rights import Rights

log = logging.getLogger(__name__)

# Bytes of the long messages of a client that are in progress at a time, unless there is only one. Decoded, they take
# twenty times as much memory.
MOST_BYTES = 250_000


@dataclass
class Request:
    """A message of a client.

    Attributes:
        message: As it came.
        op: What it asks for; empty as long as that is not known.
        identity: What the client calls it by; None as long as that is not known, or by nothing.
    """

    message: Message
    op: str = ""
    identity: Any = None


class Reads:
    """Operations of one client that only read, which may take minutes: they end with its connection."""

    def __init__(self) -> None:
        self._tasks: set[asyncio.Task[Any]] = set()
        self._closed = False

    @contextmanager
    def one(self) -> Iterator[None]:
        """Run a block for as long as the client is connected.

        Raises:
            WebSocketDisconnect: It is not any more.
        """
        task = asyncio.current_task()
        if self._closed or task is None:
            raise WebSocketDisconnect
        self._tasks.add(task)
        try:
            yield
        finally:
            self._tasks.discard(task)

    def close(self) -> None:
        """End all of them."""
        self._closed = True
        for task in self._tasks:
            task.cancel()


class SocketSession(ABC):
    """One connection.

    Goals belong to the gateway: they survive a broken connection.

    Args:
        websocket: The connection.
        parts: Carry out what the client asks for.
        principal: The user who asks.

    Attributes:
        what: What the messages are called in an answer, such as `commands`.
        most: Maximum number of messages in progress; more are refused.
        most_urgent: Urgent ones in addition to them. They are never refused: beyond this, the connection is not read
            until one is answered.
        event_filter: The events that the connection itself needs. It counts as a subscriber without any, too, and is
            woken when the gateway closes or the login ends.
        connection: Sends messages.
        rights: What the user may do.
        reads: Operations that end with the connection.
        closed: Whether the connection has ended.
    """

    what = "operations"
    most = 64
    most_urgent = 64
    event_filter = EventFilter(topics=frozenset())

    def __init__(self, websocket: WebSocket, parts: Parts, principal: Principal) -> None:
        self.parts = parts
        self.connection = ClientConnection(websocket, parts[Settings].subscriber_timeout)
        self.rights = Rights(websocket.scope, parts, principal)
        self.reads = Reads()
        self.closed = False
        self._websocket = websocket

    async def serve(self, subprotocol: str | None = None) -> None:
        """Accept the connection, and run it."""
        with subscribed(self.parts, self.rights.principal, self.event_filter) as place:
            try:
                await self._websocket.accept(subprotocol)
                await self.run(place)
            finally:
                await self.close()

    async def run(self, place: Subscriber) -> None:
        """Run until the client disconnects, does not read or may no longer read, or the gateway closes."""
        await until_one_ends(self.read(), self._follow(place), *self.senders())
        await self.connection.close("too_slow")

    async def close(self) -> None:
        """End what only this client wants. Other operations in progress continue."""
        self.closed = True
        self.reads.close()
        await self.release()

    async def _follow(self, place: Subscriber) -> None:
        fanout = self.parts[Fanout]
        while not (fanout.closing or place.expelled or place.overrun):
            events, _ = await place.take(60.0)
            if not place.expelled:
                await self.on_events(events)
        await self.say_goodbye()
        await self.connection.close(end_of(place))

    # ------------------------------------------------------------------ messages

    async def read(self) -> None:
        """Carry out what the client sends, until it disconnects."""
        tasks: dict[asyncio.Task[None], int] = {}
        while (received := await self._websocket.receive())["type"] != "websocket.disconnect":
            if (message := await self.collect(received)) is None:
                continue
            size = len(message.get("text") or message.get("bytes") or b"")
            many = len(tasks) >= self.most
            long = sum(each for each in tasks.values() if each > SMALL)
            large = size > SMALL and long > 0 and long + size > MOST_BYTES
            if (many or large) and not self.is_urgent(message):
                in_progress = f"{self.most} {self.what}" if many else f"{self.what} of {MOST_BYTES:,} bytes"
                await self._refuse(Request(message), TooManyRequests(f"{in_progress} are already in progress"))
                continue
            while len(tasks) >= self.most + self.most_urgent:
                await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            task = asyncio.create_task(self.handle(message))
            tasks[task] = size
            task.add_done_callback(tasks.pop)

    async def handle(self, message: Message) -> None:
        """Carry out a message, and answer it, also if that is not possible."""
        await self.attempt(Request(message), self.carry_out)

    async def attempt(self, request: Request, work: Callable[[Request], Awaitable[None]]) -> None:
        """Do what a client asks for; tell it why if that is not possible."""
        try:
            with fields_of_a_message():
                await work(request)
        except GatewayError as error:
            await self._refuse(request, error)
        except (WebSocketDisconnect, TimeoutError) as error:
            log.debug("an answer could not be sent: %s", error)
        except Exception:
            log.exception("what a client asked for failed: %s", request.op)
            await self._refuse(request, INTERNAL)

    async def _refuse(self, request: Request, error: GatewayError) -> None:
        with suppress(WebSocketDisconnect, TimeoutError):
            await self.refuse(request, error)

    # ------------------------------------------------------------------ what a door says

    @abstractmethod
    def is_urgent(self, message: Message) -> bool:
        """Return whether a message must not be refused, as it stops something."""

    @abstractmethod
    async def carry_out(self, request: Request) -> None:
        """Understand a message, note its `op` and `identity`, do what it asks for, and answer.

        Raises:
            GatewayError: That is not possible.
        """

    @abstractmethod
    async def refuse(self, request: Request, error: GatewayError) -> None:
        """Tell the client why its message was not carried out."""

    @abstractmethod
    async def release(self) -> None:
        """End what only this client wants, such as its subscriptions."""

    async def collect(self, message: Message) -> Message | None:
        """Return a message, whole if it came in pieces; None if pieces of it are missing."""
        return message

    async def on_events(self, events: list[Event]) -> None:
        """Take events of the `event_filter`."""
        del events

    async def say_goodbye(self) -> None:
        """Send what comes last, before the connection is closed."""
        return

    def senders(self) -> Sequence[Coroutine[Any, Any, None]]:
        """Return what runs beside the reader, as long as the connection."""
        return ()
