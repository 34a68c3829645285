"""Requests are counted by route, whatever clients send."""

from collections.abc import Iterator

import pytest
from fastapi import FastAPI, Response, WebSocket
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from dock_gateway.app import create_app
from dock_gateway.observability.request_meter import RequestMeter
from dock_gateway.observability.request_metrics import RequestMetrics
from dock_gateway.settings import Settings


class Client:
    """An application, with a route that breaks and two WebSockets besides the real ones."""

    def __init__(self) -> None:
        app = create_app(Settings())
        self.http = TestClient(app, base_url="http://127.0.0.1:8000", raise_server_exceptions=False)
        self._registry = app.state.requests.registry

    def requests(self, method: str, route: str, status: int) -> float | None:
        labels = {"method": method, "route": route, "status": str(status)}
        value: float | None = self._registry.get_sample_value("dock_gateway_http_requests_total", labels)
        return value

    def value(self, name: str, **labels: str) -> float | None:
        value: float | None = self._registry.get_sample_value(f"dock_gateway_{name}", labels)
        return value


@pytest.fixture
def client() -> Client:
    return Client()


def test_a_route_is_one_series_whatever_the_path(client: Client) -> None:
    for number in range(5):
        assert client.http.get(f"/ui/{number}").status_code == 200
    assert client.requests("GET", "/ui/{path:path}", 200) == 5
    assert client.value("http_request_duration_seconds_count", method="GET", route="/ui/{path:path}") == 5
    assert client.value("http_requests_in_progress") == 0


def test_unknown_paths_methods_and_files_are_others(client: Client) -> None:
    for path in ("/nothing", "/a/b/c", "/assets/nothing.js"):
        assert client.http.get(path).status_code == 404
    assert client.requests("GET", "other", 404) == 3
    client.http.request("BREW", "/nothing")
    assert client.requests("other", "other", 404) == 1
    assert client.http.delete("/dock").status_code == 405
    assert client.requests("DELETE", "/dock", 405) == 1


def test_requests_of_foreign_pages_are_counted(client: Client) -> None:
    assert client.http.post("/dock", headers={"Origin": "https://evil.example"}).status_code == 403
    assert client.requests("POST", "other", 403) == 1


@pytest.fixture
def metrics() -> RequestMetrics:
    return RequestMetrics()


@pytest.fixture
def http(metrics: RequestMetrics) -> Iterator[TestClient]:
    app = FastAPI()

    @app.get("/bug")
    async def bug() -> None:
        raise RuntimeError

    @app.websocket("/open")
    async def opened(websocket: WebSocket) -> None:
        await websocket.accept()
        await websocket.receive_text()

    @app.websocket("/closed")
    async def closed(websocket: WebSocket) -> None:
        await websocket.close()

    @app.websocket("/denied")
    async def denied(websocket: WebSocket) -> None:
        await websocket.send_denial_response(Response(status_code=429))

    app.add_middleware(RequestMeter, metrics=metrics)
    with TestClient(app, raise_server_exceptions=False) as client:
        yield client


def test_a_bug_is_a_500(http: TestClient, metrics: RequestMetrics) -> None:
    assert http.get("/bug").status_code == 500
    labels = {"method": "GET", "route": "/bug", "status": "500"}
    assert metrics.registry.get_sample_value("dock_gateway_http_requests_total", labels) == 1


def test_a_websocket_counts_while_it_is_open(http: TestClient, metrics: RequestMetrics) -> None:
    def open_now() -> float | None:
        return metrics.registry.get_sample_value("dock_gateway_websockets", {"route": "/open"})

    with http.websocket_connect("/open") as websocket:
        assert open_now() == 1
        websocket.send_text("that is all")
    assert open_now() == 0
    labels = {"method": "GET", "route": "/open", "status": "101"}
    assert metrics.registry.get_sample_value("dock_gateway_http_requests_total", labels) == 1


@pytest.mark.parametrize(("route", "status"), [("/closed", 403), ("/denied", 429)])
def test_a_websocket_that_is_refused(http: TestClient, metrics: RequestMetrics, route: str, status: int) -> None:
    with pytest.raises((WebSocketDisconnect, Exception)), http.websocket_connect(route):
        pass
    labels = {"method": "GET", "route": route, "status": str(status)}
    assert metrics.registry.get_sample_value("dock_gateway_http_requests_total", labels) == 1
    assert metrics.registry.get_sample_value("dock_gateway_websockets", {"route": route}) is None
