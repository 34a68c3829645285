"""A goal's short way in gives the same answers to the same requests as FastAPI's."""

import uuid
from collections.abc import AsyncIterator
from types import SimpleNamespace
from typing import Any

import httpx2
import pytest
from sensor_msgs.msg import BatteryState
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from dock_gateway.api import shortcut
from dock_gateway.api.shortcut import GoalShortcut
from dock_gateway.app import create_app
from dock_gateway.errors import Conflict, NotFound
from dock_gateway.events import EPOCH
from dock_gateway.goals import Goal, GoalStatus
from dock_gateway.ros.messages import codec
from dock_gateway.settings import Settings

GOAL_ID = str(uuid.UUID(int=7))


class FakeAction:
    """Takes every goal, but refuses those with the key `stopped`; `/buggy` fails."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.goals = self
        self.port = SimpleNamespace(goal_codec=SimpleNamespace(parse=self._parse))

    @staticmethod
    def _parse(value: Any) -> str:
        codec(BatteryState).parse(value.get("desired_battery_state", value))
        return str(value)

    async def submit(self, message: str, key: str | None) -> Goal:
        if key == "stopped":
            raise Conflict("it was stopped", code="stop_latched")
        if self.name == "/buggy":
            raise ZeroDivisionError
        return Goal(GOAL_ID, self.name, "pkg/action/Dock", EPOCH, goal=f'"{key} {message}"'.encode())

    async def wait(self, goal: Goal, seconds: float) -> None:
        goal.advance(GoalStatus.SUCCEEDED, EPOCH)


class FakeGateway:
    settings = Settings(max_body_bytes=1024)
    dock, undock = FakeAction("/dock"), FakeAction("/undock")

    def __init__(self) -> None:
        self.actions = self

    def _names_of(self, robot: str) -> Any:
        return SimpleNamespace(dock=f"{robot}/dock", undock=f"{robot}/undock")

    async def find(self, name: str) -> FakeAction:
        if name == "/none":
            raise NotFound("nobody serves it", code="action_not_found")
        return FakeAction(name)


def with_gateway(app: Any) -> Any:
    async def called(scope: Scope, receive: Receive, send: Send) -> None:
        await app({**scope, "state": {"gateway": FakeGateway()}}, receive, send)

    return called


def client_of(app: Any) -> httpx2.AsyncClient:
    transport = httpx2.ASGITransport(with_gateway(app), raise_app_exceptions=False)
    return httpx2.AsyncClient(transport=transport, base_url="http://127.0.0.1")


@pytest.fixture
async def client() -> AsyncIterator[httpx2.AsyncClient]:
    async with client_of(create_app(Settings())) as client:
        yield client


async def both_ways(client: httpx2.AsyncClient, path: str, **request: Any) -> httpx2.Response:
    """The answer, if it is the same both ways."""
    short = await client.post(path, **request)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shortcut, "VERBS", {})
        patch.setattr(shortcut, "ACTIONS", "\0")
        long = await client.post(path, **request)
    assert (short.status_code, dict(short.headers), short.text) == (long.status_code, dict(long.headers), long.text)
    return short


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("/dock", 202),
        ("/undock", 202),
        ("/dock?robot=/robot1", 202),
        ("/dock?robt=/robot1", 422),
        ("/dock/", 307),
        ("/actions/robot1/dock/goals", 202),
        ("/actions/d%C3%B6ck/goals", 202),
        ("/actions/goals/goals", 202),
        ("/actions/none/goals", 404),
        ("/actions/buggy/goals", 500),
        ("/actions/dock/goals?robot=/robot1", 422),
        ("/actions/goals", 405),
    ],
)
async def test_paths(client: httpx2.AsyncClient, path: str, status: int) -> None:
    assert (await both_ways(client, path, content=b"{}")).status_code == status


@pytest.mark.parametrize(
    ("content", "headers", "status"),
    [
        (b"", {}, 202),
        (b'{"desired_battery_state": {"voltage": 12.5}}', {}, 202),
        (b'{"desired_battery_state": {"voltage": "high"}}', {}, 422),
        (b"{", {}, 400),
        (b'"%s"' % (b"x" * 1024), {}, 413),
        (b"{}", {"Content-Type": "text/plain"}, 415),
        (b"{}", {"Prefer": "wait=1"}, 200),
        (b"{}", {"Prefer": "wait=no"}, 422),
        (b"{}", {"Idempotency-Key": "stopped"}, 409),
        (b"{}", {"Idempotency-Key": ""}, 422),
        (b"{}", {"Host": "robot.example"}, 403),
        (b"{}", {"Origin": "http://elsewhere.example"}, 403),
    ],
)
async def test_requests(client: httpx2.AsyncClient, content: bytes, headers: dict[str, str], status: int) -> None:
    assert (await both_ways(client, "/dock", content=content, headers=headers)).status_code == status


@pytest.mark.parametrize(
    ("method", "path", "short"),
    [
        ("POST", "/dock", True),
        ("POST", "/undock", True),
        ("POST", "/actions/robot1/dock/goals", True),
        ("POST", "/dock?robot=/robot1", False),
        ("POST", "/actions/goals", False),
        ("POST", "/battery", False),
        ("POST", f"/dock/{GOAL_ID}/cancel", False),
        ("GET", "/dock", False),
        ("OPTIONS", "/dock", False),
    ],
)
async def test_which_requests_go_the_short_way(method: str, path: str, short: bool) -> None:
    async with client_of(GoalShortcut(Response(status_code=418))) as client:
        answer = await client.request(method, path, content=b"{}")
    assert answer.status_code == (202 if short else 418)
