"""A client of some routes, whose application is made of the parts that they need."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import cache
from typing import Any, Self

from fastapi import FastAPI
from starlette.testclient import TestClient

from dock_gateway.app import create_app
from dock_gateway.core.fanout import Fanout
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from tests.support.audit import audit_parts
from tests.support.shapes import check_answer

SETTINGS = Settings(database_url="memory:")


@cache
def _app() -> FastAPI:
    """The application, which takes a while to make; the parts come with each request."""
    return create_app(SETTINGS, Parts(audit_parts()))


class RouteClient:
    """Sends requests without a network.

    Args:
        parts: What the routes need, besides what every request does.

    Attributes:
        http: The client beneath.
    """

    def __init__(self, parts: dict[type, Any] | None = None) -> None:
        self.parts = Parts({**audit_parts(), Settings: SETTINGS, Fanout: Fanout(queue_limit=10), **(parts or {})})
        self.http = TestClient(_app(), base_url="http://127.0.0.1:8000")

    @asynccontextmanager
    async def opened(self, _: FastAPI) -> AsyncIterator[dict[str, Any]]:
        """Open the parts."""
        yield {"parts": self.parts}

    def __enter__(self) -> Self:
        _app().router.lifespan_context = self.opened
        self.http.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self.http.__exit__()

    def send(self, method: str, path: str, status: int = 200, *, template: str = "", **content: Any) -> Any:
        """Send a request. The answer has this status, and is as the OpenAPI document says; return its JSON.

        Args:
            method: The method.
            path: The path, with the query.
            status: What the answer has to be.
            template: The path as the document has it, where it is another one.
            content: As httpx takes it: `json`, `content`, `headers`.
        """
        answer = self.http.request(method, path, **content)
        assert answer.status_code == status, answer.text
        kind = answer.headers.get("content-type", "")
        check_answer(method, template or path.partition("?")[0], status, kind, answer.content)
        return answer.json() if answer.content else None
