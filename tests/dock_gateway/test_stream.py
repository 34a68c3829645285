"""The two sides of a connection, and readers that do not read."""

import asyncio
import logging
from collections.abc import AsyncGenerator
from typing import Any

import pytest
from starlette.types import Message

from dock_gateway.api.stream import EventStream, until_one_ends

SCOPE = {"type": "http", "asgi": {"spec_version": "2.3"}}


async def never() -> Any:
    await asyncio.Event().wait()


class Chunks:
    """An endless stream that knows whether it was closed."""

    def __init__(self) -> None:
        self.closed = False

    async def __call__(self) -> AsyncGenerator[bytes]:
        try:
            while True:
                await asyncio.sleep(0)
                yield b"data: 1\n\n"
        finally:
            self.closed = True


@pytest.mark.parametrize("spec_version", ["2.3", "2.4"])
async def test_a_reader_of_server_sent_events_that_does_not_read_is_cut_off(spec_version: str) -> None:
    chunks, sent = Chunks(), list[Message]()

    async def send(message: Message) -> None:
        if len(sent) == 5:
            await never()
        sent.append(message)

    generator = chunks()
    first = await anext(generator)
    scope = {"type": "http", "asgi": {"spec_version": spec_version}}
    async with asyncio.timeout(2):
        await EventStream(first, generator, 0.05)(scope, never, send)
    assert chunks.closed
    assert sent[1]["body"] == first


async def test_the_stream_is_closed_when_its_reader_leaves() -> None:
    chunks = Chunks()
    generator = chunks()
    first = await anext(generator)

    async def receive() -> Message:
        return {"type": "http.disconnect"}

    async def send(_: Message) -> None:
        await asyncio.sleep(0)

    async with asyncio.timeout(2):
        await EventStream(first, generator, 30)(SCOPE, receive, send)
    assert chunks.closed


async def test_other_errors_of_a_stream_are_not_hidden() -> None:
    async def chunks() -> AsyncGenerator[bytes]:
        yield b"1"
        raise ZeroDivisionError

    async def send(_: Message) -> None: ...

    generator = chunks()
    with pytest.raises(ZeroDivisionError):
        await EventStream(await anext(generator), generator, 30)(SCOPE, never, send)


async def test_when_one_side_ends_the_other_is_canceled() -> None:
    ended = []

    async def side() -> None:
        try:
            await never()
        finally:
            ended.append(1)

    async with asyncio.timeout(2):
        await until_one_ends(side(), asyncio.sleep(0.01), side())
    assert len(ended) == 2


async def test_both_sides_end_with_the_connection() -> None:
    ended = []

    async def side() -> None:
        try:
            await never()
        finally:
            ended.append(1)

    both = asyncio.create_task(until_one_ends(side(), side()))
    await asyncio.sleep(0.01)
    both.cancel()
    with pytest.raises(asyncio.CancelledError):
        await both
    assert len(ended) == 2


@pytest.mark.parametrize(("error", "logged"), [(TimeoutError(), 0), (ZeroDivisionError(), 1)])
async def test_a_side_that_breaks_is_logged(caplog: pytest.LogCaptureFixture, error: Exception, logged: int) -> None:
    async def side() -> None:
        raise error

    with caplog.at_level(logging.ERROR):
        await until_one_ends(side(), never())
    assert len(caplog.records) == logged
