"""Scene, faults and the simulated robot over HTTP and WebSocket: the real simulator, the real servers, real DDS."""

import math
import time
from collections.abc import Iterator

import pytest
from geometry_msgs.msg import PolygonStamped
from nav_msgs.msg import Odometry

from robot_io.qos import LATCHED
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.observer import ros_observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

FAULTS = (
    "dead_charger",
    "flickering_charge",
    "dirty_contacts",
    "occluded_marker",
    "stuck_wheel",
    "late_commands",
    "lost_commands",
    "no_command_timeout",
    "worn_wheel",
    "wrong_detections",
    "future_detections",
    "lagging_detections",
    "frozen_camera",
    "extrapolating_camera",
    "repeated_odometry",
    "localization_jumps",
    "frozen_odometry",
    "open_loop_odometry",
    "obstacle",
    "occupied_dock",
    "hidden_beacon",
    "frozen_beacon",
    "frozen_scan",
    "infrared_ghosts",
    "silent_battery",
    "percentage_0_to_100",
)
ROUND = {"radius": 0.15, "points": None}


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with running_program(shared_domain, "dock_simulator"), running_gateway(shared_domain) as gateway:
        wait_for_simulator(gateway)
        yield gateway


def wait_for_simulator(gateway: RunningGateway) -> None:
    wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")


def place(gateway: RunningGateway, x: float, y: float, theta: float) -> None:
    gateway.http.post("/simulator/place", json={"x": x, "y": y, "theta": theta}).raise_for_status()


def is_at(scene: dict, x: float, y: float) -> bool:
    return math.hypot(scene["robot"]["x"] - x, scene["robot"]["y"] - y) < 0.01


def test_a_scene_is_one_picture_in_the_world(gateway: RunningGateway) -> None:
    with gateway.stream("?include=scene") as stream:
        place(gateway, -1.0, 0.2, -0.2)
        event = stream.until(lambda e: e["type"] == "scene" and is_at(e["scene"], -1.0, 0.2) and e["scene"]["marker"])
        assert event["robot"] == "/"
        scene = event["scene"]
        assert scene["frame"] == "world"
        assert scene["robot"]["theta"] == pytest.approx(-0.2, abs=0.01)
        assert scene["dock"] == {"x": 0.0, "y": 0.0, "theta": 0.0}
        seen = stream.until(lambda e: e["type"] == "scene" and e["scene"]["infrared"])["scene"]
        assert set(seen["infrared"]) == {"left", "center", "right"}
        # What the camera saw, from where the robot is, is the dock, but for noise of 1 cm and 1 degree.
        for _ in range(5):
            marker = stream.until(lambda e: e["type"] == "scene" and e["scene"]["marker"])["scene"]["marker"]
            assert math.hypot(marker["x"], marker["y"]) < 0.08
        started, count = time.monotonic(), 40
        for _ in range(count):
            stream.until_type("scene")
        assert count / (time.monotonic() - started) < 22


def test_a_real_robot_is_shown_in_the_frame_of_its_odometry() -> None:
    pose = Odometry(child_frame_id="base_link")
    pose.header.frame_id, pose.pose.pose.position.x = "odom", 0.5
    pose.header.stamp.sec = 1
    with ros_domain() as elsewhere, ros_observer(elsewhere) as robot, running_gateway(elsewhere) as lonely:
        with lonely.stream("?include=scene") as stream, robot.publishing(pose, "odom", period=0.05):
            scene = stream.until_type("scene")["scene"]
        assert (scene["frame"], scene["robot"]["x"], scene["dock"], scene["infrared"]) == ("odom", 0.5, None, None)


def test_the_footprint_is_what_the_docking_server_is_told(shared_domain: int) -> None:
    corners = [[0.3, 0.2], [0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2]]
    parameters = ("-p", f"footprint:='{corners}'", "-r", "__ns:=/robot1")
    expected = {"radius": 0.3606, "points": [{"x": x, "y": y} for x, y in corners]}
    wrong = PolygonStamped()
    wrong.header.frame_id = "map"
    with (
        ros_domain() as elsewhere,
        ros_observer(elsewhere) as observer,
        running_program(elsewhere, "dock_simulator", "-r", "__ns:=/robot1"),
        running_gateway(elsewhere) as gateway,
    ):
        wait_until(lambda: gateway.http.get("/simulator?robot=/robot1").status_code == 200, "the simulator")
        with gateway.stream("?robot=/robot1&include=scene,scenes") as stream:
            assert stream.until_type("scene")["scene"]["footprint"] is None
            with running_program(elsewhere, "docking_server", *parameters):
                stream.until(lambda e: e["type"] == "scene" and e["scene"]["footprint"] == expected)
                stream.until(lambda e: e["type"] == "scenes" and e["scenes"]["/robot1"]["footprint"] == expected)
                server = "/robot1/connect_to_charging_dock_action_server"
                assert observer.set_parameter(server, "footprint", "") == ""
                stream.until(lambda e: e["type"] == "scene" and e["scene"]["footprint"] == ROUND)
                observer.publish(wrong, "/robot1/footprint", LATCHED)
                gateway.process.wait_for(
                    "the footprint of /robot1 is ignored: it is in the frame map, not in base_link"
                )
            assert stream.until_type("scene")["scene"]["footprint"] == ROUND


def test_only_who_asks_for_it_gets_it_and_nobody_else_pays(gateway: RunningGateway, shared_domain: int) -> None:
    with gateway.stream("?include=system,battery") as other:
        with gateway.stream("?include=scene") as stream:
            stream.until_type("scene")
            gateway.process.wait_for("subscribed to scene of /")
        gateway.process.wait_for("unsubscribed from scene of /")
        for _ in range(20):
            other.next()
        assert "scene" not in {event["type"] for event in other.seen}
        with gateway.stream("?include=scene") as stream:
            stream.until_type("scene")


def test_faults_are_switched_and_ended_by_a_reset(gateway: RunningGateway) -> None:
    with gateway.stream("?include=system") as stream:
        for fault in FAULTS:
            answer = gateway.http.put(f"/simulator/faults/{fault}", json={"active": True}).raise_for_status().json()
            assert answer["faults"][fault] is True
        off = gateway.http.put("/simulator/faults/stuck_wheel", json={"active": False}).raise_for_status().json()
        assert off["faults"] == {fault: fault != "stuck_wheel" for fault in FAULTS}
        assert off == gateway.http.get("/simulator").json()
        stream.until(lambda e: e["type"] == "simulator" and e["simulator"] == off)
        reset = gateway.http.post("/simulator/reset").raise_for_status().json()
        assert reset["faults"] == dict.fromkeys(FAULTS, False)


def test_a_robot_on_its_dock_is_charged(gateway: RunningGateway) -> None:
    with gateway.stream("?include=system") as stream:
        place(gateway, -0.2, 0.0, 0.0)
        docked = stream.until(lambda e: e["type"] == "simulator" and e["simulator"]["docked"])["simulator"]
        assert docked["contact"] is True
        assert docked["battery_publisher"] == "self"
        gateway.http.post("/simulator/reset").raise_for_status()
        stream.until(lambda e: e["type"] == "simulator" and not e["simulator"]["contact"])


def test_a_battery_that_somebody_publishes_is_left_to_them(gateway: RunningGateway) -> None:
    gateway.publish({"power_supply_status": 3, "percentage": 0.24})
    wait_until(
        lambda: gateway.http.get("/simulator").json()["battery_publisher"] == "other", "the simulator's courtesy"
    )
    gateway.http.delete("/battery/publisher")
    wait_until(lambda: gateway.http.get("/simulator").json()["battery_publisher"] == "self", "the simulator's return")


@pytest.mark.parametrize(
    ("method", "path", "body"),
    [
        ("PUT", "/simulator/faults/gravity", {"active": True}),
        ("PUT", "/simulator/faults/stuck_wheel", {"active": 1}),
        ("PUT", "/simulator/faults/stuck_wheel", {}),
        ("POST", "/simulator/place", {"x": 1.0, "y": 0.0}),
        ("POST", "/simulator/place", {"x": 1e9, "y": 0.0, "theta": 0.0}),
        ("POST", "/simulator/place", {"x": True, "y": 0.0, "theta": 0.0}),
        ("POST", "/simulator/place", {"x": 0.0, "y": 0.0, "theta": 0.0, "z": 0.0}),
        ("POST", "/simulator/place", []),
    ],
)
def test_what_is_wrong_is_said(gateway: RunningGateway, method: str, path: str, body: object) -> None:
    response = gateway.http.request(method, path, json=body)
    assert (response.status_code, response.json()["code"]) == (422, "invalid_field")


def test_a_real_robot_has_no_simulator_and_one_that_leaves_is_missed(shared_domain: int) -> None:
    with ros_domain() as elsewhere, running_gateway(elsewhere) as gateway:
        for method, path, body in (
            ("GET", "", None),
            ("POST", "/reset", None),
            ("POST", "/place", {"x": 0.0, "y": 0.0, "theta": 0.0}),
            ("PUT", "/faults/stuck_wheel", {"active": True}),
        ):
            response = gateway.http.request(method, f"/simulator{path}", json=body)
            assert (response.status_code, response.json()["code"]) == (404, "simulator_not_found")
        with gateway.stream("?include=system") as stream:
            with running_program(elsewhere, "dock_simulator"):
                assert stream.until_type("simulator")["simulator"]["available"] is True
            stream.until(lambda e: e["type"] == "simulator" and not e["simulator"]["available"])
        assert gateway.http.get("/simulator").status_code == 404


def test_each_robot_has_a_scene_and_a_simulator_of_its_own(shared_domain: int) -> None:
    with ros_domain() as elsewhere:
        robots = ("/robot1", "/fleet/robot2")
        with (
            running_program(elsewhere, "dock_simulator", "-r", f"__ns:={robots[0]}"),
            running_program(elsewhere, "dock_simulator", "-r", f"__ns:={robots[1]}"),
            running_gateway(elsewhere) as gateway,
        ):
            for robot in robots:
                wait_until(lambda to=robot: gateway.http.get(f"/simulator?robot={to}").status_code == 200, robot)
            assert gateway.http.get("/simulator").status_code == 404
            pose = {"x": -1.2, "y": 0.1, "theta": 0.0}
            with gateway.stream(f"?robot={robots[0]}&include=scene,system") as stream:
                gateway.http.post(f"/simulator/place?robot={robots[0]}", json=pose).raise_for_status()
                stream.until(lambda e: e["type"] == "scene" and is_at(e["scene"], -1.2, 0.1))
                answer = gateway.http.put(f"/simulator/faults/dead_charger?robot={robots[1]}", json={"active": True})
                assert answer.json()["faults"]["dead_charger"] is True
                assert gateway.http.get(f"/simulator?robot={robots[0]}").json()["faults"]["dead_charger"] is False
                assert {event["robot"] for event in stream.seen if "robot" in event} == {robots[0]}
