"""One operation may be about thousands of things: what others want is done in between."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core import work as core_work
from dock_gateway.core.errors import NotAllowed
from dock_gateway.extensions.foxglove.session import FoxgloveSession

MANY = 500


async def test_others_have_their_turn_between_the_things_of_one_operation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core_work, "TURN", 0)
    turns, reported = 0, []

    async def others() -> None:
        nonlocal turns
        while True:
            turns += 1
            await asyncio.sleep(0)

    async def refuse(_: int) -> None:
        raise NotAllowed("no")

    async def report(op: str, errors: list[str]) -> None:
        reported.append((op, len(errors)))

    task = asyncio.create_task(others())
    session = cast("Any", SimpleNamespace(_report_all=report))
    await FoxgloveSession._each(session, "advertise", range(MANY), refuse)
    task.cancel()
    assert reported == [("advertise", MANY)]
    assert turns >= MANY - 1
