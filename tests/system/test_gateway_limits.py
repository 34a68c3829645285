"""Two robots, and people who are to have one of them only: what they see, and what they can do."""

import time
from collections.abc import Iterator
from typing import Any

import orjson
import pytest
from websockets.exceptions import InvalidStatus

from tests.support.access import Site, bearer, stream
from tests.support.clients import connect
from tests.support.domain import ros_domain
from tests.support.gateway import LOW, RunningGateway, running_dock_server
from tests.support.installed import needs
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

ONE, TWO = "/robot1", "/robot2"
MISSING = "7d9c1c9e-0000-4000-8000-00000000000a"


class Robots:
    """A gateway with two robots, and the tokens of those who use it."""

    def __init__(self, gateway: RunningGateway, site: Site) -> None:
        self.gateway = gateway
        self.admin = site.token("root", "admin")
        self.one = site.token("one", "supervisor", "--robot", ONE)
        self.undocker = site.token("undocker", "operator", "--action", "*/disconnect_from_charging_dock")
        self.reporter = site.token("reporter", "viewer", "--topic", "*/battery_status")
        wait_until(lambda: self.ask(self.one, "GET", "/session")["principal"] is not None, "the tokens")

    def answer(self, who: str, method: str, path: str, body: object = None) -> Any:
        return self.gateway.http.request(method, path, headers=bearer(who), **({} if body is None else {"json": body}))

    def ask(self, who: str, method: str, path: str, body: object = None) -> Any:
        answer = self.answer(who, method, path, body)
        assert answer.is_success, answer.text
        return answer.json()

    def refused(self, who: str, method: str, path: str, body: object = None) -> bool:
        answer = self.answer(who, method, path, body)
        return answer.status_code == 403 and answer.json()["code"] == "not_allowed"

    def unknown(self, who: str, method: str, path: str, goal_id: str, body: object = None) -> bool:
        """Whether a goal is answered like one that there is not."""
        there, missing = (self.answer(who, method, path.format(each), body) for each in (goal_id, MISSING))
        alike = there.text.replace(goal_id, MISSING) == missing.text
        headers = [{*answer.headers} for answer in (there, missing)]
        return alike and headers[0] == headers[1] and there.status_code == 404 == missing.status_code

    def names(self, who: str) -> list[str]:
        return [robot["name"] for robot in self.ask(who, "GET", "/robots")["robots"]]

    def dock(self, robot: str) -> str:
        """Dock it. Its server rejects goals until it has heard, over DDS, that an earlier stop was released."""

        def sent() -> str | None:
            answer = self.answer(self.admin, "POST", f"/dock?robot={robot}")
            assert answer.is_success or answer.json()["code"] == "goal_rejected", answer.text
            return str(answer.json()["goal_id"]) if answer.is_success else None

        return wait_until(sent, "a goal that is accepted")


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robots]:
    site = Site(tmp_path_factory.mktemp("site"))
    with (
        ros_domain() as domain,
        site.gateway(domain) as gateway,
        running_dock_server(domain, "-r", f"__ns:={ONE}"),
        running_dock_server(domain, "-r", f"__ns:={TWO}"),
    ):
        robots = Robots(gateway, site)
        wait_until(lambda: robots.names(robots.admin) == ["/", ONE, TWO], "both robots")
        for robot in (ONE, TWO):
            robots.ask(robots.admin, "PUT", f"/battery/publisher?robot={robot}", {"state": LOW, "rate_hz": 5})
            wait_until(lambda robot=robot: server(robots, robot)["answering"], f"the dock server of {robot}")
        yield robots


def server(robots: Robots, robot: str) -> Any:
    (found,) = robots.ask(robots.admin, "GET", f"/robots?robot={robot}")["robots"]
    return found["dock"] or {"answering": False}


@pytest.fixture(scope="module")
def goals(robots: Robots) -> dict[str, str]:
    """A running goal of each robot."""
    return {robot: robots.dock(robot) for robot in (ONE, TWO)}


def test_lists_have_the_own_robot_only(robots: Robots, goals: dict[str, str]) -> None:
    assert robots.names(robots.one) == [ONE]
    listed = robots.ask(robots.one, "GET", "/goals")["goals"]
    assert [goal["goal_id"] for goal in listed] == [goals[ONE]]
    exported = robots.ask(robots.one, "GET", "/goals/export?format=json")
    assert [goal["goal_id"] for goal in exported] == [goals[ONE]]
    actions = robots.ask(robots.one, "GET", "/actions")["actions"]
    assert {action["action_name"].rpartition("/")[0] for action in actions} == {ONE}
    assert robots.ask(robots.one, "GET", f"/goals?robot={TWO}")["goals"] == []
    assert len(robots.ask(robots.admin, "GET", "/goals")["goals"]) == 2


def test_the_graph_has_the_own_robot_only(robots: Robots) -> None:
    graph = robots.answer(robots.one, "GET", "/graph")
    assert f"{ONE}/battery_status" in graph.text
    assert TWO not in graph.text
    assert TWO in robots.answer(robots.admin, "GET", "/graph").text


@needs("automation")
def test_rules_have_the_own_robot_only(robots: Robots) -> None:
    battery = {"below": 0.01, "idle_s": 3600}
    for name, chosen in (("both", {"names": [ONE, TWO]}), ("other", {"names": [TWO]}), ("all", {"all": True})):
        body = {"name": name, "mode": "off", "robots": chosen, "battery": battery}
        robots.ask(robots.admin, "PUT", f"/automation/rules/{name}", body)
        assert robots.refused(robots.one, "PUT", f"/automation/rules/{name}", body)
    rules = robots.ask(robots.one, "GET", "/automation/rules")["rules"]
    assert [rule["name"] for rule in rules] == ["all", "both"]
    assert [[each["robot"] for each in rule["applies_to"]] for rule in rules] == [[ONE], [ONE]]
    assert TWO not in str(rules)
    for name in ("both", "other", "all"):
        assert robots.answer(robots.admin, "DELETE", f"/automation/rules/{name}").status_code == 204


@needs("statistics")
def test_statistics_have_the_own_robot_only(robots: Robots, goals: dict[str, str]) -> None:
    assert set(goals) == {ONE, TWO}
    by_robot = robots.ask(robots.one, "GET", "/statistics?by=robot")["groups"]
    assert TWO not in [group["name"] for group in by_robot]


def test_the_other_robot_is_out_of_reach(robots: Robots, goals: dict[str, str]) -> None:
    other = goals[TWO]
    for method, path in (
        ("POST", "/dock"),
        ("POST", f"/dock?robot={TWO}"),
        ("POST", f"/undock?robot={TWO}"),
        ("POST", f"/actions{TWO}/connect_to_charging_dock/goals"),
        ("GET", f"/actions{TWO}/connect_to_charging_dock/goals/{goals[ONE]}"),
        ("GET", f"/actions{TWO}/no_such_action/goals/{goals[ONE]}"),
        ("GET", f"/robots?robot={TWO}"),
        ("GET", f"/battery?robot={TWO}"),
        ("GET", f"/battery/history?robot={TWO}"),
        ("DELETE", f"/stop?robot={TWO}"),
        ("DELETE", "/stop"),
        ("GET", "/metrics"),
        ("GET", f"/graph/topics{TWO}/battery_status"),
    ):
        assert robots.refused(robots.one, method, path), (method, path)
    assert robots.refused(robots.one, "PUT", f"/battery/publisher?robot={TWO}", {"state": LOW})
    for method, path, body in (
        ("POST", "/dock/{}/cancel", None),
        ("POST", "/goals/{}/cancel", None),
        ("GET", "/dock/{}", None),
        ("GET", "/goals/{}", None),
        ("GET", "/goals/{}/events", None),
        ("GET", "/goals/{}/history", None),
        ("GET", "/goals/{}/export?format=csv", None),
        ("GET", f"/actions{ONE}/connect_to_charging_dock/goals/{{}}", None),
        ("GET", f"/actions{ONE}/connect_to_charging_dock/goals/{{}}/events", None),
        ("POST", f"/actions{ONE}/connect_to_charging_dock/goals/{{}}/cancel", None),
        ("POST", "/goals/{}/notes", {"by": "x", "text": "x"}),
        ("PUT", "/goals/{}/tags", {"tags": ["x"]}),
    ):
        assert robots.unknown(robots.one, method, path, other, body), (method, path)
    assert robots.ask(robots.admin, "GET", f"/goals/{other}")["status"] == "executing"


def test_commands_of_a_socket_have_the_same_limits(robots: Robots, goals: dict[str, str]) -> None:
    with stream(robots.gateway, "/ws", robots.one) as socket:
        for number, command in enumerate(
            (
                {"op": "send_goal"},
                {"op": "send_goal", "robot": TWO},
                {"op": "send_goal", "action": f"{TWO}/connect_to_charging_dock", "goal": {}},
                {"op": "send_goal", "action": f"{ONE}/connect_to_charging_dock", "goal": {}, "robot": TWO},
                {"op": "send_goal", "action": f"{ONE}/connect_to_charging_dock", "goal": {}, "robot": "/no_such_robot"},
                {"op": "publish_battery", "robot": TWO, "state": {}},
                {"op": "stop_publishing", "robot": TWO},
                {"op": "release_stop", "robot": TWO},
                {"op": "release_stop"},
                {"op": "subscribe", "robot": TWO},
                {"op": "subscribe", "robot": "/no_such_robot"},
            )
        ):
            socket.send(orjson.dumps({"id": str(number), **command}).decode())
            answer = orjson.loads(socket.recv())
            assert (answer["op"], answer["id"]) == ("error", str(number)), command
            assert answer["error"]["code"] == "not_allowed", command


def test_commands_about_another_goal_are_answered_like_those_about_none(robots: Robots, goals: dict[str, str]) -> None:
    with stream(robots.gateway, "/ws", robots.one) as socket:
        for op in ("cancel_goal", "subscribe"):
            answers = []
            for goal_id in (goals[TWO], MISSING):
                socket.send(orjson.dumps({"op": op, "id": "1", "goal_id": goal_id}).decode())
                answers.append(str(socket.recv()).replace(goal_id, MISSING))
            assert answers[0] == answers[1]
            assert orjson.loads(answers[0])["error"]["code"] == "goal_not_found"


def test_an_idempotency_key_belongs_to_its_user(robots: Robots, goals: dict[str, str]) -> None:
    """The same key of another user is another key: neither their goal nor that there is one can be seen."""
    action, body = f"{ONE}/connect_to_charging_dock", {"desired_battery_state": {"power_supply_status": 1}}

    full = {"desired_battery_state": {"power_supply_status": 4}}

    def send(who: str, body: object, key: str = "night shift") -> Any:
        headers = bearer(who) | {"Idempotency-Key": key}
        return robots.gateway.http.post(f"/actions{action}/goals", json=body, headers=headers)

    robots.ask(robots.admin, "POST", f"/goals/{goals[ONE]}/cancel")
    wait_until(lambda: robots.ask(robots.admin, "GET", f"/goals/{goals[ONE]}")["status"] == "canceled", "the end")
    goals[ONE] = send(robots.admin, body).raise_for_status().json()["goal_id"]
    assert send(robots.admin, body).json()["goal_id"] == goals[ONE]
    assert send(robots.admin, full).json()["code"] == "idempotency_key_reused"

    own = send(robots.one, body).json()  # the busy server rejects the goal of another user
    assert (own["code"], own["goal_id"] != goals[ONE]) == ("dock_busy", True)
    assert send(robots.one, body).json()["goal_id"] == own["goal_id"]
    send(robots.one, body, "day shift")
    assert send(robots.admin, full, "day shift").json()["code"] == "dock_busy"
    with stream(robots.gateway, "/ws", robots.one) as socket:
        command = {"op": "send_goal", "action": action, "goal": body, "idempotency_key": "night shift"}
        socket.send(orjson.dumps({"id": "1", **command}).decode())
        assert orjson.loads(socket.recv())["error"]["goal_id"] == own["goal_id"]


def test_a_stream_carries_the_own_robot_only(robots: Robots, goals: dict[str, str]) -> None:
    """What the other robot does is seen by an admin, and by then the limited reader would have seen it, too."""
    query = "?include=fleet,battery,system,scenes"
    with (
        stream(robots.gateway, f"/ws/feedback{query}", robots.one) as limited,
        stream(robots.gateway, f"/ws/feedback{query}", robots.admin) as everything,
    ):
        robots.ask(robots.admin, "POST", f"/goals/{goals[TWO]}/cancel")
        goals[TWO] = robots.dock(TWO)
        robots.ask(robots.admin, "POST", f"/goals/{goals[ONE]}/cancel")
        goals[ONE] = robots.dock(ONE)
        assert goals[TWO] in texts_until(everything, goals[ONE])
        seen = texts_until(limited, goals[ONE])
        later = texts_for(limited, 1.5)
    assert ONE in seen
    assert TWO not in seen + later
    snapshot = orjson.loads(seen.splitlines()[0])
    assert [robot["name"] for robot in snapshot["robots"]] == [ONE]
    assert snapshot["docking"]["dock"]["action_name"] == f"{ONE}/connect_to_charging_dock"


def texts_until(socket: Any, text: str) -> str:
    """Read on to a message with this text, and a second more."""
    seen: list[str] = []
    while not seen or text not in seen[-1]:
        seen.append(socket.recv(PATIENCE))
    return "\n".join(seen)


def texts_for(socket: Any, seconds: float) -> str:
    seen, deadline = [], time.monotonic() + seconds
    while (left := deadline - time.monotonic()) > 0:
        try:
            seen.append(socket.recv(timeout=left))
        except TimeoutError:
            break
    return "\n".join(seen)


def test_a_stream_of_the_other_robot_is_refused(robots: Robots, goals: dict[str, str]) -> None:
    for query, status in ((f"?robot={TWO}", 403), ("?robot=/no_such_robot", 403), (f"?goal_id={goals[TWO]}", 404)):
        with pytest.raises(InvalidStatus) as refused, stream(robots.gateway, f"/ws/feedback{query}", robots.one):
            pass
        assert refused.value.response.status_code == status


def test_a_stream_that_resumes_has_the_same_limits(robots: Robots, goals: dict[str, str]) -> None:
    with stream(robots.gateway, "/ws/feedback", robots.one) as socket:
        first = orjson.loads(texts_until(socket, '"type":"feedback"').splitlines()[-1])
    robots.ask(robots.admin, "POST", f"/goals/{goals[TWO]}/cancel")
    goals[TWO] = robots.dock(TWO)
    wait_until(lambda: robots.ask(robots.admin, "GET", f"/goals/{goals[TWO]}")["status"] == "executing", "a goal")
    with stream(robots.gateway, f"/ws/feedback?after={first['id']}", robots.one) as socket:
        seen = texts_for(socket, 1.0)
    assert goals[ONE] in seen
    assert goals[TWO] not in seen


def test_a_ticket_has_the_limits_of_the_one_who_asked_for_it(robots: Robots) -> None:
    def ticket() -> str:
        return str(robots.ask(robots.one, "POST", "/session/ticket")["ticket"])

    url = robots.gateway.url.replace("http", "ws")
    with connect(f"{url}/ws/feedback?include=robots&ticket={ticket()}") as socket:
        assert [robot["name"] for robot in orjson.loads(socket.recv())["robots"]] == [ONE]
    with pytest.raises(InvalidStatus) as refused, connect(f"{url}/ws/feedback?robot={TWO}&ticket={ticket()}"):
        pass
    assert refused.value.response.status_code == 403


def test_everyone_stops_every_robot_and_releases_the_own_one(robots: Robots) -> None:
    robots.ask(robots.one, "POST", f"/stop?robot={TWO}")
    assert robots.ask(robots.admin, "GET", f"/stop?robot={TWO}")["latched"] is True
    assert robots.refused(robots.one, "DELETE", f"/stop?robot={TWO}")
    robots.ask(robots.one, "POST", f"/stop?robot={ONE}")
    assert robots.ask(robots.one, "DELETE", f"/stop?robot={ONE}")["latched"] is False
    assert robots.ask(robots.admin, "GET", f"/stop?robot={TWO}")["latched"] is True
    alerts = robots.ask(robots.one, "GET", "/alerts")["alerts"]
    assert TWO not in [alert["robot"] for alert in alerts]
    latched = wait_until(
        lambda: [
            each["id"]
            for each in robots.ask(robots.admin, "GET", "/alerts")["alerts"]
            if (each["kind"], each["robot"]) == ("stop_latched", TWO)
        ],
        "the alert of the stop",
    )
    answers = [
        robots.answer(robots.one, "PUT", f"/alerts/{each}/acknowledgement", {"by": "x"}).text.replace(each, "x")
        for each in (latched[0], "0123456789abcdef")
    ]
    assert answers[0] == answers[1]
    assert "alert_not_found" in answers[0]
    robots.ask(robots.admin, "DELETE", f"/stop?robot={TWO}")


def test_actions_and_topics_are_limits_of_their_own(robots: Robots) -> None:
    assert robots.refused(robots.undocker, "POST", f"/dock?robot={ONE}")
    goal_id = robots.dock(ONE)
    assert robots.ask(robots.undocker, "GET", "/goals")["goals"] == []
    (own,) = robots.ask(robots.one, "GET", "/robots")["robots"]
    assert [goal["goal_id"] for goal in own["goals"]] == [goal_id]
    assert all(not robot["goals"] for robot in robots.ask(robots.undocker, "GET", "/robots")["robots"])
    with stream(robots.gateway, f"/ws/feedback?robot={ONE}&include=robots", robots.undocker) as socket:
        assert goal_id not in socket.recv(PATIENCE)
    for topic in ("feedback", "status"):
        path = f"/ws/topics?topic={ONE}/connect_to_charging_dock/_action/{topic}"
        with pytest.raises(InvalidStatus) as hidden, stream(robots.gateway, path, robots.undocker):
            pass
        assert hidden.value.response.status_code == 403
    robots.ask(robots.admin, "POST", f"/goals/{goal_id}/cancel")
    answer = robots.answer(robots.undocker, "POST", f"/undock?robot={ONE}")
    assert answer.json()["code"] != "not_allowed"  # there is no undocking server, but it was let through
    with stream(robots.gateway, "/ws", robots.undocker) as socket:
        for verb, code in (("dock", "not_allowed"), ("undock", answer.json()["code"])):
            socket.send(orjson.dumps({"op": "send_goal", "id": verb, "verb": verb, "robot": ONE}).decode())
            assert orjson.loads(socket.recv())["error"]["code"] == code
    with stream(robots.gateway, f"/ws/topics?topic={TWO}/battery_status", robots.reporter) as socket:
        assert "battery_status" in socket.recv(PATIENCE)
    with (
        pytest.raises(InvalidStatus) as refused,
        stream(robots.gateway, f"/ws/topics?topic={TWO}/cmd_vel", robots.reporter),
    ):
        pass
    assert refused.value.response.status_code == 403
