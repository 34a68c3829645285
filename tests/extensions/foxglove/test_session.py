"""One operation may be about thousands of things: what others want is done in between."""

import asyncio

import pytest

from dock_gateway.core import work as core_work
from dock_gateway.core.errors import NotAllowed
from dock_gateway.extensions.foxglove.session import do_each

MANY = 500


async def test_others_have_their_turn_between_the_things_of_one_operation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core_work, "TURN", 0)
    turns = 0

    async def others() -> None:
        nonlocal turns
        while True:
            turns += 1
            await asyncio.sleep(0)

    async def refuse(_: int) -> None:
        raise NotAllowed("no")

    task = asyncio.create_task(others())
    errors = await do_each(range(MANY), refuse)
    task.cancel()
    assert errors == ["no"] * MANY
    assert turns >= MANY - 1
