"""What an operation does not take is refused: query parameters, a body, conditions on a version."""

from collections.abc import Iterator
from typing import Any

import pytest
from starlette.requests import Request

from dock_gateway.app import api_routers
from dock_gateway.core.errors import InvalidField
from dock_gateway.extension import extensions
from dock_gateway.extension_list import OURS
from dock_gateway.http.operation import READS, operation_of
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.unexpected import CONDITIONS, known_query
from dock_gateway.settings import Settings
from tests.support.route_client import RouteClient

# What stops something: it is never refused for a body, or a condition, that it does not take.
STOPS = {("POST", "/stop"), ("POST", "/goals/{goal_id}/cancel")}
STOPS |= {("POST", "/missions/{mission_id}/cancel")} if "missions" in OURS else set()


@pytest.fixture(scope="module")
def client() -> Iterator[RouteClient]:
    with RouteClient() as client:
        yield client


def changes() -> list[tuple[str, str, dict[str, Any]]]:
    """Return the operations that may change something: method, path, and what the document says."""
    app: Any = RouteClient().http.app
    paths: dict[str, Any] = app.openapi()["paths"]
    return [
        (method.upper(), path, described)
        for path, methods in paths.items()
        for method, described in methods.items()
        if method.upper() not in READS
    ]


def asked(path: str, described: dict[str, Any]) -> str:
    """Return a path with a value for each of its parameters, of the form that the document says."""
    for each in described.get("parameters", []):
        if each["in"] == "path":
            uuid = each["name"] == "goal_id"
            path = path.replace(f"{{{each['name']}}}", "7d9c1c9e-0000-4000-8000-00000000000a" if uuid else "x")
    return path


@pytest.mark.parametrize("query", [b"robot=/robot1&robot=/robot2", b"robot=/robot1&robot=/robot1", b"robto=/robot1"])
async def test_what_robot_is_meant_is_clear(query: bytes) -> None:
    with pytest.raises(InvalidField):
        await known_query("robot", "status")(Request({"type": "http", "query_string": query}))
    await known_query("robot", "status")(
        Request({"type": "http", "query_string": b"robot=/robot1&status=lost&status=aborted"})
    )


@pytest.mark.parametrize("content", [b'{"robot": "/robot1"}', b"garbage", b" "])
def test_a_body_that_an_operation_does_not_take_is_refused(client: RouteClient, content: bytes) -> None:
    bodiless = {(method, path): said for method, path, said in changes() if "requestBody" not in said}
    assert ("DELETE", "/stop") in bodiless
    assert bodiless.keys() >= STOPS - {("POST", "/stop")}
    for (method, path), described in bodiless.items():
        if (method, path) in STOPS:
            continue
        refused = client.http.request(method, asked(path, described), content=content)
        assert refused.status_code == 422, (method, path, refused.text)
        (error,) = refused.json()["errors"]
        assert (error["in"], error["path"]) == ("body", ""), (method, path, error)


def test_a_body_in_pieces_is_refused_too_and_an_empty_one_is_none(client: RouteClient) -> None:
    def pieces() -> Iterator[bytes]:
        yield b""
        yield b"{}"

    assert client.http.request("DELETE", "/stop", content=pieces()).status_code == 422
    with pytest.raises(Exception, match="Stopper"):  # the next thing that it needs
        client.http.request("DELETE", "/stop", content=iter([b""]))


@pytest.mark.parametrize("condition", CONDITIONS)
def test_a_condition_that_an_operation_does_not_know_is_refused(client: RouteClient, condition: str) -> None:
    without = 0
    for method, path, described in changes():
        known = {each["name"] for each in described.get("parameters", []) if each["in"] == "header"}
        if condition in known or (method, path) in STOPS:
            continue
        without += 1
        refused = client.http.request(method, asked(path, described), headers={condition: "*"})
        assert refused.status_code == 422, (method, path, refused.text)
        (error,) = refused.json()["errors"]
        assert (error["in"], error["path"]) == ("header", condition), (method, path, error)
    assert without > 10


def test_what_stops_something_is_not_refused_for_what_it_does_not_take() -> None:
    routes = [route for each in api_routers(Settings(), extensions()) for route in each.routes]
    stopping = {
        (method, route.path)
        for route in routes
        if isinstance(route, ApiRoute) and route.include_in_schema and operation_of(route.endpoint).stops
        for method in route.methods or ()
    }
    assert stopping == STOPS
