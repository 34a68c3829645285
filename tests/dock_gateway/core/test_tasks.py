"""Tasks that nobody waits for."""

import asyncio
import logging

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.tasks import Tasks


async def fail(error: Exception) -> None:
    raise error


async def test_what_they_return() -> None:
    assert await Tasks("testing").spawn(asyncio.sleep(0, "done")) == "done"


async def test_what_they_raise_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    tasks = Tasks("testing")
    with caplog.at_level(logging.INFO):
        tasks.spawn(fail(RuntimeError("broken")))
        tasks.spawn(fail(Unavailable("nobody is there")))
        await asyncio.sleep(0.001)
    errors = [(record.levelname, record.message, bool(record.exc_info)) for record in caplog.records]
    assert errors == [("ERROR", "while testing", True), ("INFO", "while testing: nobody is there", False)]


async def test_what_is_repeated_goes_on_after_an_error(caplog: pytest.LogCaptureFixture) -> None:
    tasks, times, again = Tasks("testing"), 0, asyncio.Event()

    async def work() -> None:
        nonlocal times
        times += 1
        if times == 1:
            raise RuntimeError("broken")
        again.set()

    tasks.repeat(work, 0.0, "counting")
    async with asyncio.timeout(10):
        await again.wait()
    await tasks.close()
    assert [(record.levelname, record.message) for record in caplog.records] == [("ERROR", "while counting")]


async def test_they_have_ended_once_their_owner_is_closed(caplog: pytest.LogCaptureFixture) -> None:
    tasks = Tasks("testing")
    sleeping = [tasks.spawn(asyncio.sleep(60)) for _ in range(3)]
    await asyncio.sleep(0)
    await tasks.close()
    assert all(task.cancelled() for task in sleeping)
    assert caplog.records == []
    await tasks.close()  # nothing is left
