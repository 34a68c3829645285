"""Simulated robots dock through one gateway at the same time, each from a random start."""

import math
import random
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

import pytest

from tests.support.docking import FAST, UNMEASURED
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = [needs("simulator"), pytest.mark.ros]

CHARGING, NOT_CHARGING = 1, (2, 3)
# `make bench-docking` tries hundreds of starts and each controller, without a gateway.
ROBOTS = ("/robot1", "/robot2")


@pytest.fixture
def gateway(domain: int) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        for robot in ROBOTS:
            namespace = ("-r", f"__ns:={robot}")
            stack.enter_context(running_program(domain, "dock_simulator", *namespace, "-p", FAST))
            server = (*namespace, "-p", "controller:=dock_pose", "-p", UNMEASURED)
            stack.enter_context(running_program(domain, "docking_server", *server))
        gateway = stack.enter_context(running_gateway(domain, namespace=ROBOTS[0]))
        gateway.wait_until_ready()
        for robot in ROBOTS:
            at = {"robot": robot}
            wait_until(lambda at=at: gateway.http.get("/simulator", params=at).status_code == 200, robot)
            wait_until(lambda at=at: gateway.http.get("/docks", params=at).status_code == 200, robot)
        yield gateway


def dock_from_a_random_start(gateway: RunningGateway, robot: str) -> tuple[object, ...]:
    """How it ended: the goal, whether the robot is docked, and its battery."""
    chance = random.Random(robot)
    at = {"robot": robot}
    distance = chance.uniform(0.6, 2.5)
    bearing, turn = (math.radians(chance.uniform(-60.0, 60.0)) for _ in range(2))
    pose = {"x": -distance * math.cos(bearing), "y": -distance * math.sin(bearing), "theta": bearing + turn}
    with gateway.stream(f"?include=battery&robot={robot}") as stream:
        gateway.http.post("/simulator/place", params=at, json=pose).raise_for_status()
        for _ in range(3):  # the battery knows it
            stream.until(
                lambda e: e["type"] == "battery" and e["battery"]["state"]["power_supply_status"] in NOT_CHARGING
            )
    answer = gateway.http.post("/dock", params=at, headers={"Prefer": "wait=240"}, timeout=250)
    goal = answer.raise_for_status().json()
    state = (goal["result"] or {}).get("final_battery_state", {}).get("power_supply_status")
    docked = gateway.http.get("/simulator", params=at).json()["docked"]
    return goal["status"], goal["error"], docked, state


def test_every_robot_docks(gateway: RunningGateway) -> None:
    with ThreadPoolExecutor(len(ROBOTS)) as threads:
        ends = list(threads.map(lambda robot: dock_from_a_random_start(gateway, robot), ROBOTS))
    assert ends == [("succeeded", None, True, CHARGING)] * len(ROBOTS)
