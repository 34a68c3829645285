"""Two simulated robots at a glance, through one gateway."""

from collections.abc import Iterator
from contextlib import ExitStack
from itertools import pairwise
from typing import Any

import orjson
import pytest

from tests.support.clients import connect
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.installed import needs
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

FIRST, SECOND = "/robot1", "/robot2"
NEAR = {"x": -0.8, "y": 0.0, "theta": 0.0}


@pytest.fixture(scope="module")
def domain() -> Iterator[int]:
    with ros_domain() as domain:
        yield domain


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> str:
    return f"sqlite:///{tmp_path_factory.mktemp('history')}/history.db"


@pytest.fixture(scope="module")
def gateway(domain: int, database: str) -> Iterator[RunningGateway]:
    """A gateway and two robots, the second of which can dock."""
    with running_gateway(domain, namespace=FIRST, database_url=database) as gateway, ExitStack() as stack:
        for name in (FIRST, SECOND):
            stack.enter_context(running_program(domain, "dock_simulator", "-r", f"__ns:={name}"))
        controller = ("-p", "controller:=dock_pose")
        stack.enter_context(running_program(domain, "docking_server", "-r", f"__ns:={SECOND}", *controller))
        wait_until_found(gateway)
        yield gateway


def wait_until_found(gateway: RunningGateway) -> None:
    for name in (FIRST, SECOND):
        wait_until(lambda name=name: known(gateway, name)["simulated"] is True, name)
        wait_until(lambda name=name: known(gateway, name)["battery"]["state"] is not None, f"the battery of {name}")
    wait_until(lambda: known(gateway, SECOND)["dock"] is not None, "the docking action")


def known(gateway: RunningGateway, name: str) -> dict[str, Any]:
    robots = gateway.http.get("/robots").raise_for_status().json()["robots"]
    return next((robot for robot in robots if robot["name"] == name), {"simulated": None, "dock": None})


def of(event: dict[str, Any], name: str) -> dict[str, Any] | None:
    """The robot in an event, if it changed."""
    return next((robot for robot in event.get("robots", []) if robot["name"] == name), None)


def test_every_robot_is_listed(gateway: RunningGateway) -> None:
    first, second = gateway.http.get("/robots").raise_for_status().json()["robots"]
    assert (first["name"], first["default"], second["name"], second["default"]) == (FIRST, True, SECOND, False)
    assert first["docked"] is second["docked"] is False
    assert first["dock"] == {
        "action_name": f"{FIRST}/connect_to_charging_dock",
        "action_type": "action_tutorials_interfaces/action/ConnectToChargingDock",
        "available": False,
        "answering": False,
        "duplicate": False,
    }
    assert second["dock"]["available"] is True
    assert second["battery"]["state"]["power_supply_status"] in (2, 3)
    assert second["battery"]["stale"] is False
    assert second["battery_topic"] == f"{SECOND}/battery_status"
    assert gateway.http.get("/robots", params={"robot": SECOND}).json()["robots"][0]["name"] == SECOND
    for query, status, code in (("robot=/none", 404, "robot_not_found"), ("name=/robot1", 422, "invalid_field")):
        answer = gateway.http.get(f"/robots?{query}")
        assert (answer.status_code, answer.json()["code"]) == (status, code)


LABELED: dict[str, dict[str, Any]] = {
    FIRST: {"display_name": "Left forklift", "groups": ["hall 1", "forklifts"]},
    SECOND: {"display_name": None, "groups": []},
}


def labels(gateway: RunningGateway) -> dict[str, dict[str, Any]]:
    robots = gateway.http.get("/robots").raise_for_status().json()["robots"]
    return {robot["name"]: {field: robot[field] for field in ("display_name", "groups")} for robot in robots}


def test_a_robot_is_labeled(gateway: RunningGateway) -> None:
    label, path = LABELED[FIRST], f"/label?robot={FIRST}"
    with gateway.stream("?include=robots&feedback=false") as stream:
        answer = gateway.http.put(path, json=label).raise_for_status()
        assert answer.json() == {"robot": FIRST, **label, "etag": answer.headers["ETag"]}
        assert labels(gateway) == LABELED
        stream.until(lambda event: (of(event, FIRST) or {}).get("display_name") == "Left forklift")
    taken = gateway.http.put(f"/label?robot={SECOND}", json=label)
    assert (taken.status_code, taken.json()["code"]) == (409, "display_name_taken")
    assert labels(gateway) == LABELED


@needs("simulator")
def test_a_robot_is_followed_onto_its_dock(domain: int, gateway: RunningGateway, database: str) -> None:
    at = {"robot": SECOND}
    gateway.http.post("/simulator/place", params=at, json=NEAR).raise_for_status()
    with gateway.stream("?include=robots&feedback=false") as stream:
        snapshot = stream.next()
        assert [robot["name"] for robot in snapshot["robots"]] == [FIRST, SECOND]
        goal_id = gateway.http.post("/dock", params=at).raise_for_status().json()["goal_id"]

        def runs(event: dict[str, Any]) -> bool:
            robot = of(event, SECOND)
            return bool(robot and [goal["goal_id"] for goal in robot["goals"]] == [goal_id])

        def has_docked(event: dict[str, Any]) -> bool:
            robot = of(event, SECOND)
            return bool(robot and robot["docked"] and not robot["goals"])

        stream.until(runs)
        docked = of(stream.until(has_docked, timeout=90), SECOND)
        assert docked is not None
        assert (docked["last_goal"]["goal_id"], docked["last_goal"]["status"]) == (goal_id, "succeeded")
        assert not {"goal", "feedback", "result"} & docked["last_goal"].keys()
        assert docked["battery"]["state"]["power_supply_status"] == 1
        if "result" not in {
            event["type"] for event in stream.seen
        }:  # it is stored first, and the robot is told of sooner
            stream.until_type("result")
        assert [event["status"] for event in stream.seen if event["type"] == "result"] == ["succeeded"]
        assert not [event for event in stream.seen if event["type"] == "feedback"]
        assert gateway.goal(goal_id)["feedback_count"] > 0
    gateway.http.put(f"/label?robot={FIRST}", json=LABELED[FIRST]).raise_for_status()
    # Another one that starts now knows of it, too: from the history that they share.
    with running_gateway(domain, namespace=FIRST, database_url=database) as next_one:
        wait_until_found(next_one)
        wait_until(lambda: (known(next_one, SECOND)["last_goal"] or {}).get("goal_id") == goal_id, "the last goal")
        assert labels(next_one) == LABELED
        with gateway.stream("?include=robots&feedback=false") as stream:
            first = of(stream.next(), FIRST) or {}
            assert LABELED[FIRST].items() <= first.items()
            label = {"display_name": None, "groups": ["hall 2"]}
            next_one.http.put(f"/label?robot={FIRST}", json=label).raise_for_status()
            assert labels(next_one) == {**LABELED, FIRST: label}
            stream.until(lambda event: (of(event, FIRST) or {}).get("groups") == ["hall 2"])
        assert labels(gateway) == {**LABELED, FIRST: label}


def test_changes_come_at_most_twice_a_second(gateway: RunningGateway) -> None:
    with gateway.stream("?include=robots") as one, gateway.stream("?include=robots&robot=/robot2") as other:
        events = [one.until_type("robots") for _ in range(6)]
        seconds = [float(event["time"][17:].rstrip("Z")) for event in events]
        assert all((later - earlier) % 60 > 0.45 for earlier, later in pairwise(seconds))
        times = [event["time"] for event in events]
        assert other.until(lambda event: event["time"] == times[-1])["robots"] == events[-1]["robots"]


def test_on_the_socket_too(gateway: RunningGateway) -> None:
    with connect(f"{gateway.url.replace('http', 'ws')}/ws") as socket:
        for text in (
            '{"op": "subscribe", "id": "1", "include": ["robots"], "feedback": false}',
            '{"op": "subscribe", "id": "2", "feedback": "some"}',
        ):
            socket.send(text)
        received = [orjson.loads(socket.recv(PATIENCE)) for _ in range(4)]
    answers = {answer["id"]: answer for answer in received if "op" in answer}
    assert (answers["1"]["op"], answers["2"]["error"]["code"]) == ("ack", "invalid_field")
    assert {len(event["robots"]) for event in received if event.get("type") == "snapshot"} == {2}
