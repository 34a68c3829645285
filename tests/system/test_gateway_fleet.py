"""A fleet of simulated robots, in real time, docks through one gateway, each from a random start."""

import math
import random
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass

import pytest

from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.waiting import wait_until

pytestmark = [pytest.mark.ros, pytest.mark.timeout(400)]

CHARGING, NOT_CHARGING = 1, (2, 3)


@dataclass(frozen=True)
class Robot:
    """A robot, and where it starts from: so far away and so far off the dock's axis, turned so far off the dock."""

    name: str
    controller: str
    nearest: float
    farthest: float
    angle: float


# The robots of one controller share their region. `make bench-docking` tries hundreds of starts, without a gateway.
ROBOTS = [Robot(f"/robot{number}", "dock_pose", 0.6, 2.5, 60.0) for number in range(1, 4)]
ROBOTS.append(Robot("/robot4", "infrared", 0.6, 1.0, 30.0))
# A busy machine sees late that a robot has turned out of the beacon's light, so that it turns slowly.
SLOWLY = ("-p", "v_angular_max:=0.4")


@pytest.fixture
def gateway() -> Iterator[RunningGateway]:
    with ros_domain() as domain, ExitStack() as stack:
        for robot in ROBOTS:
            namespace = ("-r", f"__ns:={robot.name}")
            stack.enter_context(running_program(domain, "dock_simulator", *namespace))
            controller = ("-p", f"controller:={robot.controller}", *(SLOWLY if robot.controller == "infrared" else ()))
            stack.enter_context(running_program(domain, "docking_server", *namespace, *controller))
        gateway = stack.enter_context(running_gateway(domain, namespace=ROBOTS[0].name))
        gateway.wait_until_ready()
        for robot in ROBOTS:
            at = {"robot": robot.name}
            wait_until(lambda at=at: gateway.http.get("/simulator", params=at).status_code == 200, robot.name)
            wait_until(lambda at=at: gateway.http.get("/dock", params=at).status_code == 200, robot.name)
        yield gateway


def dock_from_a_random_start(gateway: RunningGateway, robot: Robot) -> list[object]:
    """What did not end well."""
    chance = random.Random(robot.name)
    at = {"robot": robot.name}
    distance = chance.uniform(robot.nearest, robot.farthest)
    bearing = math.radians(chance.uniform(-robot.angle, robot.angle))
    theta = bearing + math.radians(chance.uniform(-robot.angle, robot.angle))
    pose = {"x": -distance * math.cos(bearing), "y": -distance * math.sin(bearing), "theta": theta}
    with gateway.stream(f"?include=battery&robot={robot.name}") as stream:
        gateway.http.post("/simulator/place", params=at, json=pose).raise_for_status()
        for _ in range(3):  # the battery knows it
            stream.until(lambda e: e["type"] == "battery" and e["battery"]["power_supply_status"] in NOT_CHARGING)
    answer = gateway.http.post("/dock", params=at, headers={"Prefer": "wait=240"}, timeout=250)
    goal = answer.raise_for_status().json()
    state = (goal["result"] or {}).get("final_battery_state", {}).get("power_supply_status")
    docked = gateway.http.get("/simulator", params=at).json()["docked"]
    if (goal["status"], docked, state) == ("succeeded", True, CHARGING):
        return []
    return [(robot.name, pose, goal["status"], goal["stage"], goal["retries"], goal["error"])]


def test_every_robot_docks(gateway: RunningGateway) -> None:
    with ThreadPoolExecutor(len(ROBOTS)) as threads:
        ends = list(threads.map(lambda robot: dock_from_a_random_start(gateway, robot), ROBOTS))
    assert [failure for failures in ends for failure in failures] == []
