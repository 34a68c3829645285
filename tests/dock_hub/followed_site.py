"""A site that a hub follows."""

import asyncio
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from typing import Any

import orjson

from dock_gateway.core.event import moment, result_event, status_event
from dock_gateway.core.goal import Goal
from dock_gateway.sites.tunnel.caller import TunnelAddress
from dock_gateway.sites.tunnel.failures import SiteFailed
from tests.dock_hub.documents import ROBOT, decoded

START_NS = 1_795_780_800_000_000_000


class FakeSite:
    """What a site says on each connection, and on requests. The last connection stays."""

    address = TunnelAddress("berlin", "0" * 16)

    def __init__(self, *connections: Iterable[Any]) -> None:
        self.connections = list(connections)
        self.asked_after: list[str | None] = []
        self.goals: dict[str, Goal] = {}
        self.refusal: SiteFailed | None = None

    @asynccontextmanager
    async def events(self, after: str | None) -> AsyncIterator[AsyncIterator[str]]:
        self.asked_after.append(after)
        if self.refusal is not None:
            raise self.refusal

        async def messages() -> AsyncIterator[str]:
            for message in self.connections.pop(0):
                yield message if isinstance(message, str) else orjson.dumps(message).decode()
            if not self.connections:
                await asyncio.Event().wait()

        yield messages()

    async def get(self, path: str, query: str = "") -> tuple[int, Any]:
        if path == "/goals":
            return 200, {"goals": [decoded(goal.document()) for goal in self.goals.values()], "next_cursor": None}
        goal = self.goals.get(path.removeprefix("/goals/"))
        return (404, {}) if goal is None else (200, decoded(goal.document()))

    async def measure(self) -> float:
        return 0.001


def snapshot(*goals: Goal) -> dict[str, Any]:
    """The first message of a stream."""
    documents = [decoded(goal.document()) for goal in goals]
    said = {"goals": documents, "robots": [ROBOT], "alerts": [], "approvals": []}
    return {"type": "snapshot", "time": moment(START_NS).isoformat(), **said}


def told(goal: Goal, second: int) -> dict[str, Any]:
    """The event of how a goal is, at a second after the start."""
    make = result_event if goal.result else status_event
    document: dict[str, Any] = orjson.loads(make(goal, START_NS + second * 10**9).data)
    return document
