"""The answer of a command is the state after it: what is read right after the answer says the same."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.support.access import Site, bearer
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway, running_program
from tests.support.installed import is_there, needs
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

PARAMETERS = "/nodes/dock_simulator/parameters"
PUBLISHED = {"state": {"percentage": 0.5}, "rate_hz": 0.1}
RULE = {"name": "Low battery", "robots": {"all": True}, "battery": {"below": 0.3, "idle_s": 10}, "by": "Ada"}
HOOK = {"name": "Room", "url": "http://127.0.0.1:9/", "severities": ["critical"], "by": "Ada"}
USER = {"role": "operator", "password": "correct horse battery staple"}
LABEL = {"display_name": "Forklift", "groups": ["hall 1"]}
AT_DOCK, AWAY = {"x": -0.2, "y": 0.0, "theta": 0.0}, {"x": -1.2, "y": 0.3, "theta": 0.0}

# Reads what is compared from a document, with the ids that are known so far.
Pick = Callable[[Any, dict[str, str]], Any]


def whole(document: Any, _: dict[str, str]) -> Any:
    return document


def nothing(_: Any, __: dict[str, str]) -> Any:
    return None


def without(*fields: str) -> Pick:
    """Leave out what changes by itself, and what only the answer has."""
    return lambda document, _: {name: value for name, value in document.items() if name not in fields}


def part(name: str, then: Pick = whole) -> Pick:
    return lambda document, ids: then(document[name], ids)


def only(*fields: str) -> Pick:
    return lambda document, _: {name: document[name] for name in fields}


def entry(of: str, key: str, value: str, then: Pick = whole) -> Pick:
    """Pick the entry of a list; None if it is not there. In braces is the name of an id."""

    def pick(document: Any, ids: dict[str, str]) -> Any:
        found = (each for each in document[of] if each[key] == value.format(**ids))
        return next((then(each, ids) for each in found), None)

    return pick


def is_canceled(goal: Any, _: dict[str, str]) -> Any:
    return goal["status"] in ("canceling", "canceled")


class Case(NamedTuple):
    """A command, where its state is read, and what has to be the same in the answer and there."""

    method: str
    path: str
    body: Any
    read: str
    of_answer: Pick = whole
    of_state: Pick = whole


SIMULATOR = without("docked")  # the charger takes a moment to give power, and may have done so since
SAID = without("persisted")  # the disk may be slower than the answer
PERIOD = entry("parameters", "name", "battery_resume_after", part("value"))
LABELED = only("display_name", "groups")
PLACE, GOAL = "/simulator/place", "/goals/{goal}"
NOTE = entry("notes", "id", "{note}")
ACKNOWLEDGEMENT, ALERT = "/alerts/{alert}/acknowledgement", entry("alerts", "id", "{alert}")

# In the order in which they are carried out. Not among them are commands whose answer is no state (a published
# message, a called service), and those that need a provider, an agent, or a robot that stands still on its dock.
CASES = {
    "placed on the dock": Case("POST", PLACE, AT_DOCK, "/simulator", SIMULATOR, SIMULATOR),
    "placed elsewhere": Case("POST", PLACE, AWAY, "/simulator", whole, whole),
    "a fault": Case("PUT", "/simulator/faults/stuck_wheel", {"active": True}, "/simulator"),
    "placed at the dock again": Case("POST", PLACE, AT_DOCK, "/simulator", SIMULATOR, SIMULATOR),
    "reset": Case("POST", "/simulator/reset", None, "/simulator"),
    "a publisher": Case("PUT", "/battery/publisher", PUBLISHED, "/battery/publisher"),
    "no publisher": Case("DELETE", "/battery/publisher", None, "/battery/publisher", nothing, part("state")),
    "a parameter": Case("PATCH", PARAMETERS, {"battery_resume_after": 7.5}, PARAMETERS, PERIOD, PERIOD),
    "a stop": Case("POST", "/stop", {"by": "Ada"}, "/stop", part("stop", SAID), SAID),
    "acknowledged": Case("PUT", ACKNOWLEDGEMENT, {"by": "Ada"}, "/alerts", whole, ALERT),
    "not acknowledged": Case(
        "DELETE", ACKNOWLEDGEMENT, None, "/alerts", nothing, lambda read, ids: ALERT(read, ids)["acknowledged"]
    ),
    "a release": Case("DELETE", "/stop", None, "/stop", SAID, SAID),
    "a label": Case("PUT", "/label", LABEL, "/robots", LABELED, entry("robots", "name", "/", LABELED)),
    "a rule": Case(
        "PUT",
        "/automation/rules/low",
        RULE,
        "/automation/rules",
        without("applies_to"),
        entry("rules", "id", "low", without("applies_to")),
    ),
    "no rule": Case("DELETE", "/automation/rules/low", None, "/automation/rules", nothing, entry("rules", "id", "low")),
    "a webhook": Case("PUT", "/webhooks/room", HOOK, "/webhooks", without("secret"), entry("webhooks", "id", "room")),
    "no webhook": Case("DELETE", "/webhooks/room", None, "/webhooks", nothing, entry("webhooks", "id", "room")),
    "a user": Case("PUT", "/users/bob", USER, "/users", whole, entry("users", "name", "bob")),
    "another role": Case("PUT", "/users/bob", {"role": "viewer"}, "/users", whole, entry("users", "name", "bob")),
    "no user": Case("DELETE", "/users/bob", None, "/users", nothing, entry("users", "name", "bob")),
    "a token": Case(
        "POST",
        "/tokens",
        {"name": "script", "role": "viewer"},
        "/tokens",
        without("secret"),
        entry("tokens", "name", "script"),
    ),
    "no token": Case("DELETE", "/tokens/{token}", None, "/tokens", nothing, entry("tokens", "id", "{token}")),
    "a goal": Case("POST", "/dock", {}, GOAL, part("goal_id"), part("goal_id")),
    "tags": Case("PUT", GOAL + "/tags", {"tags": ["blocked"]}, GOAL, only("tags"), only("tags")),
    "a note": Case("POST", GOAL + "/notes", {"by": "Ada", "text": "Lens wiped"}, GOAL, whole, NOTE),
    "no note": Case("DELETE", GOAL + "/notes/{note}", None, GOAL, nothing, NOTE),
    "canceled": Case("POST", GOAL + "/cancel", None, GOAL, is_canceled, is_canceled),
}


EXTENSIONS = {"a rule": "automation", "no rule": "automation", "a webhook": "webhooks", "no webhook": "webhooks"}


@pytest.fixture
def gateway(domain: int, tmp_path: Path) -> Iterator[RunningGateway]:
    site = Site(tmp_path)
    admin = bearer(site.token("test", "admin"))
    with (
        running_program(domain, "dock_simulator"),
        running_dock_server(domain),
        site.gateway(domain, allow_parameters="/dock_simulator") as gateway,
    ):
        gateway.http.headers.update(admin)
        gateway.wait_until_ready()
        for path in ("/simulator", PARAMETERS):
            wait_until(lambda path=path: gateway.http.get(path).status_code == 200, path)
        yield gateway


def learn(gateway: RunningGateway, name: str, answer: Any) -> dict[str, str]:
    """Return the id that an answer brings, by its name."""
    match name:
        case "a stop":
            found = wait_until(lambda: gateway.http.get("/alerts").json()["alerts"], "the alert of the stop")
            return {"alert": found[0]["id"]}
        case "a token":
            return {"token": answer["id"]}
        case "a note":
            return {"note": answer["id"]}
    return {}


@needs("simulator")
def test_what_is_read_right_after_a_command_is_what_it_answered(gateway: RunningGateway) -> None:
    ids: dict[str, str] = {}
    wrong = {}
    for name, case in ((name, case) for name, case in CASES.items() if is_there(name, EXTENSIONS)):
        response = gateway.http.request(case.method, case.path.format(**ids), json=case.body).raise_for_status()
        answer = response.json() if response.content else None
        if name == "a goal":
            ids["goal"] = answer["goal_id"]
        state = gateway.http.get(case.read.format(**ids)).raise_for_status().json()
        ids |= learn(gateway, name, answer)
        answered, read = case.of_answer(answer, ids), case.of_state(state, ids)
        if answered != read:
            wrong[name] = answered, read
    assert wrong == {}


def test_a_battery_state_that_was_published_is_the_latest(domain: int) -> None:
    """It goes over ROS and comes back: other publishers' messages count as much as the gateway's."""
    with running_gateway(domain) as gateway:
        late = []
        for percentage in range(100):
            published = gateway.http.post("/battery", json={"percentage": percentage / 100}).raise_for_status().json()
            if gateway.http.get("/battery").raise_for_status().json()["state"] != published["state"]:
                late.append(percentage)
        assert late == []
