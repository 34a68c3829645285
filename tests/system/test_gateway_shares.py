"""Two gateways with a share each of the robots of one domain, on one PostgreSQL."""

import signal
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest

from tests.support.domain import ros_domain
from tests.support.gateway import LOW, RunningGateway, running_dock_server, running_gateway
from tests.support.postgresql import binaries, running_postgresql
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

pytestmark = [pytest.mark.ros, pytest.mark.skipif(binaries() is None, reason="no PostgreSQL is installed")]

A, B = "/fleet_a/robot1", "/fleet_b/robot1"


@pytest.fixture(scope="module")
def database() -> Iterator[str]:
    with running_postgresql() as server:
        yield server.url


def names(gateway: RunningGateway) -> list[str]:
    return [robot["name"] for robot in gateway.http.get("/robots").json()["robots"]]


def running(gateway: RunningGateway) -> list[dict[str, Any]]:
    answer: dict[str, Any] = gateway.http.get("/gateways").raise_for_status().json()
    assert (answer["shared"], answer["conflict"]) == (True, None)
    gateways: list[dict[str, Any]] = answer["gateways"]
    return gateways


def knows(gateway: RunningGateway, other: dict[str, Any]) -> bool:
    return any(other == {key: each[key] for key in other} for each in running(gateway))


@pytest.fixture(scope="module")
def shares(database: str) -> Iterator[tuple[int, RunningGateway, RunningGateway]]:
    def settings(robots: str) -> dict[str, str]:
        return {"database_url": database, "serve_robots": robots, "allow_publish": "/fleet_*"}

    with (
        ros_domain() as domain,
        running_dock_server(domain, "-r", "__ns:=/fleet_a/robot1"),
        running_dock_server(domain, "-r", "__ns:=/fleet_b/robot1"),
        running_gateway(domain, **settings("/fleet_a/*")) as first,
        running_gateway(domain, **settings("/fleet_b/*")) as second,
    ):
        first.wait_until_ready()
        second.wait_until_ready()
        for gateway, other, robot in ((first, second, B), (second, first, A)):
            known = {"address": other.url, "serves": [robot], "this": False}
            wait_until(lambda known=known, gateway=gateway: knows(gateway, known), "the gateways know each other")
        yield domain, first, second


def elsewhere(answer: httpx2.Response) -> str:
    """The address of the gateway that an answer sends its client to."""
    problem = answer.json()
    assert (answer.status_code, problem["code"]) == (421, "served_elsewhere"), problem
    address: str = problem["gateway"]["address"]
    assert address in problem["detail"]
    return address


def test_each_serves_its_share_and_says_who_serves_the_rest(
    shares: tuple[int, RunningGateway, RunningGateway],
) -> None:
    _, first, second = shares
    assert (names(first), names(second)) == ([A], [B])
    for gateway, other, robot in ((first, second, B), (second, first, A)):
        query = {"robot": robot}
        assert elsewhere(gateway.http.post("/dock", params=query)) == other.url
        assert elsewhere(gateway.http.post("/stop", params=query)) == other.url
        assert elsewhere(gateway.http.post("/battery", params=query, json=LOW)) == other.url
        assert elsewhere(gateway.http.get("/robots", params=query)) == other.url
        assert elsewhere(gateway.http.post(f"/actions{robot}/connect_to_charging_dock/goals")) == other.url
        twist = {"message": {}, "type": "geometry_msgs/msg/Twist"}
        assert elsewhere(gateway.http.post(f"/topics{robot}/cmd_vel", json=twist)) == other.url


def test_goals_in_the_common_database_are_those_of_the_share(
    shares: tuple[int, RunningGateway, RunningGateway],
) -> None:
    _, first, second = shares
    second.http.put("/battery/publisher", params={"robot": B}, json={"state": LOW, "rate_hz": 5}).raise_for_status()
    goal_id = second.http.post("/dock", params={"robot": B}).raise_for_status().json()["goal_id"]
    second.wait_for_goal(goal_id, "executing")
    assert [goal["goal_id"] for goal in second.http.get("/goals").json()["goals"]] == [goal_id]
    assert first.http.get("/goals").json()["goals"] == []
    assert elsewhere(first.http.get(f"/goals/{goal_id}")) == second.url
    assert elsewhere(first.http.post(f"/goals/{goal_id}/cancel")) == second.url
    assert second.http.post(f"/goals/{goal_id}/cancel").status_code == 202
    second.wait_for_goal(goal_id, "canceled")


def test_a_stop_for_all_stops_the_robots_of_both_until_each_releases_its_own(
    shares: tuple[int, RunningGateway, RunningGateway],
) -> None:
    _, first, second = shares
    report = first.http.post("/stop").raise_for_status().json()
    assert report["stop"]["latched"]
    assert [gateway["address"] for gateway in report["others"]] == [second.url]

    def latched(gateway: RunningGateway, robot: str) -> bool:
        return bool(gateway.http.get("/stop", params={"robot": robot}).raise_for_status().json()["latched"])

    wait_until(lambda: latched(second, B), "the other has stopped its robots")
    assert second.http.post("/dock", params={"robot": B}).json()["code"] == "stop_latched"
    assert first.http.delete("/stop").raise_for_status().json()["latched"] is False
    assert (latched(first, A), latched(second, B)) == (False, True)
    wait_until(
        lambda: second.http.delete("/stop", params={"robot": B}).status_code == 200, "the stop for all is released"
    )
    assert not latched(second, B)


def test_robots_of_another_gateway_are_not_claimed_until_it_has_ended(
    shares: tuple[int, RunningGateway, RunningGateway], database: str
) -> None:
    domain, first, second = shares
    variables = {"DOCK_GATEWAY_PORT": "0", "DOCK_GATEWAY_DATABASE_URL": database}
    environment = ros_environment(domain, **variables, DOCK_GATEWAY_SERVE_ROBOTS="/fleet_c/*,/fleet_b/robot*")
    with ForkedProcess("dock-gateway", "serve", env=environment) as process:
        line = process.wait_for("Error: ")
        assert process.wait() == 1
    assert "no two gateways may serve the same robots" in line
    second.process.send_signal(signal.SIGTERM)
    second.process.wait()
    wait_until(lambda: len(running(first)) == 1, "the other's claim is gone")
