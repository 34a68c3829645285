"""A route of the API takes, returns and refuses what its function and its operation say."""

from collections.abc import AsyncIterator
from typing import Annotated, Any

import httpx
import pytest
from fastapi import APIRouter, Depends, FastAPI, Query, Request
from pydantic import BaseModel
from starlette.middleware.base import RequestResponseEndpoint
from starlette.responses import Response

from dock_gateway.app import api_routers
from dock_gateway.core.errors import Conflict
from dock_gateway.core.grant import Role
from dock_gateway.extension import extensions
from dock_gateway.http.bodies import Body
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Operation, Scope, operation, public_operation
from dock_gateway.http.parts import Parts
from dock_gateway.http.problems import install_problems
from dock_gateway.http.requests import Answer, RobotQuery, json_response
from dock_gateway.http.route import ApiRoute, documented_errors
from dock_gateway.settings import Settings
from dock_hub.app import ROUTERS


class Found(BaseModel):
    """What was found."""

    wanted: str


async def _wanted(tag: Annotated[str, Query(alias="as")] = "any") -> str:
    return tag


router = APIRouter(route_class=ApiRoute)


@router.get("/found")
@operation(Role.VIEWER, Scope.ROBOT, errors=(409,))
async def find(wanted: Annotated[str, Depends(_wanted)], robot: RobotQuery = None) -> Answer[Found]:
    """Find something."""
    if robot == "/busy":
        raise Conflict("it is busy")
    return json_response({"wanted": wanted})


@router.get("/any")
@public_operation(any_query=True)
async def take_any() -> Answer[Found]:
    """Take any query."""
    return json_response({"wanted": "any"})


@router.put("/found")
@public_operation()
async def put(found: Body[Found], robot: RobotQuery = None) -> Answer[Found]:
    """Put something."""
    return json_response({"wanted": f"{found.wanted} {robot}"})


@router.put("/raw", openapi_extra=body({"type": "object"}, required=True))
@operation(Role.OPERATOR, Scope.EVERY)
async def put_raw() -> Answer[Found]:
    """Put something that the function reads."""
    return json_response({"wanted": "this"})


@pytest.fixture
def app() -> FastAPI:
    app = FastAPI()

    @app.middleware("http")
    async def with_parts(request: Request, call_next: RequestResponseEndpoint) -> Response:
        request.state.parts = Parts({Settings: Settings()})
        return await call_next(request)

    app.include_router(router)
    install_problems(app)
    return app


@pytest.fixture
async def client(app: FastAPI) -> AsyncIterator[httpx.AsyncClient]:
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://gateway") as client:
        yield client


@pytest.mark.parametrize(
    ("query", "status"),
    [
        ("", 200),
        ("robot=/robot1&as=a", 200),
        ("robot=/busy", 409),
        ("tag=a", 422),  # the name of the parameter is not that of the query
        ("robt=/robot1", 422),
        ("robot=/robot1&robot=/robot2", 422),
    ],
)
async def test_only_the_query_of_the_function_is_taken(client: httpx.AsyncClient, query: str, status: int) -> None:
    answer = await client.get(f"/found?{query}")
    assert answer.status_code == status
    if status == 422:
        (error,) = answer.json()["errors"]
        assert (error["in"], error["path"]) == ("query", query.partition("=")[0])
        assert error["expected"] in {"one of robot, as", "one of as, robot", "one robot"}


async def test_an_operation_may_take_any_query(client: httpx.AsyncClient) -> None:
    assert (await client.get("/any?robt=/robot1")).json() == {"wanted": "any"}


async def test_a_body_is_read_as_its_model(client: httpx.AsyncClient) -> None:
    assert (await client.put("/found?robot=/a", json={"wanted": "this"})).json() == {"wanted": "this /a"}
    refused = (await client.put("/found", json={"wanted": 1})).json()
    assert [error["path"] for error in refused["errors"]] == ["wanted"]


def test_a_body_is_described_by_its_model(app: FastAPI) -> None:
    described = app.openapi()["paths"]["/found"]["put"]["requestBody"]
    assert described["required"] is True
    assert described["content"]["application/json"]["schema"]["properties"].keys() == {"wanted"}


def test_the_document_has_the_model_and_the_errors(app: FastAPI) -> None:
    def answers(path: str, method: str = "get") -> dict[str, Any]:
        responses: dict[str, Any] = app.openapi()["paths"][path][method]["responses"]
        return responses

    assert answers("/found")["200"]["content"]["application/json"]["schema"]["$ref"].endswith("/Found")
    assert {*answers("/found")} == {"200", "401", "403", "409", "421", "422", "503"}
    assert {*answers("/found", "put")} == {"200", "400", "403", "408", "413", "415", "422", "429"}
    assert {*answers("/raw", "put")} == {"200", "400", "401", "403", "408", "413", "415", "422", "429", "503"}
    assert {*answers("/any")} == {"200", "403"}


@pytest.mark.parametrize("scope", Scope)
def test_what_is_named_may_not_be_there_and_a_robot_may_be_served_elsewhere(scope: Scope) -> None:
    errors = documented_errors(Operation(Role.AGENT, scope, sends_goal=True), has_body=False)
    everywhere = {Scope.ANY, Scope.LISTED, Scope.EVERY}
    assert (404 in errors) == (scope not in {*everywhere, Scope.ROBOT, Scope.ROBOTS})
    assert (421 in errors) == (scope not in {*everywhere, Scope.ALERT, Scope.APPROVAL, Scope.TOPIC, Scope.LOOKED_AT})
    assert errors >= {401, 403, 422, 429, 503}


def test_an_endpoint_that_reads_its_body_itself_says_what_it_refuses() -> None:
    tolerant = Operation(Role.VIEWER, Scope.ANY, reads_body=True, any_query=True)
    assert documented_errors(tolerant, has_body=True) == {401, 403, 503}


def test_every_route_of_the_api_is_one() -> None:
    others = [
        (route.path, type(route).__name__)
        for each in (*api_routers(Settings(), extensions()), *ROUTERS)
        for route in each.routes
        if not isinstance(route, ApiRoute)
    ]
    assert {kind for _, kind in others} == {"APIWebSocketRoute"}
    assert {path for path, _ in others} >= {"/ws", "/ws/feedback", "/ws/topics"}


def test_a_route_needs_a_declared_operation() -> None:
    async def undeclared() -> None:
        """An endpoint."""

    with pytest.raises(TypeError, match=r"undeclared does not say which role it needs"):
        router.get("/undeclared")(undeclared)
