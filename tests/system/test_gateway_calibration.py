"""Calibration of a dock over HTTP: a real docking server and simulator, real DDS."""

from collections.abc import Iterator

import httpx2
import pytest
import yaml
from std_srvs.srv import Trigger

from tests.support.gateway import RunningGateway, running_program
from tests.support.observer import Observer, ros_observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

ROBOT = "/robot1"
NAMES = [f"external_detection_{name}" for name in ("translation_x", "translation_y", "rotation_yaw")]


@pytest.fixture(scope="module")
def observer(shared_domain: int) -> Iterator[Observer]:
    with ros_observer(shared_domain) as observer:
        yield observer


def problem(answer: httpx2.Response) -> tuple[int, str]:
    return answer.status_code, answer.json()["code"]


def test_a_robot_whose_server_does_not_calibrate(gateway: RunningGateway) -> None:
    assert gateway.http.get("/calibration").json() == {"available": False, "service": "/calibrate_dock"}
    assert problem(gateway.http.post("/calibration")) == (501, "calibration_unavailable")
    assert problem(gateway.http.post("/calibration?robot=/nobody")) == (404, "robot_not_found")


@pytest.mark.parametrize(
    ("success", "text", "parameters"),
    [
        (True, "/a/b:\n  ros__parameters:\n    wall.x_y: -0.25  # before: 1e-05", [("wall.x_y", -0.25, 1e-05)]),
        (True, "done", []),
        (False, "the robot moved", None),
    ],
)
def test_what_a_server_says_is_passed_on(
    gateway: RunningGateway, observer: Observer, success: bool, text: str, parameters: list[tuple[str, float, float]]
) -> None:
    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = success, text
        return response

    service = observer.call(lambda: observer.node.create_service(Trigger, "/calibrate_dock", answer))
    wait_until(lambda: gateway.http.get("/calibration").json()["available"], "the service")
    given = gateway.http.post("/calibration")
    if success:
        found = [tuple(parameter.values()) for parameter in given.json()["parameters"]]
        assert (given.status_code, found, given.json()["yaml"]) == (200, parameters, text)
    else:
        assert problem(given) == (409, "calibration_refused")
        assert given.json()["detail"] == text
    observer.call(lambda: observer.node.destroy_service(service))
    wait_until(lambda: not gateway.http.get("/calibration").json()["available"], "the end of the service")


def test_the_dock_of_one_robot_is_calibrated(gateway: RunningGateway, shared_domain: int) -> None:
    namespace = ("-r", f"__ns:={ROBOT}")
    on_its_dock = [part for name in ("x:=-0.2", "y:=0.0", "theta:=0.0") for part in ("-p", f"start_{name}")]
    with (
        running_program(shared_domain, "dock_simulator", *namespace, *on_its_dock),
        running_program(
            shared_domain, "docking_server", *namespace, "-p", "controller:=dock_pose", "-p", f"{NAMES[1]}:=0.07"
        ),
    ):
        query = f"/calibration?robot={ROBOT}"
        service = {"available": True, "service": f"{ROBOT}/calibrate_dock"}
        wait_until(lambda: gateway.http.get(query).json() == service, "the service")
        answer = gateway.http.post(query, timeout=60.0).raise_for_status().json()
        assert [parameter["name"] for parameter in answer["parameters"]] == NAMES
        assert answer["parameters"][1]["before"] == 0.07
        values = [parameter["value"] for parameter in answer["parameters"]]
        assert values == pytest.approx([-0.2, 0.0, 0.0], abs=0.015)
        (node, said), *_ = yaml.safe_load(answer["yaml"]).items()
        assert node == f"{ROBOT}/connect_to_charging_dock_action_server"
        assert list(said["ros__parameters"].values()) == values
        assert gateway.http.get("/calibration").json()["available"] is False
