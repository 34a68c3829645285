"""A connection of a client that sends messages, whatever it speaks."""

import asyncio
from typing import Any

import pytest
from starlette.types import Message
from starlette.websockets import WebSocketDisconnect

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import GatewayError, NotFound
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.http.parts import Parts
from dock_gateway.http.problems import INTERNAL
from dock_gateway.settings import Settings
from dock_gateway.streams.socket_session import MOST_BYTES, Reads, Request, SocketSession


async def test_what_only_reads_ends_with_its_connection() -> None:
    reads, began = Reads(), asyncio.Event()

    async def read(*, for_ever: bool) -> None:
        with reads.one():
            if for_ever:
                began.set()
                await asyncio.Event().wait()

    await read(for_ever=False)
    reading = asyncio.create_task(read(for_ever=True))
    await began.wait()
    reads.close()
    with pytest.raises(asyncio.CancelledError):
        await reading
    with pytest.raises(WebSocketDisconnect):
        await read(for_ever=False)


class Client:
    """Sends messages as they are received, then disconnects; takes note of how it is closed."""

    def __init__(self, *texts: str) -> None:
        self.scope = {"type": "websocket"}
        self._messages = [{"type": "websocket.receive", "text": text} for text in texts]
        self.closed: list[tuple[int, str]] = []

    async def receive(self) -> Message:
        await asyncio.sleep(0)
        return self._messages.pop(0) if self._messages else {"type": "websocket.disconnect"}

    async def close(self, code: int, reason: str) -> None:
        self.closed.append((code, reason))


class Door(SocketSession):
    """Notes what it carries out, which takes until it may `go`, and what it refuses. What says `stop` is urgent."""

    what = "commands"
    most = most_urgent = 9

    def __init__(self, client: Any) -> None:
        super().__init__(client, Parts({Settings: Settings()}), ANYBODY)
        self.handled: list[str] = []
        self.refused: list[tuple[str, str]] = []
        self.go = asyncio.Event()

    def is_urgent(self, message: Message) -> bool:
        return bool(message["text"].startswith("stop"))

    async def carry_out(self, request: Request) -> None:
        request.op = request.message["text"][:4]
        self.handled.append(request.op)
        await self.go.wait()
        if request.op in FAULTS:
            raise FAULTS[request.op]

    async def refuse(self, request: Request, error: GatewayError) -> None:
        self.refused.append((request.op or request.message["text"][:4], error.detail))
        if error.detail == "gone":
            raise WebSocketDisconnect

    async def release(self) -> None:
        self.go.set()


FAULTS: dict[str, Exception] = {
    "none": NotFound("there is none"),
    "away": WebSocketDisconnect(),
    "slow": TimeoutError(),
    "odd!": RuntimeError("a defect"),
    "gone": NotFound("gone"),
}


async def test_what_is_in_progress_has_a_limit_in_bytes_that_lets_stops_pass() -> None:
    huge, large = "huge" + "x" * 2 * MOST_BYTES, "more" + "x" * MOST_BYTES
    door = Door(Client("tiny", huge, "tiny", large, "stop" + "x" * MOST_BYTES))
    await door.read()
    await asyncio.sleep(0)
    assert door.handled == ["tiny", "huge", "tiny", "stop"]  # one of any size, small ones, and what stops something
    assert door.refused == [("more", "commands of 250,000 bytes are already in progress")]
    door.go.set()


async def test_what_is_in_progress_has_a_limit_in_number_that_lets_stops_pass() -> None:
    door = Door(Client("tiny", "tiny", "stop", "more"))
    door.most = 2
    await door.read()
    await asyncio.sleep(0)
    assert door.handled == ["tiny", "tiny", "stop"]
    assert door.refused == [("more", "2 commands are already in progress")]
    door.go.set()


@pytest.mark.parametrize("op", FAULTS)
async def test_each_message_is_answered_once_unless_nobody_is_there(op: str) -> None:
    door = Door(Client())
    door.go.set()
    await door.handle({"text": op})
    why = {"none": "there is none", "odd!": INTERNAL.detail, "gone": "gone"}
    assert door.refused == [(op, why[each]) for each in [op] if each in why]


async def test_a_session_is_closed_once_with_the_reason() -> None:
    client = Client()
    fanout = Fanout(queue_limit=10)
    door = Door(client)
    door.parts.add(Fanout, fanout)
    place = fanout.subscribe(EventFilter(topics=frozenset()))
    fanout.close()
    await door.run(place)
    assert len(client.closed) == 1
    await door.close()
    assert door.closed
    assert door.go.is_set()
