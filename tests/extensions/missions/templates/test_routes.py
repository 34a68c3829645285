"""Templates over HTTP: stored, checked, listed, and made missions of."""

from collections.abc import Iterator
from typing import Any

import pytest

from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.missions.templates.template import TemplateBody
from tests.extensions.missions.client import Client

PARAMETERS: dict[str, Any] = {"order": {"description": "How many"}, "seconds": {"default": 5}}
STEPS: list[Any] = [{"action": {"name": "/fibonacci", "goal": "$order"}}, {"wait": {"seconds": "$seconds"}}]
FETCH: dict[str, Any] = {"name": "Fetch", "priority": 70, "parameters": PARAMETERS, "steps": STEPS}
FIVE: dict[str, Any] = {"order": {"order": 5}}


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def one(client: Client, method: str, template_id: str, status: int = 200, **more: Any) -> Any:
    path = "/mission-templates/{template_id}"
    return client.send(method, f"/mission-templates/{template_id}", status, template=path, **more)


def test_a_template_is_stored_changed_and_removed(client: Client) -> None:
    answer = client.http.put("/mission-templates/fetch", json=FETCH | {"by": "Ada"})
    assert (answer.status_code, answer.headers["location"]) == (201, "/mission-templates/fetch")
    template = one(client, "GET", "fetch")
    assert template == answer.json()
    assert (template["id"], template["steps"], template["changed_by"]) == ("fetch", STEPS, "Ada")
    assert template["parameters"]["seconds"] == {"description": None, "default": 5}
    fresh = {"If-Match": template["etag"]}
    again = one(client, "PUT", "fetch", json=FETCH | {"priority": 80}, headers=fresh)
    assert again["priority"] == 80
    assert one(client, "PUT", "fetch", 412, json=FETCH, headers=fresh)["code"] == "changed_meanwhile"
    one(client, "PUT", "charge", 201, json={"steps": [{"dock": {}}]})
    assert [each["id"] for each in client.send("GET", "/mission-templates")["templates"]] == ["charge", "fetch"]
    one(client, "DELETE", "fetch", 204)
    assert one(client, "GET", "fetch", 404)["code"] == "template_not_found"


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"steps": []}, "steps"),
        ({"steps": [{"dock": {}}]}, "parameters.order"),
        ({"parameters": {}}, "steps.0.action.goal"),
        ({"parameters": {"1st": {}}}, "parameters.1st"),
        ({"parameters": PARAMETERS | {"order": {"default": 1}}}, "steps.0.action.goal"),
        ({"parameters": {"order": {"kind": "number"}}}, "parameters.order.kind"),
        ({"priority": 101}, "priority"),
        ({"battery": {"below": 0.5, "charge_to": 0.4}}, "battery.charge_to"),
        ({"robot": "/"}, "robot"),
    ],
)
def test_what_is_no_template(client: Client, change: dict[str, Any], path: str) -> None:
    assert one(client, "PUT", "fetch", 422, json=FETCH | change)["errors"][0]["path"] == path


def test_a_mission_has_the_battery_of_its_template_unless_it_has_its_own(client: Client) -> None:
    limits = {"below": 0.25, "charge_to": 0.8}
    template = one(client, "PUT", "fetch", 201, json=FETCH | {"battery": limits})
    assert template["battery"] == limits
    assert client.post({"template": "fetch", "arguments": FIVE})["battery"] == limits
    own = {"below": 0.3, "charge_to": 0.9}
    assert client.post({"template": "fetch", "arguments": FIVE, "battery": own})["battery"] == own
    one(client, "PUT", "plain", 201, json=FETCH)
    assert client.post({"template": "plain", "arguments": FIVE})["battery"] is None


def test_a_mission_is_made_of_a_template(client: Client) -> None:
    one(client, "PUT", "fetch", 201, json=FETCH)
    mission = client.post({"template": "fetch", "arguments": FIVE})
    assert (mission["name"], mission["priority"], mission["template"]) == ("Fetch", 70, "fetch")
    assert mission["arguments"] == FIVE
    assert [mission["steps"][0]["action"]["goal"], mission["steps"][1]["wait"]["seconds"]] == [{"order": 5}, 5]
    own = client.post({"template": "fetch", "arguments": FIVE | {"seconds": 9}, "name": "Five", "priority": 1})
    assert (own["name"], own["priority"], own["steps"][1]["wait"]["seconds"]) == ("Five", 1, 9)
    one(client, "DELETE", "fetch", 204)
    assert client.get(own["mission_id"])["template"] == "fetch"
    assert client.post()["template"] is None


@pytest.mark.parametrize(
    ("body", "path"),
    [
        ({}, "arguments.order"),
        ({"arguments": {}}, "arguments.order"),
        ({"arguments": FIVE | {"speed": 1}}, "arguments.speed"),
        ({"arguments": {"order": 5}}, "arguments.order"),
        ({"arguments": {"order": {"number": 5}}}, "arguments.order"),  # the action refuses it
        ({"arguments": FIVE | {"seconds": -1}}, "arguments.seconds"),
        ({"arguments": FIVE, "steps": [{"dock": {}}]}, ""),
    ],
)
def test_what_is_no_mission_of_a_template(client: Client, body: dict[str, Any], path: str) -> None:
    one(client, "PUT", "fetch", 201, json=FETCH)
    assert client.post({"template": "fetch"} | body, 422)["errors"][0]["path"] == path
    assert client.ids() == []


def test_a_template_has_to_be_there_and_arguments_are_for_one(client: Client) -> None:
    assert client.post({"template": "fetch"}, 404)["code"] == "template_not_found"
    assert client.post({"steps": [{"dock": {}}], "arguments": {}}, 422)["errors"][0]["path"] == "arguments"
    assert client.post({}, 422)["errors"][0]["expected"] == "one of steps and template"


def test_a_request_of_a_template_that_is_sent_twice(client: Client) -> None:
    one(client, "PUT", "fetch", 201, json=FETCH)
    key = {"Idempotency-Key": "five"}
    first = client.post({"template": "fetch", "arguments": FIVE}, **key)
    one(client, "PUT", "fetch", json=FETCH | {"name": "Get", "steps": [*STEPS, {"dock": {}}]})
    assert client.post({"template": "fetch", "arguments": FIVE}, **key)["mission_id"] == first["mission_id"]
    other = client.post({"template": "fetch", "arguments": {"order": {"order": 6}}}, 409, **key)
    assert other["code"] == "idempotency_key_reused"


def test_a_login_sees_the_templates_whose_names_it_covers(client: Client) -> None:
    steps: dict[str, list[Any]] = {
        "wave": [{"repeat": {"steps": [{"action": {"name": "/robot2/wave"}}], "times": 2}}],
        "reset": [{"first_that_works": [{"call": {"service": "/robot2/reset"}}]}],
        "light": [{"publish": {"topic": "/robot2/light"}}],
        "fetch": [{"dock": {}}],
    }
    assert client.http.portal is not None
    for template_id, each in steps.items():
        client.http.portal.call(client.templates.replace, template_id, TemplateBody(steps=each, parameters={}).entry())

    def seen(**limits: Any) -> list[str]:
        assert client.http.portal is not None
        found = client.http.portal.call(client.templates.documents, Grant(Role.VIEWER, **limits))
        return [each["id"] for each in found]

    assert seen() == ["fetch", "light", "reset", "wave"]
    assert seen(robots=("/robot1",)) == ["fetch"]
    assert seen(robots=("/robot2",)) == ["fetch", "light", "reset", "wave"]
    assert seen(robots=("/robot2",), actions=("/robot2/wave",)) == ["fetch", "wave"]
