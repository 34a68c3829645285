"""Schedules over HTTP: stored, checked, listed within a grant and removed."""

from collections.abc import Iterator
from typing import Any

import pytest

from dock_gateway.core.grant import UNLIMITED, Grant, Role
from tests.extensions.missions.client import Client
from tests.extensions.missions.schedules.examples import HOURLY, MISSION, body

DAILY: dict[str, Any] = {"daily": {"times": ["22:00", "06:00"], "time_zone": "Europe/Berlin"}}
NIGHT: dict[str, Any] = {"mission": MISSION, **DAILY}


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def one(client: Client, method: str, schedule_id: str, status: int = 200, **more: Any) -> Any:
    return client.send(method, f"/schedules/{schedule_id}", status, template="/schedules/{schedule_id}", **more)


def test_a_schedule_is_stored_switched_off_and_removed(client: Client) -> None:
    answer = client.http.put("/schedules/night", json=NIGHT | {"by": "Ada", "name": "Night"})
    assert (answer.status_code, answer.headers["location"]) == (201, "/schedules/night")
    found = one(client, "GET", "night")
    assert found == answer.json()
    assert (found["robot"], found["enabled"], found["if_running"], found["last"]) == ("/", True, "skip", None)
    assert found["daily"]["times"] == ["06:00", "22:00"]
    assert len(found["daily"]["weekdays"]) == 7
    assert found["next_at"] is not None
    fresh = {"If-Match": found["etag"]}
    off = one(client, "PUT", "night", json=NIGHT | {"enabled": False}, headers=fresh)
    assert (off["enabled"], off["next_at"]) == (False, None)
    assert one(client, "PUT", "night", 412, json=NIGHT, headers=fresh)["code"] == "changed_meanwhile"
    one(client, "PUT", "day", 201, json={"mission": MISSION, **HOURLY, "robot": "/robot1"})
    assert [each["id"] for each in client.send("GET", "/schedules")["schedules"]] == ["day", "night"]
    grouped = one(client, "PUT", "day", json={"mission": MISSION, **HOURLY, "group": "pickers"})
    assert (grouped["robot"], grouped["group"]) == (None, "pickers")
    one(client, "DELETE", "night", 204)
    assert one(client, "GET", "night", 404)["code"] == "schedule_not_found"


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"daily": None}, ""),
        (HOURLY, ""),
        ({"daily": None, "every": {"minutes": 0}}, "every.minutes"),
        ({"daily": None, "once": {"due_at": "tomorrow"}}, "once.due_at"),
        ({"daily": None, "once": {"due_at": "2020-01-01T00:00:00Z"}}, "once.due_at"),
        ({"daily": DAILY["daily"] | {"times": ["24:00"]}}, "daily.times.0"),
        ({"daily": DAILY["daily"] | {"weekdays": ["funday"]}}, "daily.weekdays.0"),
        ({"daily": DAILY["daily"] | {"time_zone": "Europe/Atlantis"}}, "daily.time_zone"),
        ({"if_running": "wait"}, "if_running"),
        ({"robot": "robot 1"}, "robot"),
        ({"robot": "/robot1", "group": "pickers"}, "group"),
        ({"group": ""}, "group"),
        ({"mission": {}}, "mission"),
        ({"mission": {"steps": [{"fly": {}}]}}, "mission.steps.0.fly"),
        ({"mission": {"steps": [{"navigate": {"place": "shelf"}}]}}, "mission.steps.0.navigate.place"),
        ({"mission": {"steps": [{"action": {"name": "/fibonacci"}}]}}, "mission.steps.0.action.goal"),
        ({"mission": {"template": "fetch"}}, "mission.arguments.order"),
        ({"mission": {"template": "fetch", "arguments": {"order": {}}}}, "mission.arguments.order"),
    ],
)
def test_what_is_no_schedule(client: Client, change: dict[str, Any], path: str) -> None:
    steps = [{"action": {"name": "/fibonacci", "goal": "$order"}}]
    template = {"parameters": {"order": {}}, "steps": steps}
    client.http.put("/mission-templates/fetch", json=template).raise_for_status()
    assert one(client, "PUT", "night", 422, json=NIGHT | change)["errors"][0]["path"] == path
    assert client.send("GET", "/schedules")["schedules"] == []


def test_what_is_not_there_or_not_allowed(client: Client) -> None:
    assert one(client, "PUT", "night", 404, json=NIGHT | {"robot": "/nowhere"})["code"] == "robot_not_found"
    gone = one(client, "PUT", "night", 404, json=NIGHT | {"mission": {"template": "fetch"}})
    assert gone["code"] == "template_not_found"
    refused = one(client, "PUT", "night", 403, json=NIGHT | {"mission": {"steps": [{"call": {"service": "/other"}}]}})
    assert refused["code"] == "not_allowed"
    past = {"mission": MISSION, "once": {"due_at": "2020-01-01T00:00:00Z"}, "enabled": False}
    assert one(client, "PUT", "old", 201, json=past)["next_at"] is None


def test_a_login_sees_the_schedules_whose_missions_it_covers(client: Client) -> None:
    wave = {"steps": [{"action": {"name": "/robot1/wave"}}]}
    bodies = {
        "own": body(robot="/robot1"),
        "wave": body(robot="/robot1", mission=wave),
        "other": body(robot="/robot2"),
    }
    assert client.http.portal is not None
    for schedule_id, each in bodies.items():
        client.http.portal.call(client.schedules.replace, schedule_id, each, UNLIMITED)

    def seen(**limits: Any) -> list[str]:
        assert client.http.portal is not None
        found = client.http.portal.call(client.schedules.documents, Grant(Role.VIEWER, **limits))
        return [each["id"] for each in found]

    assert seen() == ["other", "own", "wave"]
    assert seen(robots=("/robot1",)) == ["own", "wave"]
    assert seen(robots=("/robot1",), actions=("/robot1/dock",)) == ["own"]
    assert seen(robots=("/robot3",)) == []
