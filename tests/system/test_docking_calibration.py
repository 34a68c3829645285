"""The service `calibrate_dock`, over DDS: a server that does not know where its marker is learns it on the dock."""

from collections.abc import Iterator

import pytest
import yaml
from geometry_msgs.msg import Twist
from rcl_interfaces.srv import GetParameters
from std_srvs.srv import Trigger

from docking.core.geometry import Pose
from docking.simulation.dock import DOCKED
from tests.support.docking import ABORTED, FAST, SERVER, SUCCEEDED, UNMEASURED, docking_servers, send_dock_goal
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.site import NEAR, Site, assert_docked, look_at
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

NAMES = [f"external_detection_{name}" for name in ("translation_x", "translation_y", "rotation_yaw")]
WRONG = (-0.26, 0.07, 0.1)
"""Where the docked robot is not."""
CALIBRATION_TIME = 60.0
"""Seconds to wait for an answer: it takes 3 s, and the machine may be busy."""


@pytest.fixture
def here(domain: int, observer: Observer) -> Iterator[Site]:
    wrong = [f"{name}:={value}" for name, value in zip(NAMES, WRONG, strict=True)]
    server = ("controller:=dock_pose", "max_retries:=0", "wait_charge_timeout:=1.0", UNMEASURED)
    with (
        dock_simulator(domain, f"start_x:={NEAR.x}", f"start_y:={NEAR.y}", f"start_theta:={NEAR.theta}", FAST),
        docking_servers(domain, *server, *wrong),
    ):
        yield look_at(observer)


def offered(observer: Observer) -> bool:
    services = observer.call(lambda: observer.node.get_service_names_and_types_by_node(SERVER[1:], "/"))
    return "/calibrate_dock" in dict(services)


def calibrate(observer: Observer) -> Trigger.Response:
    return observer.request(Trigger, "calibrate_dock", Trigger.Request(), CALIBRATION_TIME)


def parameters(observer: Observer) -> list[float]:
    answer = observer.request(GetParameters, f"{SERVER}/get_parameters", GetParameters.Request(names=NAMES))
    return [value.double_value for value in answer.values]


def test_a_server_with_wrong_offsets_docks_after_calibration(here: Site, observer: Observer) -> None:
    goal = send_dock_goal(observer)
    while_driving = calibrate(observer)
    assert (while_driving.success, while_driving.message.partition(":")[0]) == (False, "a goal is running")
    assert goal.result().status == ABORTED
    assert here.controls.status["docked"] == "false"

    here.place(DOCKED)
    driven = len(here.wheels.messages)
    first = observer.ask(Trigger, "calibrate_dock", Trigger.Request())
    assert calibrate(observer).message == "a calibration is running"
    answer = observer.result_of(first, "the calibration", CALIBRATION_TIME)
    assert answer.success, answer.message
    assert all(message == Twist() for message in here.wheels.messages[driven:])
    values = yaml.safe_load(answer.message)[SERVER]["ros__parameters"]
    measured = Pose(*(values[name] for name in NAMES)).relative_to(DOCKED)
    assert measured.distance_to(Pose()) < 0.01
    assert abs(measured.theta) < 0.02
    assert parameters(observer) == pytest.approx([values[name] for name in NAMES])
    for old in WRONG:
        assert f"# before: {old}" in answer.message
    assert "write them into its parameter file" in answer.message

    here.place(NEAR)
    assert send_dock_goal(observer).result().status == SUCCEEDED
    assert_docked(here.pose)


def test_a_goal_ends_a_calibration(here: Site, observer: Observer) -> None:
    asked = observer.ask(Trigger, "calibrate_dock", Trigger.Request())
    goal = send_dock_goal(observer)
    assert observer.result_of(asked, "the calibration").message == "a goal has arrived"
    assert goal.accepted
    assert goal.cancel()
    assert parameters(observer) == pytest.approx(list(WRONG))


def test_a_server_that_no_longer_calibrates_answers_and_goes_on(here: Site, observer: Observer) -> None:
    asked = observer.ask(Trigger, "calibrate_dock", Trigger.Request())
    assert observer.set_parameter(SERVER, "controller", "rotate") == ""
    assert observer.result_of(asked, "the answer").message == "the server no longer calibrates"
    wait_until(lambda: not offered(observer), "the service to go")
    assert observer.set_parameter(SERVER, "controller", "dock_pose") == ""
    wait_until(lambda: offered(observer), "the service to come back")
    goal = send_dock_goal(observer)
    assert goal.accepted
    assert goal.cancel()


def test_a_sensor_that_cannot_be_subscribed_to_is_the_answer(domain: int, observer: Observer) -> None:
    with docking_servers(domain, "controller:=dock_pose", "qos_overrides./odom.subscription.reliability:=none"):
        for _ in range(2):
            answer = calibrate(observer)
            assert not answer.success
            assert "reliability" in answer.message
