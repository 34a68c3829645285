"""Labels over HTTP: what is stored, and what is refused with which field or code."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.robots.robots import Robots
from tests.support.entries import EntriesInMemory
from tests.support.route_client import RouteClient

LEFT = {"display_name": "Left forklift", "groups": ["hall 1", "forklifts"]}


class Client(RouteClient):
    """`/label` of a gateway with the robots `/` and `/robot1`."""

    def __init__(self) -> None:
        self.labels = Labels(EntriesInMemory[RobotLabel](), lambda: ["/", "/robot1"])
        super().__init__({Labels: self.labels, Robots: SimpleNamespace(default_namespace="/")})

    def put(self, status: int = 200, robot: str = "/robot1", **content: Any) -> Any:
        answer = self.send("PUT", f"/label?robot={robot}", status, **content)
        if status == 200:
            assert self.send("GET", f"/label?robot={robot}") == answer
            del answer["etag"]
        return answer


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def test_a_label_is_replaced_and_removed(client: Client) -> None:
    assert client.put(json=LEFT) == {"robot": "/robot1", **LEFT}
    assert client.labels.get("/robot1") == RobotLabel("Left forklift", ("hall 1", "forklifts"))
    nameless = {"display_name": None, "groups": ["hall 2"]}
    assert client.put(json=nameless) == {"robot": "/robot1", **nameless}
    empty = {"display_name": None, "groups": []}
    assert client.put(json=empty) == {"robot": "/robot1", **empty}
    assert client.labels.get("/robot1") == RobotLabel(None, ())


def test_of_two_people_who_change_a_label_none_loses_a_change(client: Client) -> None:
    seen = client.send("GET", "/label?robot=/robot1")
    assert {name: seen[name] for name in LEFT} == {"display_name": None, "groups": []}
    client.put(json=LEFT, headers={"If-Match": seen["etag"]})
    other = {"display_name": "Right forklift", "groups": []}
    refused = client.put(412, json=other, headers={"If-Match": seen["etag"]})
    assert refused["code"] == "changed_meanwhile"
    assert client.labels.get("/robot1").display_name == "Left forklift"
    again = client.http.get("/label?robot=/robot1").headers["etag"]
    client.put(json=other, headers={"If-Match": again})
    client.put(json=LEFT)


def test_a_label_is_set_only_where_there_is_none_yet(client: Client) -> None:
    only_new = {"If-None-Match": "*"}
    client.put(json=LEFT, headers=only_new)
    refused = client.put(412, json={"display_name": "Right forklift", "groups": []}, headers=only_new)
    assert refused["code"] == "changed_meanwhile"
    assert client.labels.get("/robot1").display_name == "Left forklift"
    client.put(json={"display_name": None, "groups": []})
    client.put(json=LEFT, headers=only_new)


def test_spaces_and_groups_that_repeat_are_removed(client: Client) -> None:
    sent = {"display_name": " Gl\u00fcck 7 ", "groups": [" hall 1", "hall 2", "hall 1 "]}
    assert client.put(robot="/site/robot9/", json=sent) == {
        "robot": "/site/robot9",
        "display_name": "Gl\u00fcck 7",
        "groups": ["hall 1", "hall 2"],
    }
    longest = {"display_name": 60 * "n", "groups": [f"{number:040}" for number in range(20)]}
    robot = "/" + 254 * "r"
    assert client.put(robot=robot, json=longest) == {"robot": robot, **longest}


def test_a_label_of_no_robot_in_particular_is_that_of_the_configured_one(client: Client) -> None:
    assert client.send("PUT", "/label", json=LEFT)["robot"] == "/"
    assert client.labels.get("/").display_name == "Left forklift"


def test_requests_that_are_not_a_label(client: Client) -> None:
    assert client.put(400, content=b"{")["code"] == "malformed_json"
    assert client.put(400, content=b'{"display_name": "\\ud800"}')["code"] == "malformed_json"
    assert client.put(415, content=b"{}", headers={"Content-Type": "text/plain"})["code"] == "unsupported_media_type"
    assert client.put(422)["code"] == "invalid_field"
    assert client.put(422, json=[LEFT])["code"] == "invalid_field"
    for robot in ("robot1", "/robot1&robot=/robot2"):
        assert client.put(422, robot, json=LEFT)["errors"][0]["path"] == "robot"
    assert client.put(422, json=LEFT | {"robot": "/robot1"})["errors"][0]["path"] == "robot"
    assert client.put(422, json=LEFT | {"groups": ["hall 1", ""]})["errors"][0]["path"] == "groups.1"
    assert client.labels.get("/robot1") == RobotLabel(None, ())


def test_a_name_that_is_taken(client: Client) -> None:
    client.put(json=LEFT)
    for name in ("left FORKLIFT", "/robot1"):
        problem = client.put(409, "/robot2", json={"display_name": name, "groups": []})
        assert problem["code"] == "display_name_taken"
        assert "/robot1" in problem["detail"]


def test_a_history_that_does_not_answer(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    async def fail(*_: object) -> None:
        raise Unavailable("the history database does not answer", code="history_unavailable")

    client.put(json=LEFT)
    monkeypatch.setattr(EntriesInMemory, "write", fail)
    assert client.put(503, json=LEFT | {"display_name": None})["code"] == "history_unavailable"
    assert client.labels.get("/robot1").display_name == "Left forklift"
