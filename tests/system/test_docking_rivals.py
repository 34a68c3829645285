"""Two bases without namespaces in one domain, and clocks that disagree: the docking servers say so."""

import re

import pytest
from geometry_msgs.msg import Twist

from docking.ros.rivals import Rivals
from tests.support.docking import ABORTED, Reports, docking_servers, send_dock_goal
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

SENSORS = "connect_to_charging_dock_action_server: sensors"


def test_two_bases_are_named_before_the_robot_drives_and_in_the_goals_error(domain: int, observer: Observer) -> None:
    servers = docking_servers(domain, "controller:=dock_pose", "goal_timeout:=3.0")
    with dock_simulator(domain), dock_simulator(domain), servers:
        reports = Reports(observer)
        told = wait_until(lambda: next((report for report in reports.all if "/cmd_vel" in report), None), "a report")
        assert told is not None
        assert (told["name"], told["level"]) == (SENSORS, 1)
        assert told["/odom"].startswith(
            "/odom has 2 publishers, /dock_simulator and /dock_simulator, but a robot has one"
        )
        assert told["/cmd_vel"].startswith("/cmd_vel drives 2 bases, /dock_simulator and /dock_simulator: each goal")
        goal = send_dock_goal(observer)
        assert goal.result().status == ABORTED
        error = reports.wait_for(goal_id=goal.goal_id, stage="ABORTED")["error_msg"]
        assert "/odom has 2 publishers" in error
        assert "/cmd_vel drives 2 bases" in error


def test_one_base_and_others_that_listen_to_its_velocity_are_no_rivals(domain: int, observer: Observer) -> None:
    with dock_simulator(domain), docking_servers(domain, "controller:=dock_pose"):
        reports, rivals = Reports(observer), Rivals(observer.node)
        observer.record(Twist, "cmd_vel")
        wait_until(lambda: observer.node.count_subscribers("cmd_vel") >= 2, "both subscribers of cmd_vel")
        reports.wait_for(name=SENSORS, message="ok")
        observer.call(rivals.scan)
        assert rivals.faults == {}


@pytest.mark.parametrize(
    ("offset", "how"),
    [
        ("marker_stamp_offset:=0.4", r"/detected_dock_pose is stamped 0\.\d s after .* it is 0\.\d+ s in the future"),
        ("marker_stamp_offset:=3600.0", r"stamped 3\d+\.\d s after .* it is 3\d+\.\d+ s in the future"),
        ("odometry_stamp_offset:=5.0", r"stamped [45]\.\d s before .* and /odom is [45]\.\d+ s in the future"),
    ],
)
def test_clocks_that_disagree_are_named_in_the_goals_error(
    domain: int, observer: Observer, offset: str, how: str
) -> None:
    with (
        dock_simulator(domain, offset),
        docking_servers(domain, "controller:=dock_pose", "initial_perception_timeout:=3.0"),
    ):
        reports = Reports(observer)
        goal = send_dock_goal(observer)
        assert goal.result().status == ABORTED
        report = reports.wait_for(goal_id=goal.goal_id, stage="ABORTED")
        assert report["error_code"] == "FAILED_TO_DETECT_DOCK"
        assert re.search(how, report["error_msg"]), report["error_msg"]
