"""Which routers are asked for the route of a request."""

from typing import Any
from uuid import UUID

import pytest
from fastapi import APIRouter, FastAPI
from starlette.routing import BaseRoute, Match

from dock_gateway.app import create_app
from dock_gateway.http.router_prefix import match_own_prefix
from dock_gateway.settings import Settings


def scope(path: str) -> dict[str, Any]:
    return {"type": "http", "method": "GET", "path": path, "headers": [], "root_path": ""}


def included(*paths: str) -> tuple[BaseRoute, list[str]]:
    """A router with these paths, and the paths that it is asked for."""
    router, app = APIRouter(), FastAPI(openapi_url=None)
    for path in paths:
        router.add_api_route(path, lambda: None)
    app.include_router(router)
    found, asked = app.router.routes[-1], list[str]()
    matches = found.matches

    def note(asking: Any) -> Any:
        asked.append(asking["path"])
        return matches(asking)

    found.matches = note  # type: ignore[method-assign]
    match_own_prefix(found, paths)
    return found, asked


def test_a_router_is_asked_for_what_begins_like_its_paths() -> None:
    router, asked = included("/goals", "/goals/{goal_id}", "/dock")
    for path in ("/robots", "/goal", "/", "", "/goalsx/1", "/Goals"):
        assert router.matches(scope(path)) == (Match.NONE, {})
    assert asked == []
    for path in ("/goals", "/goals/1", "/dock"):
        assert router.matches(scope(path))[0] is Match.FULL
    assert router.matches(scope("/dock/1"))[0] is Match.NONE
    assert asked == ["/goals", "/goals/1", "/dock", "/dock/1"]


@pytest.mark.parametrize("path", ["/{name}", "/{name:path}", "/re{port}/1"])
def test_a_router_whose_paths_begin_with_anything_is_always_asked(path: str) -> None:
    router, asked = included("/goals", path)
    router.matches(scope("/robots"))
    assert asked == ["/robots"]


@pytest.mark.parametrize(("path", "most"), [("/healthz", 1), ("/robots", 1), (f"/goals/{UUID(int=1)}", 5)])
def test_a_request_asks_few_routers(monkeypatch: pytest.MonkeyPatch, path: str, most: int) -> None:
    asked: list[APIRouter] = []
    matches = APIRouter.matches

    def note(router: APIRouter, asking: Any) -> Any:
        asked.append(router)
        return matches(router, asking)

    routes = create_app(Settings()).router.routes
    monkeypatch.setattr(APIRouter, "matches", note)
    assert any(route.matches(scope(path))[0] is Match.FULL for route in routes)
    assert len(asked) <= most
