"""A detector that runs only while a goal needs it: its service over DDS."""

from typing import Any

import pytest
from std_srvs.srv import Trigger

from tests.support.docking import SERVER, docking_servers, send_dock_goal
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.site import NEAR, look_at
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

START = [f"start_x:={NEAR.x}", f"start_y:={NEAR.y}", f"start_theta:={NEAR.theta}"]


def test_the_detector_is_on_for_the_goal_alone(domain: int, observer: Observer) -> None:
    parameters = ("controller:=dock_pose", "detector_service_name:=dock_simulator/detector")
    stall = ("use_stall_detection:=true", "stall_joint_names:=[left_wheel_joint]")
    with (
        dock_simulator(domain, *START, "switched_detector:=true") as simulator,
        docking_servers(domain, *parameters, *stall, "detector_service_timeout:=20.0"),
    ):
        here = look_at(observer)
        assert not simulator.detects
        goal = send_dock_goal(observer)
        wait_until(lambda: simulator.detects, "the detector")
        wait_until(lambda: here.wheels.moving, "a move to what it detects")
        assert simulator.count_subscribers("joint_states") == 1
        assert goal.cancel()
        wait_until(lambda: not simulator.count_subscribers("joint_states"), "the end of the subscription")
        wait_until(lambda: not simulator.detects, "its end")

        called: list[str] = []

        def refuse(_: Trigger.Request, response: Trigger.Response) -> Any:
            called.append("")
            response.message = "no camera"
            return response

        observer.call(lambda: observer.node.create_service(Trigger, "camera/toggle", refuse))
        here.place(NEAR)
        assert observer.set_parameter(SERVER, "detector_service_name", "camera/toggle") == ""
        report = here.expect_abort(send_dock_goal(observer), "FAILED_TO_DETECT_DOCK", within=30.0)
        assert report["error_msg"] == "the detector's service /camera/toggle did not switch it on: no camera"
        wait_until(lambda: len(called) == 2, "the call at the end")
        assert observer.set_parameter(SERVER, "detector_service_name", "dock_simulator/reset/") != ""
