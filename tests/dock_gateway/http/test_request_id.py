"""Every request has an id: the client's if it is harmless, in the answer, in the scope and in log lines."""

import asyncio
import re
from typing import Any

import pytest
from fastapi import FastAPI, Request, WebSocket
from starlette.testclient import TestClient

from dock_gateway.core.request import CURRENT
from dock_gateway.http.request_id import RequestId

MADE = re.compile(r"[0-9a-f]{32}")
TRACEPARENT = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"


def current() -> dict[str, str]:
    request = CURRENT.get()
    return {} if request is None else {"current": request.request_id, **request.trace}


@pytest.fixture
def http() -> TestClient:
    app = FastAPI()

    @app.get("/")
    async def root(request: Request) -> dict[str, str]:
        task = asyncio.create_task(asyncio.to_thread(current))
        return {"scope": request.scope["request_id"], **await task}

    @app.get("/bug")
    async def bug() -> None:
        raise RuntimeError

    @app.websocket("/ws")
    async def socket(websocket: WebSocket) -> None:
        await websocket.accept()
        await websocket.send_json({"scope": websocket.scope["request_id"], **current()})

    return TestClient(RequestId(app), raise_server_exceptions=False)


@pytest.mark.parametrize("wanted", ["a", "x" * 64, "9f.A_b-0", "0af76519-16cd-43dd-8448-eb211c80319c"])
def test_the_id_of_the_client(http: TestClient, wanted: str) -> None:
    answer = http.get("/", headers={"X-Request-ID": wanted})
    assert answer.headers["x-request-id"] == wanted
    assert answer.json() == {"scope": wanted, "current": wanted}


@pytest.mark.parametrize("wanted", ["", "x" * 65, "a b", 'a"b', "a/b", "{}", "a\tb", "ä", "a\x1b[31m"])
def test_an_id_that_is_long_or_not_harmless_is_replaced(http: TestClient, wanted: str) -> None:
    answer = http.get("/", headers={"X-Request-ID": wanted.encode("latin-1")})
    made = answer.headers["x-request-id"]
    assert MADE.fullmatch(made)
    assert answer.json() == {"scope": made, "current": made}


def test_requests_without_an_id_get_one_each(http: TestClient) -> None:
    made = {http.get("/").headers["x-request-id"] for _ in range(5)}
    assert len(made) == 5
    assert all(MADE.fullmatch(each) for each in made)


def test_the_headers_of_the_trace(http: TestClient) -> None:
    headers = {"X-Request-ID": "r", "traceparent": TRACEPARENT, "tracestate": "a=1"}
    assert http.get("/", headers=headers).json() == {
        "scope": "r",
        "current": "r",
        "traceparent": TRACEPARENT,
        "tracestate": "a=1",
    }


@pytest.mark.parametrize(("path", "status"), [("/bug", 500), ("/nothing", 404)])
def test_errors_have_it(http: TestClient, path: str, status: int) -> None:
    answer = http.get(path, headers={"X-Request-ID": "r"})
    assert answer.status_code == status
    assert answer.headers["x-request-id"] == "r"


async def test_the_server_logs_a_failure_with_it() -> None:
    """uvicorn logs it in the same task, after the application has failed."""

    async def fails(*_: Any) -> None:
        raise RuntimeError

    async def serve() -> dict[str, str]:
        with pytest.raises(RuntimeError):
            await RequestId(fails)({"type": "http", "headers": [(b"x-request-id", b"r")]}, fails, fails)
        return current()

    assert await asyncio.create_task(serve()) == {"current": "r"}
    assert current() == {}


def test_a_websocket_has_the_id_of_its_handshake(http: TestClient) -> None:
    with http.websocket_connect("/ws", headers={"X-Request-ID": "r"}) as websocket:
        assert websocket.receive_json() == {"scope": "r", "current": "r"}
        assert (b"x-request-id", b"r") in websocket.extra_headers
