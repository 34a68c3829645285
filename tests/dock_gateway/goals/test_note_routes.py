"""Notes and tags over HTTP: what is stored, and what is refused with which field or code."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.fanout import Fanout
from dock_gateway.extension import extensions
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.storage import History
from tests.support.history import HistoryInMemory, make_goal
from tests.support.robot_actions import make_known_robots, make_robot_actions
from tests.support.route_client import RouteClient

GOAL = "00000000-0000-4000-8000-000000000001"
PATH = f"/goals/{GOAL}"
NOTES, TAGS = f"{PATH}/notes", f"{PATH}/tags"
BLOCKED = {"by": "Ada", "text": "wheel was blocked by a box"}


class Client(RouteClient):
    """A gateway with one goal."""

    def __init__(self) -> None:
        self.history = HistoryInMemory()
        self.history.record(make_goal(1, goal_id=GOAL))
        live: Any = SimpleNamespace(goal=lambda _: None)
        actions, documents = make_robot_actions(), GoalDocuments(self.history)
        documents.fields |= dict.fromkeys(extensions().goal_fields)
        super().__init__(
            {
                Fanout: Fanout(queue_limit=10),
                History: self.history,
                Goals: Goals(live, actions, self.history),
                GoalDocuments: documents,
                RobotActions: actions,
                KnownRobots: make_known_robots(self.history),
            }
        )

    def written(self) -> dict[str, Any]:
        """Return what is written about the goal."""
        goal = self.send("GET", PATH)
        return {name: goal[name] for name in ("tags", "notes")}


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def test_notes_and_tags(client: Client) -> None:
    assert client.written() == {"tags": [], "notes": []}
    note = client.send("POST", NOTES, 201, json=BLOCKED | {"by": " Ada  "})
    assert {name: note[name] for name in BLOCKED} == BLOCKED
    assert note["created_at"].endswith("Z")
    lines = {"by": "Bob", "text": " one\r\n\ttwo 👩‍🔧\n"}
    other = client.send("POST", NOTES, 201, json=lines)
    assert other["text"] == "one\n\ttwo 👩‍🔧"
    changed = client.send("PUT", TAGS, json={"tags": [" maintenance", "blocked", "blocked "]})
    assert client.send("GET", TAGS) == changed
    tags = {"tags": ["blocked", "maintenance"]}
    assert changed == tags | {"etag": changed["etag"]}
    assert client.send("GET", "/goals/tags") == tags
    assert client.written() == tags | {"notes": [note, other]}
    client.send("DELETE", f"{NOTES}/{note['id']}", 204)
    assert client.written() == tags | {"notes": [other]}
    (listed,) = client.send("GET", "/goals?tag=blocked")["goals"]
    assert listed == client.send("GET", PATH)
    client.send("DELETE", f"{NOTES}/{note['id']}", 204)  # a second time, too
    assert client.send("DELETE", f"{NOTES}/%00", 422)["errors"][0]["path"] == "note_id"
    assert client.send("GET", f"/goals/{GOAL.replace('-', '').upper()}") == listed
    assert client.send("PUT", TAGS, json={"tags": []})["tags"] == []


def test_of_two_people_who_change_the_tags_none_loses_a_change(client: Client) -> None:
    seen = client.send("GET", TAGS)
    assert client.http.get(TAGS).headers["etag"] == seen["etag"]
    condition = {"If-Match": seen["etag"]}
    ada = client.send("PUT", TAGS, json={"tags": ["blocked"]}, headers=condition)
    refused = client.send("PUT", TAGS, 412, json={"tags": ["late"]}, headers=condition)
    assert refused["code"] == "changed_meanwhile"
    assert client.written()["tags"] == ["blocked"]
    client.send("PUT", TAGS, json={"tags": ["blocked", "late"]}, headers={"If-Match": ada["etag"]})
    assert client.send("PUT", TAGS, json={"tags": []})["etag"] == seen["etag"]


def test_notes_and_tags_that_are_refused(client: Client) -> None:
    """test_bodies.py has all that may be wrong."""
    for method, path, body, wrong in (
        ("POST", NOTES, BLOCKED | {"text": " \n "}, "text"),
        ("PUT", TAGS, {"tags": ["fine", " "]}, "tags.1"),
    ):
        assert [error["path"] for error in client.send(method, path, 422, json=body)["errors"]] == [wrong]
    assert client.written() == {"tags": [], "notes": []}


def test_a_running_goal_is_shown_while_the_history_is_away(client: Client) -> None:
    async def away(_: object) -> Any:
        raise Unavailable("the history database does not answer", code="history_unavailable")

    client.history.notes.read = away  # type: ignore[method-assign]
    assert client.written() == {"tags": None, "notes": None}


def test_a_goal_that_is_not_there(client: Client) -> None:
    missing = "/goals/00000000-0000-4000-8000-000000000002"
    for method, path, content in (
        ("GET", "", {}),
        ("GET", "/tags", {}),
        ("POST", "/notes", {"json": BLOCKED}),
        ("DELETE", f"/notes/{'0' * 32}", {}),
        ("PUT", "/tags", {"json": {"tags": []}}),
    ):
        assert client.send(method, missing + path, 404, **content)["code"] == "goal_not_found"
