"""`/ws` without a network and without ROS; tests/system has the real one."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import orjson
import pytest
from fastapi import WebSocket

from dock_gateway.access.logins import Logins
from dock_gateway.core.access import ANYBODY
from dock_gateway.core.event import Event, notice, utc_now
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.grant import Grant, Role
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.robots.robots import Robots
from dock_gateway.settings import Settings
from dock_gateway.streams import socket as socket_module
from dock_gateway.streams.commands import COMMANDS
from dock_gateway.streams.includes import Includes
from dock_gateway.streams.socket import CommandSession
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory
from tests.support.stopping import fake_fleet
from tests.support.tracking import A
from tests.support.waiting import until


class FakeWebSocket:
    """What the client says before it leaves, if it does, and what it is told."""

    def __init__(self, *texts: str, stays: bool = False) -> None:
        self._texts = list(texts)
        self._stays = stays
        self.told: list[dict[str, Any]] = []
        self.scope = {
            "type": "websocket",
            "principal": ANYBODY,
            "state": {"parts": Parts({**audit_parts(), Includes: Includes()})},
        }

    async def receive(self) -> dict[str, Any]:
        await asyncio.sleep(0.01)
        if self._texts:
            return {"type": "websocket.receive", "text": self._texts.pop(0)}
        if self._stays:
            await asyncio.Event().wait()
        return {"type": "websocket.disconnect"}

    async def send(self, message: dict[str, Any]) -> None:
        self.told.append(orjson.loads(message["text"]))

    async def close(self, code: int, reason: str) -> None:
        self.told.append({"code": code, "reason": reason})


async def test_a_stop_does_not_wait_behind_commands_that_hang(monkeypatch: pytest.MonkeyPatch) -> None:
    released = asyncio.Event()

    @operation(Role.VIEWER, Scope.ANY, Audit.NEVER)
    async def hang(*_: object) -> dict[str, Any]:
        await released.wait()
        return {}

    @operation(Role.VIEWER, Scope.ANY, Audit.NEVER)
    async def stop(*_: object) -> dict[str, Any]:
        return {"canceling": []}

    for name, command in {"send_goal": hang, "stop": stop}.items():
        monkeypatch.setitem(COMMANDS, name, command)
    goals = [f'{{"op": "send_goal", "id": "{number}"}}' for number in range(3)]
    websocket = FakeWebSocket(*goals, "no JSON", '{"op": "stop", "id": "stop"}')
    settings = Settings(subscriber_timeout=1.0)
    parts = Parts({Settings: settings, Quotas: Quotas(settings), Logins: Logins(HistoryInMemory())})
    session = CommandSession(cast("WebSocket", websocket), parts, ANYBODY)
    session.most = 2
    await session.read()
    await asyncio.sleep(0.01)
    assert [(answer["op"], answer.get("error", {}).get("code"), answer["id"]) for answer in websocket.told] == [
        ("error", "too_many_requests", None),
        ("error", "too_many_requests", None),
        ("ack", None, "stop"),
    ]
    released.set()
    await asyncio.sleep(0.01)


class Lookups(Parts):
    """A gateway that takes its time to look up a goal."""

    def __init__(self) -> None:
        self.fanout = Fanout(queue_limit=10)
        settings = Settings(subscriber_timeout=1.0)
        super().__init__(
            {
                Settings: settings,
                Fanout: self.fanout,
                Includes: Includes(),
                Quotas: Quotas(settings),
                Logins: Logins(HistoryInMemory()),
                Goals: SimpleNamespace(get=self._goal),
                Robots: SimpleNamespace(find=lambda _: "/"),
                RobotActions: SimpleNamespace(homed_in=lambda _: frozenset()),
            }
        )

    async def _goal(self, goal_id: str, _: Grant) -> Any:
        await asyncio.sleep(0.05)
        return SimpleNamespace(goal_id=goal_id, action_name="/dock")


@pytest.fixture
def lookups(monkeypatch: pytest.MonkeyPatch) -> Lookups:
    async def feed(parts: Parts, subscriber: Subscriber, **_: object) -> AsyncIterator[Event]:
        while not parts[Fanout].closing:
            await subscriber.take(60.0)
        await asyncio.sleep(0.05)  # such as for a snapshot
        yield notice("closing", utc_now())

    monkeypatch.setattr(socket_module, "feed", feed)
    return Lookups()


def subscribe(identity: str) -> str:
    return f'{{"op": "subscribe", "id": "{identity}", "goal_id": "{A}"}}'


def session_of(websocket: FakeWebSocket, parts: Lookups) -> CommandSession:
    return CommandSession(cast("WebSocket", websocket), parts, ANYBODY)


async def test_of_two_subscriptions_of_one_name_at_the_same_time_the_second_is_refused(lookups: Lookups) -> None:
    websocket = FakeWebSocket(subscribe("a"), subscribe("a"), subscribe("b"))
    session = session_of(websocket, lookups)
    await session.read()
    await asyncio.sleep(0.1)
    assert [(answer["op"], answer.get("error", {}).get("code"), answer["id"]) for answer in websocket.told] == [
        ("error", "subscription_exists", "a"),
        ("ack", None, "a"),
        ("ack", None, "b"),
    ]
    assert len(lookups.fanout) == 2
    await session.close()
    assert len(lookups.fanout) == 0


@pytest.mark.parametrize("later", [0.0, 0.02])
async def test_a_subscription_that_is_under_way_when_the_socket_closes_leaves_no_trace(
    lookups: Lookups, later: float
) -> None:
    websocket = FakeWebSocket()
    session = session_of(websocket, lookups)
    command = asyncio.create_task(session.handle({"text": subscribe("a")}))
    await asyncio.sleep(later)
    await session.close()
    await command
    await asyncio.sleep(0.1)
    assert len(lookups.fanout) == 0


async def test_every_subscription_says_goodbye_before_the_socket_closes(lookups: Lookups) -> None:
    websocket = FakeWebSocket(subscribe("a"), stays=True)
    session = session_of(websocket, lookups)
    place = lookups.fanout.subscribe(EventFilter())
    running = asyncio.create_task(session.run(place))
    await until(lambda: any(answer.get("op") == "ack" for answer in websocket.told))
    lookups.fanout.close()
    await running
    assert [told.get("op") or told.get("type") or told["code"] for told in websocket.told] == ["ack", "closing", 1012]


async def test_stops_are_never_refused(tmp_path: Path) -> None:
    async with fake_fleet(tmp_path / "stops.json", "/") as fleet:
        fleet.parts.replace(Settings, Settings(subscriber_timeout=1.0))
        fleet.parts.replace(Logins, Logins(HistoryInMemory()))
        fleet.parts.replace(Quotas, Quotas(Settings()))
        fleet.goals["/"].answers.clear()  # each takes longer than the next takes to come
        websocket = FakeWebSocket(*(f'{{"op": "stop", "id": "{number}"}}' for number in range(20)), stays=True)
        session = CommandSession(cast("WebSocket", websocket), fleet.parts, ANYBODY)
        session.most = session.most_urgent = 1
        reading = asyncio.create_task(session.read())
        await until(lambda: len(websocket.told) == 20)
        reading.cancel()
        assert {answer["op"] for answer in websocket.told} == {"ack"}
        assert fleet.interlock.holds("/")


async def test_a_stop_in_a_binary_message_is_one(tmp_path: Path) -> None:
    async with fake_fleet(tmp_path / "stops.json", "/") as fleet:
        fleet.parts.replace(Settings, Settings(subscriber_timeout=1.0))
        fleet.parts.replace(Logins, Logins(HistoryInMemory()))
        fleet.parts.replace(Quotas, Quotas(Settings()))
        websocket = FakeWebSocket()
        session = CommandSession(cast("WebSocket", websocket), fleet.parts, ANYBODY)
        await session.handle({"text": None, "bytes": b'{"op": "ping"}'})
        await session.handle({"text": None, "bytes": b'{"op": "stop", "id": "s"}'})
        assert [(answer["op"], answer.get("error", {}).get("code")) for answer in websocket.told] == [
            ("error", "malformed_json"),
            ("ack", None),
        ]
        assert fleet.interlock.holds("/")
