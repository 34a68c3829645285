"""`/ws` without a network and without ROS; tests/system has the real one."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import orjson
import pytest
from fastapi import WebSocket

from dock_gateway.api import socket as socket_module
from dock_gateway.api.socket import Session
from dock_gateway.gateway import Gateway


class FakeWebSocket:
    """What the client says, and what it is told."""

    def __init__(self, *texts: str) -> None:
        self._texts = list(texts)
        self.told: list[dict[str, Any]] = []

    async def receive(self) -> dict[str, Any]:
        await asyncio.sleep(0.01)
        if self._texts:
            return {"type": "websocket.receive", "text": self._texts.pop(0)}
        return {"type": "websocket.disconnect"}

    async def send(self, message: dict[str, Any]) -> None:
        self.told.append(orjson.loads(message["text"]))


async def test_a_stop_does_not_wait_behind_commands_that_hang(monkeypatch: pytest.MonkeyPatch) -> None:
    released = asyncio.Event()

    async def hang(*_: object) -> dict[str, Any]:
        await released.wait()
        return {}

    async def stop(*_: object) -> dict[str, Any]:
        return {"canceling": []}

    monkeypatch.setattr(socket_module, "COMMANDS", {"send_goal": hang, "stop": stop})
    monkeypatch.setattr(socket_module, "MAX_COMMANDS", 2)
    goals = [f'{{"op": "send_goal", "id": "{number}"}}' for number in range(3)]
    websocket = FakeWebSocket(*goals, "no JSON", '{"op": "stop", "id": "stop"}')
    settings = SimpleNamespace(subscriber_timeout=1.0)
    session = Session(cast("WebSocket", websocket), cast("Gateway", SimpleNamespace(settings=settings)))
    await session._read()
    await asyncio.sleep(0.01)
    assert [(answer["op"], answer.get("code"), answer["id"]) for answer in websocket.told] == [
        ("error", "too_many_requests", None),
        ("error", "too_many_requests", None),
        ("ack", None, "stop"),
    ]
    released.set()
    await asyncio.sleep(0.01)
