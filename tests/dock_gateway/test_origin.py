"""Pages of other sites cannot use the gateway; programs and its own dashboard can."""

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from dock_gateway.api.origin import OriginGuard
from dock_gateway.settings import Settings


def status(method: str, headers: dict[str, str], **settings: str) -> int:
    app = FastAPI()

    @app.api_route("/x", methods=["GET", "POST"])
    async def x() -> None: ...

    app.add_middleware(OriginGuard, settings=Settings(**settings))  # type: ignore[arg-type]
    with TestClient(app, base_url="http://127.0.0.1:8000") as client:
        return client.request(method, "/x", headers=headers).status_code


@pytest.mark.parametrize(
    ("method", "headers", "settings", "expected"),
    [
        ("POST", {}, {}, 200),
        ("POST", {"Origin": "http://127.0.0.1:8000"}, {}, 200),
        ("POST", {"Origin": "http://localhost:8000", "Host": "localhost:8000"}, {}, 200),
        ("POST", {"Origin": "http://127.0.0.1:9000"}, {}, 403),
        ("POST", {"Origin": "https://evil.example"}, {}, 403),
        ("POST", {"Origin": "null"}, {}, 403),
        ("GET", {"Origin": "https://evil.example"}, {}, 200),
        ("POST", {"Origin": "https://ops.example"}, {"allowed_origins": "https://ops.example"}, 200),
        ("POST", {"Origin": "https://ops.example"}, {"allowed_origins": "*"}, 200),
        ("GET", {"Host": "rebound.example"}, {}, 403),
        ("GET", {"Host": "[::1]:8000"}, {}, 200),
        ("GET", {"Host": "robot.local:8000"}, {"allowed_hosts": "robot.local"}, 200),
        ("GET", {"Host": "other.local"}, {"allowed_hosts": "robot.local"}, 403),
        ("GET", {"Host": "ROBOT.local:8000"}, {"allowed_hosts": "Robot.Local"}, 200),
        ("GET", {"Host": "localhost:8000"}, {"allowed_hosts": "robot.local"}, 200),
        ("GET", {"Host": "127.0.0.1:8000"}, {"allowed_hosts": "robot.local"}, 200),
        ("GET", {"Host": "anything"}, {"allowed_hosts": "*"}, 200),
        ("GET", {"Host": "192.168.1.5:8000"}, {"host": "0.0.0.0"}, 200),
        ("GET", {"Host": "[fd00::5]:8000"}, {"host": "::"}, 200),
        ("POST", {"Host": "evil.example", "Origin": "http://evil.example"}, {"host": "0.0.0.0"}, 403),
        ("GET", {"Host": "evil.example"}, {"host": "192.168.1.5"}, 403),
        ("GET", {"Host": "1.2.3.4.evil.example"}, {"host": "0.0.0.0"}, 403),
        ("GET", {"Host": ""}, {"host": "0.0.0.0"}, 403),
        ("GET", {"Host": "[broken"}, {}, 403),
    ],
)
def test_who_may_speak(method: str, headers: dict[str, str], settings: dict[str, str], expected: int) -> None:
    assert status(method, headers, **settings) == expected
