"""A client of some routes, whose application is made of the parts that they need."""

from typing import Any, Self

from starlette.testclient import TestClient

from dock_gateway.app import create_app
from dock_gateway.core.fanout import Fanout
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from tests.support.audit import audit_parts
from tests.support.shapes import check_answer


class RouteClient:
    """Sends requests without a network.

    Args:
        parts: What the routes need, besides what every request does.

    Attributes:
        http: The client beneath.
    """

    def __init__(self, parts: dict[type, Any] | None = None) -> None:
        settings = Settings(database_url="memory:")
        self.parts = Parts({**audit_parts(), Settings: settings, Fanout: Fanout(queue_limit=10), **(parts or {})})
        self.app = create_app(settings, self.parts)
        self.http = TestClient(self.app, base_url="http://127.0.0.1:8000")

    def __enter__(self) -> Self:
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
