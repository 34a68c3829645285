"""The tutorial's scenario over HTTP and WebSocket alone, and what users do with goals: real gateway, server and DDS."""

from collections.abc import Iterator

import pytest

from tests.support.gateway import CHARGING, LOW, RunningGateway, ready_gateway
from tests.support.processes import ForkedProcess, client_process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with ready_gateway(shared_domain, heartbeat_interval="1") as gateway:
        yield gateway


@pytest.fixture(autouse=True)
def no_goal_left(gateway: RunningGateway) -> Iterator[None]:
    yield
    gateway.stop_once()
    for goal in gateway.http.get("/dock").json()["goals"]:
        gateway.wait_for_goal(goal["goal_id"], "succeeded", "canceled", "aborted", "rejected", "lost")
    gateway.http.delete("/battery/publisher")


def charging_states(events: list[dict]) -> list[int]:
    return [
        event["feedback"]["current_battery_state"]["power_supply_status"]
        for event in events
        if event["type"] == "feedback"
    ]


def test_the_tutorial_over_http(gateway: RunningGateway) -> None:
    gateway.publish(LOW, rate_hz=1.0)
    with gateway.stream("?include=battery,cmd_vel,system") as stream:
        assert stream.next()["type"] == "snapshot"
        stream.until(lambda e: e["type"] == "battery" and e["battery"]["state"]["power_supply_status"] == 3)
        response = gateway.http.post("/dock", json={"desired_battery_state": CHARGING})
        assert response.status_code == 202
        goal = response.json()
        assert response.headers["location"] == f"/goals/{goal['goal_id']}"
        assert goal["status"] in ("accepted", "executing")
        assert goal["verb"] == stream.until_type("status")["verb"] == "dock"
        assert goal["goal"]["desired_battery_state"]["voltage"] == 2.16

        turning = stream.until(lambda e: e["type"] == "cmd_vel" and e["cmd_vel"]["angular"]["z"] != 0)["cmd_vel"]
        assert turning == {"linear": {"x": 0.0, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.15}}
        feedback = stream.until_type("feedback")
        assert feedback["goal_id"] == goal["goal_id"]
        state = feedback["feedback"]["current_battery_state"]
        assert (state["percentage"], state["voltage"], state["power_supply_status"]) == (0.24, 2.16, 3)
        assert state["current"] is None

        gateway.publish(CHARGING, rate_hz=1.0)
        result = stream.until_type("result")
        assert result["status"] == "succeeded"
        assert result["result"]["final_battery_state"]["power_supply_status"] == 1
        stream.until_zero()
        stream.until_type("heartbeat")

    goal = gateway.goal(goal["goal_id"])
    assert goal["status"] == "succeeded"
    assert goal["finished_at"] is not None
    assert goal["result"]["final_battery_state"]["power_supply_status"] == 1
    assert charging_states(stream.seen)[0] == 3
    ids = [event["id"] for event in stream.seen if event["type"] in ("status", "feedback", "result")]
    assert len(set(ids)) == len(ids)


def test_an_empty_body_asks_for_charging_and_prefer_waits_for_the_end(gateway: RunningGateway) -> None:
    gateway.publish(CHARGING)
    response = gateway.http.post("/dock", headers={"Prefer": "wait=50"})
    assert response.status_code == 200
    assert response.json()["status"] == "succeeded"
    assert response.json()["goal"]["desired_battery_state"]["power_supply_status"] == 1


def test_prefer_gives_up_waiting_and_leaves_the_goal_alone(gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    response = gateway.http.post("/dock", headers={"Prefer": "wait=1"})
    assert response.status_code == 202
    assert response.json()["status"] == "executing"


def test_cancel(gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    goal_id = gateway.http.post("/dock").json()["goal_id"]
    with gateway.stream(f"?goal_id={goal_id}") as stream:
        stream.until_type("feedback")
        response = gateway.http.post(f"/dock/{goal_id}/cancel")
        assert response.status_code == 202
        assert response.json()["status"] in ("canceling", "canceled")
        result = stream.until_type("result")
    assert result["status"] == "canceled"
    assert result["result"]["final_battery_state"]["power_supply_status"] == 3
    again = gateway.http.post(f"/dock/{goal_id}/cancel")
    assert (again.status_code, again.json()["code"]) == (409, "goal_terminal")


def test_a_second_goal_is_refused_with_a_reason(gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    first = gateway.http.post("/dock").json()["goal_id"]
    response = gateway.http.post("/dock")
    assert response.status_code == 409
    assert response.headers["content-type"] == "application/problem+json"
    problem = response.json()
    assert problem["code"] == "dock_busy"
    assert first in problem["detail"]
    assert gateway.goal(problem["goal_id"])["status"] == "rejected"
    assert gateway.goal(first)["status"] == "executing"


def test_a_rejected_goal_says_why(gateway: RunningGateway) -> None:
    response = gateway.http.post("/dock", json={"desired_battery_state": {"power_supply_status": 2}})
    assert (response.status_code, response.json()["code"]) == (409, "goal_rejected")
    assert "power_supply_status" in response.json()["detail"]


def test_stop_cancels_and_publishes_zero(gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    goal_id = gateway.http.post("/dock").json()["goal_id"]
    with gateway.stream("?include=cmd_vel") as stream:
        stream.until(lambda e: e["type"] == "cmd_vel" and e["cmd_vel"]["angular"]["z"] != 0)
        report = gateway.stop_once()
        assert (report["canceling"], report["failed"], report["unconfirmed"]) == ([goal_id], [], [])
        stream.until_type("result")
        stream.until_zero()
    assert gateway.goal(goal_id)["status"] == "canceled"


def test_a_retry_with_an_idempotency_key_gets_the_first_goal(gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    headers = {"Idempotency-Key": "the-same"}
    first = gateway.http.post("/dock", headers=headers)
    again = gateway.http.post("/dock", headers=headers)
    assert again.status_code == 202
    assert again.json()["goal_id"] == first.json()["goal_id"]
    other = gateway.http.post("/dock", json={"desired_battery_state": {"power_supply_status": 4}}, headers=headers)
    assert (other.status_code, other.json()["code"]) == (409, "idempotency_key_reused")
    gateway.publish(CHARGING)
    gateway.wait_for_goal(first.json()["goal_id"], "succeeded")
    ended = gateway.http.post("/dock", headers=headers)
    assert (ended.status_code, ended.json()["goal_id"]) == (200, first.json()["goal_id"])


def test_pages_of_goals(gateway: RunningGateway) -> None:
    gateway.publish(CHARGING)
    sent = [gateway.http.post("/dock", headers={"Prefer": "wait=50"}).json()["goal_id"] for _ in range(3)]
    page = gateway.http.get("/dock", params={"limit": 2, "status": "succeeded"}).json()
    assert [goal["goal_id"] for goal in page["goals"]] == sent[:0:-1]
    rest = gateway.http.get("/dock", params={"limit": 500, "cursor": page["next_cursor"]}).json()
    assert rest["goals"][0]["goal_id"] == sent[0]
    assert rest["next_cursor"] is None


def test_the_tutorials_client_beside_the_gateway(gateway: RunningGateway, shared_domain: int) -> None:
    gateway.publish(LOW)
    with (
        gateway.stream() as stream,
        client_process(shared_domain, "connect_to_charging_dock_client") as client,
    ):
        client.wait_for("Goal accepted")
        event = stream.until(lambda e: e["type"] == "feedback")
        goal = gateway.goal(event["goal_id"])
        assert goal["origin"] == "external"
        assert goal["goal"] is None
        gateway.publish(CHARGING)
        result = stream.until_type("result")
        assert result["goal_id"] == goal["goal_id"]
        assert result["result"]["final_battery_state"]["power_supply_status"] == 1
        assert client.wait() == 0


def test_a_goal_of_someone_else_can_be_canceled(gateway: RunningGateway, shared_domain: int) -> None:
    gateway.publish(LOW)
    with (
        gateway.stream() as stream,
        client_process(shared_domain, "connect_to_charging_dock_client") as client,
    ):
        goal_id = stream.until(lambda e: e["type"] == "feedback")["goal_id"]
        assert gateway.http.post(f"/dock/{goal_id}/cancel").status_code == 202
        assert stream.until_type("result")["status"] == "canceled"
        assert client.wait() != 0


def test_battery_states_are_published_once_and_repeatedly(gateway: RunningGateway) -> None:
    with gateway.stream("?include=battery,system") as stream:
        stream.next()
        published = gateway.http.post("/battery", json={"percentage": 0.5}).json()["state"]
        assert published["percentage"] == 0.5
        assert published["voltage"] is None
        heard = stream.until_type("battery")["battery"]
        assert (heard["state"], heard["percentage"], heard["stale"]) == (published, 0.5, False)
        answer = gateway.http.get("/battery").json()
        assert answer == heard | {"age_s": answer["age_s"], "other_topics": []}
        assert gateway.http.get("/robots?robot=/").json()["robots"][0]["battery"] == heard
        with gateway.stream("?include=battery") as other:
            assert other.next()["battery"] == heard

        answer = gateway.http.put("/battery/publisher", json={"state": LOW, "rate_hz": 20}).json()
        assert (answer["active"], answer["rate_hz"]) == (True, 20.0)
        for _ in range(5):
            assert stream.until_type("battery")["battery"]["state"]["power_supply_status"] == 3
        wait_until(lambda: gateway.http.get("/battery/publisher").json()["published_count"] >= 5, "five messages")
        assert gateway.http.delete("/battery/publisher").status_code == 204
        assert gateway.http.delete("/battery/publisher").status_code == 204
        assert gateway.http.get("/battery/publisher").json()["active"] is False


def test_the_command_line(gateway: RunningGateway, shared_domain: int) -> None:
    def run(*arguments: str) -> ForkedProcess:
        return ForkedProcess("dock-gateway", *arguments, "--url", gateway.url, env=ros_environment(shared_domain))

    with run("battery", "publish", "--status", "not-charging", "--percentage", "0.24", "--rate", "5") as command:
        assert command.wait() == 0
    with run("dock") as dock:
        dock.wait_for("NOT CHARGING, 24%")
        with run("cancel") as cancel:
            assert cancel.wait() == 0
        dock.wait_for("canceled")
        assert dock.wait() == 1
    with run("battery", "publish", "--status", "charging", "--rate", "5") as command:
        assert command.wait() == 0
    with run("dock") as dock:
        dock.wait_for("succeeded")
        assert dock.wait() == 0
    for arguments, shown in (
        (["battery"], "CHARGING"),
        (["robots"], "docked"),
        (["robots", "--json"], '"name":"/"'),
        (["goals", "--status", "canceled", "--since", "1h"], "/connect_to_charging_dock"),
        (["docks"], "knows no docks by name"),
        (["alerts"], ""),
        (["api", "/goals", "-f", "limit=1"], '"succeeded"'),
        (["--json", "goals", "--limit", "1"], '"succeeded"'),
    ):
        with run(*arguments) as command:
            command.wait_for(shown)
            assert command.wait() == 0
    with run("battery", "unpublish") as command:
        command.wait_for("publishing has stopped")
        assert command.wait() == 0
    gateway.publish(CHARGING)
    with run("stop", "--by", "Ada") as command:
        command.wait_for("zero velocity")
        command.wait_for("goals are refused until the stop is released")
        assert command.wait() == 0
    with run("dock") as command:
        command.wait_for("stop_latched: / was stopped by Ada")
        assert command.wait() == 1
    with run("release") as command:
        command.wait_for("released")
        assert command.wait() == 0
    with run("dock") as dock:
        dock.wait_for("succeeded")
        assert dock.wait() == 0
