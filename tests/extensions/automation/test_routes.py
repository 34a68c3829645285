"""Rules of automatic docking over HTTP: what is stored, and what is refused with which field or code."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given, settings

from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.extensions.automation.decision import DecisionEntry, DecisionOutcome
from dock_gateway.extensions.automation.decisions import DecisionLog
from dock_gateway.extensions.automation.rule import RuleEntry
from dock_gateway.extensions.automation.rules import DockingRules
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.stop.last_stops import LastStop, LastStops
from dock_gateway.storage.shared_entries import SharedBook
from tests.extensions.automation.examples import decision_entry
from tests.support.history import HistoryInMemory
from tests.support.robot_actions import make_known_robots
from tests.support.route_client import RouteClient
from tests.support.versions import STEPS, Resource, Step, require_that_nothing_is_lost

BATTERY = {"name": "Low battery", "robots": {"all": True}, "battery": {"below": 0.2, "idle_s": 60}}
NIGHT = {
    "name": "Night",
    "robots": {"names": ["/robot1", "/robot1/"], "groups": [" hall 1 "]},
    "schedule": {"times": ["22:00", "06:30", "22:00"], "weekdays": ["sun", "mon"], "time_zone": "Europe/Berlin"},
}


class Client(RouteClient):
    """`/automation` of a gateway with the robots `/` and `/robot1`."""

    def __init__(self) -> None:
        self.history = HistoryInMemory()
        labels = {"/": (), "/robot1": ("hall 1",)}
        states = [SimpleNamespace(name=name, label=SimpleNamespace(groups=groups)) for name, groups in labels.items()]
        rules = DockingRules(
            cast("Fleet", SimpleNamespace(states=lambda: states)),
            SharedBook(self.history.documents("rule", RuleEntry), "rule", 2),
            DecisionLog(Fanout(queue_limit=1), self.history.documents("decision", DecisionEntry)),
            LastStops(self.history.documents("hold", LastStop)),
        )
        super().__init__({DockingRules: rules, KnownRobots: make_known_robots(self.history, "/", "/robot1")})

    def put(self, rule: object, status: int = 200, rule_id: str = "night") -> Any:
        path = "/automation/rules/{rule_id}"
        return self.send("PUT", f"/automation/rules/{rule_id}", status, template=path, json=rule)

    def get(self, path: str, status: int = 200, query: str = "") -> Any:
        return self.send("GET", f"/automation/{path}{query}", status)

    def delete(self, rule_id: str) -> tuple[int, str]:
        answer = self.http.delete(f"/automation/rules/{rule_id}")
        return answer.status_code, answer.json()["code"] if answer.content else ""


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def test_rules_are_stored_listed_and_removed(client: Client) -> None:
    assert client.get("rules") == {"rules": []}
    night = client.put(NIGHT | {"by": " Ada "}, 201)
    assert (night["mode"], night["changed_by"], night["battery"]) == ("off", "Ada", None)
    assert night["robots"] == {"all": False, "names": ["/robot1"], "groups": ["hall 1"]}
    assert night["schedule"] == {"times": ["06:30", "22:00"], "weekdays": ["mon", "sun"], "time_zone": "Europe/Berlin"}
    assert night["applies_to"] == [{"robot": "/robot1", "waits_for": "off"}]
    low = client.put(BATTERY | {"mode": "dry_run", "schedule": None, "by": None}, 201, "low")
    assert (low["mode"], low["battery"], low["schedule"]) == ("dry_run", {"below": 0.2, "idle_s": 60.0}, None)
    assert [each["robot"] for each in low["applies_to"]] == ["/", "/robot1"]
    assert [rule["id"] for rule in client.get("rules")["rules"]] == ["low", "night"]
    assert client.delete("low") == (204, "")
    assert client.delete("low") == (204, "")
    client.get("rules/low", 404)
    assert [rule["id"] for rule in client.get("rules")["rules"]] == ["night"]


def with_schedule(**fields: object) -> dict[str, object]:
    return NIGHT | {"schedule": cast("dict[str, object]", NIGHT["schedule"]) | fields}


@pytest.mark.parametrize(
    ("rule", "path"),
    [
        ([], ""),
        (BATTERY | {"robots": {}}, "robots"),
        (BATTERY | {"robots": {"all": True, "names": ["/robot1"]}}, "robots"),
        ({"name": "a", "robots": {"all": True}}, "battery"),
        (BATTERY | {"schedule": NIGHT["schedule"]}, "battery"),
        (with_schedule(time_zone="Europe/Entenhausen"), "schedule.time_zone"),
        (with_schedule(time_zone="Europe"), "schedule.time_zone"),
        (with_schedule(time_zone="../../etc/passwd"), "schedule.time_zone"),
        (with_schedule(time_zone=""), "schedule.time_zone"),
    ],
)
def test_what_is_no_rule(client: Client, rule: object, path: str) -> None:
    """Beyond what its schema says: see test_bodies.py."""
    problem = client.put(rule, 422)
    assert [error["path"] for error in problem["errors"]] == [path]
    assert client.get("rules") == {"rules": []}


@pytest.mark.parametrize("rule_id", ["Night", "-night", "night-", "n" * 41, "n_1", "n%20t"])
def test_what_is_no_id(client: Client, rule_id: str) -> None:
    assert client.put(BATTERY, 422, rule_id)["errors"][0]["path"] == "rule_id"


def test_there_is_a_limit(client: Client) -> None:
    for rule_id in ("a", "b"):
        client.put(BATTERY, 201, rule_id)
    assert client.put(BATTERY, 409, "c")["code"] == "limit_reached"
    client.put(NIGHT, rule_id="b")


async def test_decisions_are_found_by_robot_rule_and_goal(client: Client) -> None:
    now = utc_now()
    goal_id = "6a8c2b0a-5c63-4d0e-9c1e-0d7a9c4d5e6f"
    for identity, rule_id, robot in (("a", "low", "/robot1"), ("b", "night", "/robot1"), ("c", "night", "/gone")):
        sent = goal_id if identity == "b" else None
        entry = decision_entry(rule_id=rule_id, robot=robot, decided_at=now, outcome=DecisionOutcome.SENT, goal_id=sent)
        await client.history.documents("decision", DecisionEntry).write(identity, entry)

    def found(query: str = "") -> list[str]:
        return [decision["id"] for decision in client.get("decisions", query=query)["decisions"]]

    assert found() == ["c", "b", "a"]
    assert found("?robot=/robot1&rule=low") == ["a"]
    assert found(f"?goal_id={goal_id.replace('-', '').upper()}") == ["b"]
    pages = [client.get("decisions", query="?limit=2")]
    pages.append(client.get("decisions", query=f"?limit=2&cursor={pages[0]['next_cursor']}"))
    assert [[each["id"] for each in page["decisions"]] for page in pages] == [["c", "b"], ["a"]]
    assert pages[1]["next_cursor"] is None
    assert found("?robot=/gone&rule=low") == []
    assert client.get("decisions", 404, "?robot=/robto1")["code"] == "robot_not_found"
    for query in ("?limit=0", "?robot=ro%20bot", "?goal_id=1", "?goal=1", "?cursor=x"):
        client.get("decisions", 422, query)


@settings(max_examples=30, deadline=None)
@given(STEPS)
def test_of_two_people_who_change_a_rule_none_loses_a_change(steps: list[tuple[Step, int]]) -> None:
    with Client() as client:
        path = "/automation/rules/night"
        number = lambda rule: int(rule["name"])  # noqa: E731
        rule = Resource(client.http, path, lambda each: NIGHT | {"name": str(each)}, number)
        require_that_nothing_is_lost(rule, steps)


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"If-Match": '"other", "another"'}, 412),
        ({"If-Match": "*"}, 200),
        ({"If-None-Match": "*"}, 412),
        ({"If-Match": "unquoted"}, 422),
        ({"If-None-Match": '"a"'}, 422),
    ],
)
def test_conditions_of_a_write(client: Client, headers: dict[str, str], status: int) -> None:
    etag = client.put(NIGHT, 201)["etag"]
    answer = client.http.put("/automation/rules/night", json=NIGHT, headers=headers)
    assert answer.status_code == status
    if status == 422:
        assert (answer.json()["errors"][0]["in"], answer.json()["errors"][0]["path"]) == ("header", next(iter(headers)))
    through_a_proxy = {"If-Match": f'"other", W/{etag}'}
    answer = client.http.put("/automation/rules/night", json=NIGHT, headers=through_a_proxy)
    assert answer.status_code == (412 if status == 200 else 200)
