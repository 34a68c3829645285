"""Two robots whose docking servers know the same dock, with real gateways: one has it, and the other one waits."""

import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from nav2_msgs.action import NavigateToPose
from rclpy.node import Node

from docking.ros.process import Spinner
from tests.support.docking_servers import Server
from tests.support.domain import ros_domain
from tests.support.gateway import CHARGING, LOW, RunningGateway, running_gateway, running_program
from tests.support.installed import needs
from tests.support.observer import ros_nodes
from tests.support.postgresql import binaries, running_postgresql
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

ROBOTS = ("/robot1", "/robot2")
LAB = {"dock_id": "lab"}


@pytest.fixture
def servers(domain: int, tmp_path: Path) -> Iterator[None]:
    """The docking and undocking servers of two robots, which know the docks `lab` and `spare`."""
    path = tmp_path / "docks.yaml"
    path.write_text("docks:\n  lab: {}\n  spare: {}\n")
    with ExitStack() as stack:
        for robot in ROBOTS:
            arguments = ("-r", f"__ns:={robot}", "-p", f"dock_database:={path}")
            stack.enter_context(running_program(domain, "docking_server", *arguments))
        yield


@contextmanager
def two_robots(domain: int, folder: Path, *, batteries: bool = True) -> Iterator[RunningGateway]:
    """A gateway with a database that lasts, which knows both robots and their docks."""
    kept = {"database_url": f"sqlite:///{folder}/history.db", "spool_path": f"{folder}/spool"}
    with running_gateway(domain, namespace="/robot1", **kept) as gateway:
        for robot in ROBOTS:
            at = {"robot": robot}
            wait_until(lambda at=at: gateway.http.get("/docks", params=at).status_code == 200, robot)
            if batteries:
                battery(gateway, robot, LOW)
        yield gateway


def battery(gateway: RunningGateway, robot: str, state: dict[str, Any]) -> None:
    body = {"state": state, "rate_hz": 5.0}
    gateway.http.put("/battery/publisher", params={"robot": robot}, json=body).raise_for_status()


def send(gateway: RunningGateway, verb: str, robot: str, body: dict[str, Any] | None = None) -> Any:
    return gateway.http.post(f"/{verb}", params={"robot": robot}, json=body or {})


def dock(gateway: RunningGateway, name: str = "lab") -> dict[str, Any]:
    found: dict[str, Any] = gateway.http.get(f"/shared-docks/{name}").raise_for_status().json()
    return found


def until(gateway: RunningGateway, state: str, robot: str | None, name: str = "lab") -> dict[str, Any]:
    """Wait until a dock has a state and a robot; return it."""
    deadline = time.monotonic() + PATIENCE
    while ((found := dock(gateway, name))["state"], found["robot"]) != (state, robot):
        assert time.monotonic() < deadline, found
        time.sleep(0.05)
    return found


def mission(gateway: RunningGateway, mission_id: str) -> dict[str, Any]:
    found: dict[str, Any] = gateway.http.get(f"/missions/{mission_id}").raise_for_status().json()
    return found


@pytest.mark.usefixtures("servers")
def test_one_robot_has_the_dock_and_a_mission_waits_until_it_has_left_also_over_a_kill(
    domain: int, tmp_path: Path
) -> None:
    with two_robots(domain, tmp_path) as gateway:
        assert gateway.http.put("/shared-docks/lab", json={"by": "Ada"}).status_code == 201
        with gateway.stream("?include=shared_dock") as stream:
            sent = send(gateway, "dock", "/robot1", LAB)
            assert sent.status_code == 202, sent.text
            event = stream.until(lambda event: event["type"] == "shared_dock")
        assert (event["shared_dock"]["state"], event["shared_dock"]["robot"]) == ("reserved", "/robot1")
        refused = send(gateway, "dock", "/robot2", LAB)
        assert (refused.status_code, refused.json()["code"]) == (409, "dock_occupied")
        assert (refused.json()["robot"], refused.json()["since_at"]) == ("/robot1", dock(gateway)["since_at"])
        battery(gateway, "/robot1", CHARGING)
        gateway.wait_for_goal(sent.json()["goal_id"], "succeeded")
        until(gateway, "occupied", "/robot1")
        steps = {"steps": [{"dock": LAB}]}
        answer = gateway.http.post("/missions", params={"robot": "/robot2"}, json=steps).raise_for_status()
        waiting: str = answer.json()["mission_id"]
        wait_until(lambda: mission(gateway, waiting)["waits_for"] == "dock", "the mission at the dock")
        assert [each["robot"] for each in dock(gateway)["waiting"]] == ["/robot2"]
        gateway.process.send_signal(signal.SIGKILL)
        gateway.process.wait()
    with two_robots(domain, tmp_path, batteries=False) as gateway:
        battery(gateway, "/robot1", CHARGING)
        battery(gateway, "/robot2", LOW)
        assert (dock(gateway)["state"], dock(gateway)["robot"]) in [("occupied", "/robot1"), ("no_contact", "/robot1")]
        wait_until(lambda: mission(gateway, waiting)["waits_for"] == "dock", "the mission at the dock")
        battery(gateway, "/robot1", LOW)
        pushed_off = {"occupied_by": "nobody", "by": "Ada"}
        gateway.http.post("/shared-docks/lab/report", json=pushed_off).raise_for_status()
        until(gateway, "reserved", "/robot2")
        again = send(gateway, "dock", "/robot1", LAB)
        assert (again.status_code, again.json()["code"]) == (409, "dock_occupied")
        battery(gateway, "/robot2", CHARGING)
        wait_until(lambda: mission(gateway, waiting)["status"] == "succeeded", "the end of the mission")
        until(gateway, "occupied", "/robot2")


@contextmanager
def navigator(domain: int, robot: str) -> Iterator[list[tuple[str, float, float]]]:
    """A server of `navigate_to_pose` that a second takes for each goal; yields where it has been sent."""
    sent: list[tuple[str, float, float]] = []
    with ros_nodes(domain) as context:
        node = Node("bt_navigator", namespace=robot, context=context)
        server = Server(node)

        async def navigate(handle: Any) -> NavigateToPose.Result:
            pose = handle.request.pose
            sent.append((pose.header.frame_id, pose.pose.position.x, pose.pose.position.y))
            async for _ in server.steps(1.0):
                pass
            handle.succeed()
            return NavigateToPose.Result()

        served = server.serve(NavigateToPose, "navigate_to_pose", navigate, lambda: True)
        with Spinner(context, [node]) as spinner:
            try:
                yield sent
            finally:
                spinner.call(served.destroy).result(PATIENCE)


@pytest.mark.usefixtures("servers")
def test_a_robot_on_a_mission_waits_where_the_dock_says(domain: int, tmp_path: Path) -> None:
    with navigator(domain, "/robot2") as drives, two_robots(domain, tmp_path) as gateway:
        bays = {"waiting_places": [{"x": 4.0, "y": 1.5, "theta": 1.57}]}
        gateway.http.put("/shared-docks/lab", json=bays).raise_for_status()
        wait_until(
            lambda: gateway.http.get("/actions/robot2/navigate_to_pose").status_code == 200, "nav2 at the gateway"
        )
        sent = send(gateway, "dock", "/robot1", LAB)
        assert sent.status_code == 202, sent.text
        answer = gateway.http.post("/missions", params={"robot": "/robot2"}, json={"steps": [{"dock": LAB}]})
        waiting: str = answer.raise_for_status().json()["mission_id"]
        wait_until(lambda: mission(gateway, waiting)["waits_for"] == "dock", "the mission at its place")
        assert mission(gateway, waiting)["wait_at"] == {"x": 4.0, "y": 1.5, "yaw": 1.57, "frame": "map"}
        assert dock(gateway)["waiting"][0]["wait_at"] == {"x": 4.0, "y": 1.5, "theta": 1.57, "frame": "map"}
        assert drives == [("map", 4.0, 1.5)]
        gateway.http.post(f"/goals/{sent.json()['goal_id']}/cancel").raise_for_status()
        until(gateway, "reserved", "/robot2")
        battery(gateway, "/robot2", CHARGING)
        wait_until(lambda: mission(gateway, waiting)["status"] == "succeeded", "the end of the mission")
        assert (mission(gateway, waiting)["wait_at"], len(drives)) == (None, 1)


@pytest.mark.usefixtures("servers")
def test_a_goal_without_a_name_gets_a_free_dock_and_keeps_its_key(domain: int, tmp_path: Path) -> None:
    with two_robots(domain, tmp_path) as gateway:
        for name in ("lab", "spare"):
            gateway.http.put(f"/shared-docks/{name}", json={}).raise_for_status()
        for robot, name in (("/robot1", "lab"), ("/robot2", "spare")):
            key = {"Idempotency-Key": f"key of {robot}"}
            sent = [gateway.http.post("/dock", params={"robot": robot}, headers=key) for _ in range(2)]
            assert [answer.status_code for answer in sent] == [202, 202], sent[-1].text
            assert sent[0].json()["goal_id"] == sent[1].json()["goal_id"]
            assert gateway.goal(sent[0].json()["goal_id"])["goal"]["desired_battery_state"]["location"] == name
            until(gateway, "reserved", robot, name)
        goal_id = dock(gateway)["goal_ids"][0]
        gateway.http.post(f"/goals/{goal_id}/cancel").raise_for_status()
        until(gateway, "free", None)


@needs("simulator")
def test_a_goal_without_a_name_gets_the_nearest_dock_by_the_robots_transforms(domain: int) -> None:
    fleet, at = ("-m", "docking.nodes.simulated_fleet", "2"), {"robot": "/robot1"}
    with running_gateway(domain, namespace="/robot1") as gateway, ForkedProcess(*fleet, env=ros_environment(domain)):
        http = gateway.http
        wait_until(lambda: http.get("/simulator", params=at).status_code == 200, "a simulator")
        wait_until(lambda: http.get("/docks", params=at).status_code == 200, "its docking server")
        wait_until(lambda: http.get("/topics/robot1/tf").status_code == 200, "its transforms on the graph")
        for name in ("dock1", "dock2"):
            http.put(f"/shared-docks/{name}", json={}).raise_for_status()
        for lane, name in ((1.0, "dock2"), (0.0, "dock1")):
            http.post("/simulator/place", params=at, json={"x": -3.0, "y": lane, "theta": 0.0}).raise_for_status()
            goal_id = http.post("/dock", params=at).raise_for_status().json()["goal_id"]
            assert gateway.goal(goal_id)["goal"]["desired_battery_state"]["location"] == name
            http.post(f"/goals/{goal_id}/cancel").raise_for_status()
            until(gateway, "free", None, name)


@pytest.mark.usefixtures("servers")
def test_of_two_gateways_on_one_database_one_gets_the_dock_for_its_robot(domain: int, tmp_path: Path) -> None:
    with two_robots(domain, tmp_path) as first, two_robots(domain, tmp_path, batteries=False) as second:
        first.http.put("/shared-docks/lab", json={}).raise_for_status()
        wait_until(lambda: dock(second), "the dock at the other gateway")
        answers = [send(first, "dock", "/robot1", LAB), send(second, "dock", "/robot2", LAB)]
        assert [answer.status_code for answer in answers] == [202, 409]
        assert answers[1].json()["robot"] == "/robot1"
        out = {"out_of_order": True, "note": "The cable is loose"}
        second.http.post("/shared-docks/lab/report", json=out).raise_for_status()
        assert dock(first)["state"] == "out_of_order"


@pytest.mark.skipif(binaries() is None, reason="no PostgreSQL is installed")
def test_robots_of_two_ros_networks_share_a_dock_by_one_database() -> None:
    """As two sites do whose robots use the same dock: no gateway sees a robot of the other one."""
    with ExitStack() as stack:
        database = stack.enter_context(running_postgresql()).url
        gateways = []
        for robot in ROBOTS:
            domain = stack.enter_context(ros_domain())
            servers = ("-r", f"__ns:={robot}", "-p", "docks:=[lab]")
            stack.enter_context(running_program(domain, "docking_server", *servers))
            settings = {"namespace": robot, "serve_robots": robot, "database_url": database}
            gateways.append(stack.enter_context(running_gateway(domain, **settings)))
        first, second = gateways
        for gateway, robot in zip(gateways, ROBOTS, strict=True):
            wait_until(lambda gateway=gateway: gateway.http.get("/docks").status_code == 200, robot)
            battery(gateway, robot, LOW)
        first.http.put("/shared-docks/lab", json={}).raise_for_status()
        wait_until(lambda: second.http.get("/shared-docks/lab").status_code == 200, "the dock at the other gateway")
        sent = send(first, "dock", "/robot1", LAB)
        assert sent.status_code == 202, sent.text
        refused = send(second, "dock", "/robot2", LAB)
        assert (refused.json()["code"], refused.json()["robot"]) == ("dock_occupied", "/robot1")
        body = {"steps": [{"dock": LAB}]}
        waiting = second.http.post("/missions", params={"robot": "/robot2"}, json=body).raise_for_status().json()
        wait_until(lambda: mission(second, waiting["mission_id"])["waits_for"] == "dock", "the mission at the dock")
        assert [each["robot"] for each in dock(first)["waiting"]] == ["/robot2"]
        first.http.post(f"/goals/{sent.json()['goal_id']}/cancel").raise_for_status()
        until(second, "reserved", "/robot2")
        battery(second, "/robot2", CHARGING)
        wait_until(lambda: mission(second, waiting["mission_id"])["status"] == "succeeded", "the end of the mission")
        until(first, "occupied", "/robot2")


def test_docking_servers_read_the_docks_that_people_enter(domain: int, tmp_path: Path) -> None:
    path = tmp_path / "docks.yaml"
    path.write_text("docks:\n  lab: {}\n")
    arguments = ("-p", f"dock_database:={path}", "-p", "dock_plugins:=[wall_dock]")
    with (
        running_program(domain, "docking_server", *arguments),
        running_gateway(domain, chargers_file=str(path)) as gateway,
    ):
        wait_until(lambda: gateway.http.get("/docks").status_code == 200, "the docking server")

        def poses() -> dict[str, Any]:
            found = gateway.http.get("/docks")
            return {each["dock_id"]: each["pose"] for each in found.json()["docks"]} if found.is_success else {}

        def alerts() -> list[str]:
            found = gateway.http.get("/alerts").raise_for_status().json()["alerts"]
            return [each["detail"] for each in found if each["kind"] == "dock_file_unread"]

        at = {"x": 3.0, "y": 1.0, "theta": 1.5}
        gateway.http.put("/shared-docks/attic", json={"pose": at, "type": "wall_dock"}).raise_for_status()
        wait_until(lambda: poses() == {"attic": at}, "the docking server knows the new dock alone")
        gateway.http.put("/shared-docks/lab", json={"pose": {"x": 0, "y": 0}, "type": "cellar_dock"}).raise_for_status()
        wait_until(lambda: any("cellar_dock" in each for each in alerts()), "the server refuses a type that it has not")
        assert poses() == {"attic": at}
        gateway.http.put("/shared-docks/lab", json={"pose": {"x": 0, "y": 0}, "type": "wall_dock"}).raise_for_status()
        wait_until(lambda: sorted(poses()) == ["attic", "lab"] and not alerts(), "both docks, and no alert")
        assert gateway.http.post("/dock", json={"dock_id": "attic"}).status_code == 202
