"""The Python client at a hub with two real gateways: what a user does with a gateway works, and means the same."""

import signal
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import pytest

from dock_gateway.client import Client, GatewayRefused
from dock_gateway.core.goal import GoalStatus
from tests.support.domain import ros_domain
from tests.support.gateway import CHARGING, LOW, RunningGateway, running_dock_server, running_gateway
from tests.support.hubs import RunningHub, running_hub, site_settings
from tests.support.nats import nats_server
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


@dataclass
class World:
    """A hub with the sites berlin, which has a docking server, and oslo; clients of all sites and of berlin."""

    hub: RunningHub
    berlin: RunningGateway
    oslo: RunningGateway
    client: Client
    at_berlin: Client


@pytest.fixture(scope="module")
def world(shared_domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    folder: Path = tmp_path_factory.mktemp("hub")
    with ExitStack() as stack:
        nats = stack.enter_context(nats_server(folder))
        stack.enter_context(running_dock_server(shared_domain))
        berlin, oslo = (
            stack.enter_context(running_gateway(domain, hub_role="supervisor", **site_settings(nats.url, folder, name)))
            for name, domain in (("berlin", shared_domain), ("oslo", stack.enter_context(ros_domain())))
        )
        hub = stack.enter_context(running_hub(nats.url, folder))
        berlin.wait_until_ready()
        for name in ("berlin", "oslo"):
            hub.wait_for_site(name)
        client = stack.enter_context(Client(hub.url))
        wait_until(lambda: {robot.name for robot in client.robots()} == {"/berlin", "/oslo"}, "the robots")
        yield World(hub, berlin, oslo, client, stack.enter_context(Client(f"{hub.url}/sites/berlin")))


def test_the_robots_with_their_batteries(world: World) -> None:
    world.berlin.publish(LOW)
    wait_until(lambda: world.at_berlin.battery().state is not None, "the battery")
    battery = world.at_berlin.battery()
    assert battery.percentage == LOW["percentage"]
    (robot,) = (each for each in world.client.robots() if each.name == "/berlin")
    assert robot.dock is not None
    assert (robot.dock["action_name"], robot.dock["available"]) == ("/berlin/connect_to_charging_dock", True)

    def is_shown() -> bool:
        return {each.name: each.battery["percentage"] for each in world.client.robots()}["/berlin"] == LOW["percentage"]

    wait_until(is_shown, "the battery at the hub")
    for robot_name, ready in (("/berlin", True), ("/oslo", False)):
        answer = world.hub.http.get("/readyz", params={"robot": robot_name})
        assert (answer.is_success, answer.json()["ready"]) == (ready, ready)
        assert answer.json()["action_server"]["available"] is ready


def test_a_goal_is_watched_and_canceled(world: World) -> None:
    world.berlin.publish(LOW)
    goal = world.at_berlin.dock({"desired_battery_state": CHARGING})
    types = []
    for event in goal.events():
        types.append(event.type)
        if event.type == "feedback":
            break
    assert types[0] == "snapshot"
    world.hub.wait_for_goal(goal.id, "executing")
    at_hub = world.client.goal(goal.id)
    goal.cancel()
    assert goal.wait(60).status is GoalStatus.CANCELED
    assert at_hub.wait(60).status is GoalStatus.CANCELED
    assert (at_hub.state.action_name, goal.state.action_name) == (
        "/berlin/connect_to_charging_dock",
        "/connect_to_charging_dock",
    )
    with pytest.raises(GatewayRefused, match="not_found"):
        world.client.dock()


def test_a_stop_and_its_release(world: World) -> None:
    world.berlin.publish(LOW)
    goal = world.at_berlin.dock({"desired_battery_state": CHARGING})
    world.berlin.wait_for_goal(goal.id, "executing")
    report = world.client.stop(by="Ada")
    assert (report.stopped, report.not_stopped) == (["/berlin", "/oslo"], [])
    assert (report.canceling, report.failed, report.unconfirmed) == ([goal.id], [], [])
    if report.warning is not None:  # the disk of this machine is slow
        assert report.warning["code"] == "stop_not_persisted"
    assert (report.stop["latched"], report.stop["robots"]) == (True, ["/berlin", "/oslo"])
    assert world.client.request("GET", "/stop") | {"persisted": True} == report.stop | {"persisted": True}
    assert goal.wait(60).status is GoalStatus.CANCELED
    with pytest.raises(GatewayRefused, match="stop_latched"):
        world.at_berlin.dock()
    world.client.release("/oslo")
    assert world.client.request("GET", "/stop")["robots"] == ["/berlin"]
    world.client.release()
    assert world.client.request("GET", "/stop")["robots"] == []
    one = world.client.stop("/berlin")
    assert (one.stopped, one.not_stopped) == (["/berlin"], ["/oslo"])
    world.client.release()


def test_a_site_that_does_not_answer_is_not_said_to_be_stopped(world: World) -> None:
    world.oslo.process.send_signal(signal.SIGKILL)
    world.oslo.process.wait()
    with pytest.raises(GatewayRefused, match="stop_incomplete") as refused:
        world.client.stop(by="Ada")
    problem = refused.value.problem
    assert (problem["stopped"], problem["not_stopped"]) == (["/berlin"], ["/oslo"])
    assert [failure["robot"] for failure in problem["failed"]] == ["/oslo"]
    assert "oslo" in problem["detail"]
    assert (problem["stop"]["for_all"], problem["stop"]["robots"]) == (False, ["/berlin"])
    assert world.berlin.http.get("/stop").json()["latched"]
    assert world.client.request("GET", "/stop")["robots"] == ["/berlin"]
    world.client.release("/berlin")
    assert not world.berlin.http.get("/stop").json()["latched"]
    with pytest.raises(GatewayRefused, match=r"site_(unreachable|timeout)"):
        world.client.release("/oslo")
