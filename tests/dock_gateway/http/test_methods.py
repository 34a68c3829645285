"""`OPTIONS` and 405 name the methods that a path has, as OpenAPI lists them; `HEAD` is there wherever `GET` is."""

import asyncio
import re
from collections.abc import AsyncGenerator
from typing import Any

import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route
from starlette.testclient import TestClient

from dock_gateway.app import create_app
from dock_gateway.http.methods import HeadAsGet
from dock_gateway.http.slow_clients import PacedResponse
from dock_gateway.settings import Settings
from tests.support.edge import HOST, serving
from tests.support.waiting import PATIENCE

METHODS = {"get", "put", "post", "patch", "delete"}


@pytest.fixture
def client() -> TestClient:
    return TestClient(create_app(Settings()), base_url="http://127.0.0.1:8000")


def example(path: str) -> str:
    return re.sub(r"{[^}]+}", "x", path.replace("{goal_id}", "7d9c1c9e-0000-4000-8000-000000000000"))


def read(allow: str) -> set[str]:
    return {method.strip().lower() for method in allow.split(",")}


def test_each_path_names_its_methods(client: TestClient, document: dict[str, Any]) -> None:
    for path, operations in document["paths"].items():
        options, other = client.options(example(path)), client.request("BREW", example(path))
        assert (options.status_code, options.content) == (204, b""), path
        assert (other.status_code, other.json()["code"]) == (405, "method_not_allowed"), path
        for response in (options, other):
            methods = METHODS & operations.keys()
            if path == "/actions/{name}/goals":  # answered as `GET /goals?action=`, which the document has
                methods |= {"get"}
            head = {"head"} if "get" in methods else set()
            assert read(response.headers["allow"]) == {"options", *methods, *head}, path


def test_pages_and_what_is_not_there(client: TestClient) -> None:
    assert read(client.options("/").headers["allow"]) == {"get", "head", "options"}
    assert read(client.put("/docs").headers["allow"]) == {"get", "head", "options"}
    for method in ("OPTIONS", "DELETE"):
        response = client.request(method, "/nothing")
        assert (response.status_code, response.json()["code"]) == (404, "not_found")
        assert response.json()["detail"] == "there is nothing at '/nothing'; /docs lists the API"
    assert client.put("/dock").json()["detail"] == "PUT is not a method of '/dock'; it has GET, HEAD, OPTIONS, POST"


@pytest.mark.parametrize(
    ("path", "location"),
    [
        ("/dock/", "/dock"),
        ("/dock/?robot=%2Frobot1&x=%20", "/dock?robot=%2Frobot1&x=%20"),
        ("/actions/a%20%3Fb%2Fc/goals//", "/actions/a%20%3Fb/c/goals"),
        ("/actions/", "/actions"),
        ("/ws/", "/ws"),
    ],
)
def test_a_slash_at_the_end_is_a_redirect_that_says_so(client: TestClient, path: str, location: str) -> None:
    """On the same host and scheme as the request, whatever a proxy in between speaks."""
    response = client.post(path, follow_redirects=False)
    assert (response.status_code, response.headers["location"]) == (307, location)
    assert response.json()["detail"].startswith("there is no slash at the end: the path is /")


@pytest.mark.parametrize(
    "path", ["//", "//foreign.example/", "//dock/", "/nothing/", "/assets/", "/\\\\foreign.example/"]
)
def test_a_slash_at_the_end_of_what_is_not_there(client: TestClient, path: str) -> None:
    assert client.get(f"http://127.0.0.1:8000{path}", follow_redirects=False).status_code == 404


def test_a_request_that_is_no_preflight_of_an_allowed_page() -> None:
    client = TestClient(create_app(Settings(allowed_origins="https://ops.example")), base_url="http://127.0.0.1:8000")  # type: ignore[arg-type]
    response = client.options("/dock", headers={"Origin": "https://ops.example"})
    assert response.status_code == 204
    assert read(response.headers["allow"]) == {"get", "head", "post", "options"}
    assert response.headers["access-control-allow-origin"] == "https://ops.example"


@pytest.mark.parametrize("path", ["/", "/docs", "/docs/start.js", "/swagger/swagger-ui.css", "/openapi.json", "/no"])
async def test_a_head_is_that_of_get(path: str) -> None:
    """Over a connection that stays open: a body would be read as the next answer."""
    request = f" {path} HTTP/1.1\r\n".encode() + HOST
    async with serving(create_app(Settings())) as edge:
        both = await edge.ask(b"HEAD" + request + b"\r\n", b"GET" + request + b"Connection: close\r\n\r\n")
    head, get, *_ = both.split(b"\r\n\r\n")
    assert _headers(head) == _headers(get.replace(b"\r\nConnection: close", b""))
    assert b"content-length: " in head
    assert both.count(b"HTTP/1.1 ") == 2


def _headers(head: bytes) -> list[bytes]:
    return [line for line in head.split(b"\r\n") if not line.startswith(b"date: ")]


async def test_a_stream_answers_its_head_alone_and_ends() -> None:
    """Its subscriber is gone at once, and the connection takes the next request."""
    ended = asyncio.Event()

    async def events() -> AsyncGenerator[bytes]:
        try:
            while True:
                yield b"data: 1\n\n"
                await asyncio.sleep(0)
        finally:
            ended.set()

    async def stream(request: Request) -> Response:
        assert request.method == "GET"
        return PacedResponse(b"", events(), 5, media_type="text/event-stream", headers={})

    async with serving(HeadAsGet(Starlette(routes=[Route("/", stream)]))) as edge:
        answers = await edge.ask(
            b"HEAD / HTTP/1.1\r\n" + HOST + b"\r\n", b"HEAD / HTTP/1.1\r\n" + HOST + b"Connection: close\r\n\r\n"
        )
        await asyncio.wait_for(ended.wait(), PATIENCE)
    assert answers.count(b"HTTP/1.1 200 OK\r\n") == 2
    assert answers.count(b"text/event-stream") == 2
    assert b"data:" not in answers
