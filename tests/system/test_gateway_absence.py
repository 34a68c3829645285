"""A robot that has left the graph is forgotten by all gateways, and back with its past when it returns."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.support.gateway import (
    CHARGING,
    RunningGateway,
    running_dock_server,
    running_gateway,
    running_program,
    running_servers,
)
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

NAME = "/robot2"
AT = {"robot": NAME}
NAMESPACE = ("-r", f"__ns:={NAME}")


@contextmanager
def battery(domain: int) -> Iterator[None]:
    command = ("-m", "tests.support.battery", "2", "--ros-args", *NAMESPACE)
    with ForkedProcess(*command, env=ros_environment(domain)):
        yield


def names(gateway: RunningGateway) -> list[str]:
    return [robot["name"] for robot in gateway.http.get("/robots").raise_for_status().json()["robots"]]


def test_a_robot_leaves_and_comes_back(domain: int) -> None:
    with (
        running_gateway(domain, namespace="/robot1", forget_robot_after="2") as one,
        running_gateway(domain, namespace="/robot1", forget_robot_after="3", node_name="other") as other,
    ):
        with running_dock_server(domain, *NAMESPACE):
            for gateway in (one, other):
                wait_until(lambda gateway=gateway: NAME in names(gateway), "the robot")
            wait_until(lambda: one.http.get("/docks", params=AT).is_success, "its docking action")
            one.http.put("/battery/publisher", params=AT, json={"state": CHARGING, "rate_hz": 5}).raise_for_status()
            docked = one.http.post("/dock", params=AT, headers={"Prefer": "wait=50"}).raise_for_status().json()
            assert docked["status"] == "succeeded"
            one.http.post("/stop", params=AT).raise_for_status()
        with one.stream("?include=robots") as stream:
            assert NAME in [robot["name"] for robot in stream.next()["robots"]]
            one.http.delete("/battery/publisher", params=AT)
            with pytest.raises(AssertionError, match="no such event"):
                stream.until(lambda event: bool(event.get("gone")), timeout=6)
            one.http.delete("/stop", params=AT).raise_for_status()
            assert stream.until(lambda event: bool(event.get("gone")))["gone"] == [NAME]
        assert names(one) == ["/robot1"]
        assert one.http.get("/battery", params=AT).json()["code"] == "robot_not_found"
        wait_until(lambda: NAME not in names(other), "the other gateway forgets it, too")
        with one.stream("?include=robots") as stream:
            stream.next()
            with pytest.raises(AssertionError, match="no such event"):
                stream.until(lambda event: event["type"] == "robots" and NAME in str(event), timeout=3)
            with battery(domain):
                event = stream.until(lambda event: event["type"] == "robots" and NAME in str(event))
                (robot,) = [robot for robot in event["robots"] if robot["name"] == NAME]
                assert robot["last_goal"]["goal_id"] == docked["goal_id"]
                wait_until(lambda: NAME in names(other), "it is back everywhere")


def test_an_action_server_in_the_root_leaves_no_robot_behind(domain: int) -> None:
    """Though the graph is full of nodes and topics in the root."""
    simulated = running_program(domain, "dock_simulator", "-r", "__ns:=/robot1")
    with running_gateway(domain, namespace="/robot1", forget_robot_after="2") as gateway, simulated:
        with running_servers(domain, "--offer", "nav2"):
            wait_until(lambda: names(gateway) == ["/", "/robot1"], "the robot")
        wait_until(lambda: names(gateway) == ["/robot1"], "it goes with its server")
