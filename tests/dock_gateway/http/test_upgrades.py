"""A WebSocket's path asked for as a page, and a WebSocket of a path that has none."""

import pytest
from starlette.routing import WebSocketRoute
from starlette.testclient import TestClient, WebSocketDenialResponse

from dock_gateway.app import create_app
from dock_gateway.extension import extensions
from dock_gateway.settings import Settings
from tests.support.edge import HOST, serving

HANDSHAKE = (
    b"Connection: Upgrade\r\nUpgrade: websocket\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)

OF_EXTENSIONS = [
    route.path
    for extension in extensions()
    for router in extension.routes(Settings())
    for route in router.routes
    if isinstance(route, WebSocketRoute)
]


@pytest.fixture
def client() -> TestClient:
    return TestClient(create_app(Settings()), base_url="http://127.0.0.1:8000")


@pytest.mark.parametrize("path", ["/ws", "/ws/feedback?robot=/robot1", "/ws/topics", *OF_EXTENSIONS])
def test_without_an_upgrade(client: TestClient, path: str) -> None:
    response = client.get(path)
    problem = response.json()
    assert (response.status_code, problem["status"], problem["code"]) == (426, 426, "upgrade_required")
    assert (response.headers["upgrade"], response.headers["connection"]) == ("websocket", "Upgrade")
    assert "proxy has to speak HTTP/1.1" in problem["detail"]
    assert client.head(path).status_code == 426
    assert client.post(path).headers["allow"] == client.options(path).headers["allow"] == "GET, HEAD, OPTIONS"


async def test_a_proxy_that_speaks_http_1_0() -> None:
    """It asks for an upgrade, and would not pass it on."""
    async with serving(create_app(Settings())) as edge:
        answer = await edge.ask(b"GET /ws HTTP/1.0\r\n" + HOST + HANDSHAKE)
    assert answer.startswith(b"HTTP/1.1 426 Upgrade Required\r\n")


@pytest.mark.parametrize("path", ["/", "/dock", "/ws/feedbak"])
def test_no_websocket_is_there(client: TestClient, path: str, caplog: pytest.LogCaptureFixture) -> None:
    with pytest.raises(WebSocketDenialResponse) as refused, client.websocket_connect(f"ws://127.0.0.1:8000{path}"):
        pass
    assert refused.value.status_code == 404
    assert "a WebSocket was refused: there is no WebSocket at" in caplog.text
    there = ", ".join([*sorted(OF_EXTENSIONS), "/ws", "/ws/feedback"])
    assert f"there are {there}" in refused.value.json()["detail"]
