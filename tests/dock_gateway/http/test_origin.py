"""Pages of other sites cannot use the gateway; programs and its own dashboard can."""

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient, WebSocketDenialResponse
from starlette.websockets import WebSocket

from dock_gateway.http.edge.forwarded import ForwardedHeaders
from dock_gateway.http.origin import OriginGuard
from dock_gateway.http.problems import install_problems
from dock_gateway.settings import Settings

Headers = dict[str, str] | list[tuple[str, str]]


def status(method: str, headers: Headers, scheme: str = "http", **settings: str) -> int:
    app = FastAPI()

    @app.api_route("/x", methods=["GET", "POST"])
    async def x() -> None: ...

    app.add_middleware(OriginGuard, settings=Settings(**settings))  # type: ignore[arg-type]
    install_problems(app)
    trusting = ForwardedHeaders(app, ["192.0.2.1"])
    with TestClient(trusting, base_url=f"{scheme}://127.0.0.1:8000", client=("192.0.2.1", 50000)) as client:
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
def test_who_may_speak(method: str, headers: Headers, settings: dict[str, str], expected: int) -> None:
    assert status(method, headers, **settings) == expected


@pytest.mark.parametrize(
    ("scheme", "headers", "expected"),
    [
        ("http", {"Origin": "https://127.0.0.1:8000"}, 403),  # another scheme is another origin
        ("https", {"Origin": "http://127.0.0.1:8000"}, 403),
        ("https", {"Origin": "https://127.0.0.1:8000"}, 200),
        ("http", {"Origin": "https://127.0.0.1:8000", "X-Forwarded-Proto": "https"}, 200),  # behind a proxy with TLS
        ("http", {"Origin": "http://127.0.0.1:8000", "X-Forwarded-Proto": "https"}, 403),
        ("http", {"Origin": "http://localhost", "Host": "localhost:80"}, 200),
        ("https", {"Origin": "https://localhost:443", "Host": "localhost"}, 200),
        ("http", {"Origin": "http://localhost:443", "Host": "localhost"}, 403),
        ("http", {"Origin": "HTTP://LOCALHOST", "Host": "LocalHost"}, 200),
        ("http", {"Origin": "http://user@127.0.0.1:8000"}, 403),
        ("http", {"Origin": "http://127.0.0.1:8000/"}, 403),
        ("http", {"Origin": ""}, 403),
        ("http", {"Origin": "127.0.0.1:8000"}, 403),
        ("http", {"Origin": "file://127.0.0.1:8000"}, 403),
        ("http", [("Origin", "http://127.0.0.1:8000"), ("Origin", "https://evil.example")], 403),
        ("http", [("Origin", "http://127.0.0.1:8000"), ("Origin", "http://127.0.0.1:8000")], 403),
        ("http", {"Sec-Fetch-Site": "cross-site"}, 403),  # a browser that keeps the origin to itself
        ("http", {"Sec-Fetch-Site": "same-origin"}, 200),
        ("http", {"Sec-Fetch-Site": "none"}, 200),
        ("http", {"Sec-Fetch-Site": "cross-site", "Origin": "http://127.0.0.1:8000"}, 200),
    ],
)
def test_pages_of_the_same_origin(scheme: str, headers: Headers, expected: int) -> None:
    assert status("POST", headers, scheme) == expected


@pytest.mark.parametrize("method", ["GET", "POST"])
@pytest.mark.parametrize(
    "hosts",
    [
        ["localhost", "localhost"],
        ["localhost", "evil.example"],
        ["user@localhost"],
        ["localhost@evil.example"],
        ["user:password@localhost"],
        ["localhost:"],
        ["localhost:port"],
        ["localhost:0"],
        ["localhost:65536"],
        ["localhost:80:80"],
        ["local host"],
        ["localhost, evil.example"],
        ["localhost/x"],
        ["localhost?x"],
        ["localhost#x"],
        ["http://localhost"],
        ["[::1"],
        ["[]"],
        ["::1"],
        [""],
        [":8000"],
        ["127.1"],
        ["2130706433"],
        ["localhost\t"],
    ],
)
def test_hosts_that_are_odd(method: str, hosts: list[str]) -> None:
    assert status(method, [("Host", host) for host in hosts]) == 403


@pytest.mark.parametrize("host", ["user@anything", "any thing", ""])
def test_hosts_that_are_odd_where_any_is_allowed(host: str) -> None:
    assert status("GET", {"Host": host}, allowed_hosts="*") == 403


def test_reading_needs_no_origin_of_ours() -> None:
    assert status("GET", {"Sec-Fetch-Site": "cross-site"}) == 200
    assert status("GET", [("Origin", "https://a.example"), ("Origin", "https://b.example")]) == 403


@pytest.mark.parametrize("headers", [{"Origin": "wss://127.0.0.1:8000"}, {"Sec-Fetch-Site": "cross-site"}])
def test_websockets_of_other_pages(headers: dict[str, str], caplog: pytest.LogCaptureFixture) -> None:
    """The log has one line for each: a browser does not show its page the answer."""
    app = FastAPI()

    @app.websocket("/ws")
    async def ws(websocket: WebSocket) -> None:
        await websocket.accept()
        await websocket.close()

    app.add_middleware(OriginGuard, settings=Settings())
    install_problems(app)
    client = TestClient(app, base_url="http://127.0.0.1:8000")
    for scheme in ("http", "https"):
        url = f"{scheme.replace('http', 'ws')}://127.0.0.1:8000/ws"
        with client.websocket_connect(url, headers={"Host": "127.0.0.1:8000", "Origin": f"{scheme}://127.0.0.1:8000"}):
            pass
        with (
            pytest.raises(WebSocketDenialResponse) as refused,
            client.websocket_connect(url, headers={"Host": "127.0.0.1:8000", **headers}),
        ):
            pass
        assert refused.value.status_code == 403
    lines = [record.getMessage() for record in caplog.records if "a WebSocket was refused" in record.getMessage()]
    assert len(lines) == 2
    assert headers.get("Origin", "another site") in lines[0]
