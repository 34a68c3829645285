"""Notes and tags over HTTP: what is stored, and what is refused with which field or code."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, Self

import pytest
from starlette.testclient import TestClient

from dock_gateway.access.logins import Logins
from dock_gateway.app import create_app
from dock_gateway.goals.goals import Goals
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory, make_goal
from tests.support.robot_actions import make_robot_actions
from tests.support.shapes import check_answer

GOAL = "00000000-0000-4000-8000-000000000001"
NOTES, TAGS = f"/goals/{GOAL}/notes", f"/goals/{GOAL}/tags"
BLOCKED = {"by": "Ada", "text": "wheel was blocked by a box"}


class Client:
    """A gateway with one goal."""

    def __init__(self) -> None:
        self.history = HistoryInMemory()
        self.history.record(make_goal(1, goal_id=GOAL))
        settings = Settings(database_url="memory:")
        live: Any = SimpleNamespace(goal=lambda _: None)
        goals = Goals(live, make_robot_actions(), self.history)
        access = {Logins: Logins(self.history), Quotas: Quotas(settings)}
        parts = Parts({**audit_parts(), **access, Settings: settings, History: self.history, Goals: goals})
        self._http = TestClient(create_app(settings, parts), base_url="http://127.0.0.1:8000")

    def __enter__(self) -> Self:
        self._http.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._http.__exit__()

    def __call__(self, method: str, path: str, status: int = 200, **content: Any) -> Any:
        answer = self._http.request(method, path, **content)
        assert answer.status_code == status, answer.text
        check_answer(method, path.partition("?")[0], status, answer.headers["content-type"], answer.content)
        return answer.json()


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def test_notes_and_tags(client: Client) -> None:
    assert client("GET", NOTES) == {"tags": [], "notes": []}
    (note,) = client("POST", NOTES, 201, json=BLOCKED | {"by": " Ada  "})["notes"]
    assert {name: note[name] for name in BLOCKED} == BLOCKED
    assert note["at"].endswith("Z")
    lines = {"by": "Bob", "text": " one\r\n\ttwo 👩‍🔧\n"}
    assert client("POST", NOTES, 201, json=lines)["notes"][1]["text"] == "one\n\ttwo 👩‍🔧"
    tags = client("PUT", TAGS, json={"tags": [" maintenance", "blocked", "blocked "]})["tags"]
    assert tags == ["blocked", "maintenance"]
    assert client("GET", "/goals/tags") == {"tags": tags}
    left = client("DELETE", f"{NOTES}/{note['note_id']}")
    assert [each["by"] for each in left["notes"]] == ["Bob"]
    assert client("DELETE", f"{NOTES}/{note['note_id']}", 404)["code"] == "note_not_found"
    assert client("DELETE", f"{NOTES}/%00", 422)["errors"][0]["path"] == "path.note_id"
    assert client("GET", f"/goals/{GOAL.replace('-', '').upper()}/notes") == left
    assert client("PUT", TAGS, json={"tags": []})["tags"] == []


def test_notes_and_tags_that_are_refused(client: Client) -> None:
    """test_bodies.py has all that may be wrong."""
    for method, path, body, wrong in (
        ("POST", NOTES, BLOCKED | {"text": " \n "}, "text"),
        ("PUT", TAGS, {"tags": ["fine", " "]}, "tags.1"),
    ):
        assert [error["path"] for error in client(method, path, 422, json=body)["errors"]] == [wrong]
    assert client("GET", NOTES) == {"tags": [], "notes": []}


def test_a_goal_that_is_not_there(client: Client) -> None:
    missing = "/goals/00000000-0000-4000-8000-000000000002"
    for method, path, content in (
        ("GET", "/notes", {}),
        ("POST", "/notes", {"json": BLOCKED}),
        ("DELETE", f"/notes/{'0' * 32}", {}),
        ("PUT", "/tags", {"json": {"tags": []}}),
    ):
        assert client(method, missing + path, 404, **content)["code"] == "goal_not_found"
