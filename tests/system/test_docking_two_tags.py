"""Two tags on one topic over DDS: the one where the database has the dock is taken, and the other one is told."""

import pytest

from docking.core.geometry import Pose
from docking.simulation.dock import DOCKED
from tests.support.docking import FAST, SUCCEEDED, UNMEASURED, docking_servers, send_dock_goal
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.site import assert_docked, look_at

pytestmark = pytest.mark.ros

START = Pose(-1.5, 0.2, 0.0)  # both are in view
WORLD = [f"start_x:={START.x}", f"start_y:={START.y}", f"start_theta:={START.theta}", "marker_second_y:=0.6"]
IN_ODOM = DOCKED.relative_to(START)


def test_the_dock_of_the_database_is_taken_and_without_it_neither(domain: int, observer: Observer) -> None:
    known = (
        "controller:=dock_pose",
        "docks:=[home, elsewhere]",
        "home.frame:=odom",
        f"home.pose:=[{IN_ODOM.x}, {IN_ODOM.y}, {IN_ODOM.theta}]",
    )
    with dock_simulator(domain, *WORLD, FAST), docking_servers(domain, *known, UNMEASURED):
        here = look_at(observer)
        goal = send_dock_goal(observer, dock="elsewhere")
        report = here.expect_abort(goal, "FAILED_TO_DETECT_DOCK", within=20.0)
        assert "two markers are detected, 0.6 m from each other" in report["error_msg"]
        goal = send_dock_goal(observer, dock="home")
        assert goal.result().status == SUCCEEDED
        told = [report["message"] for report in here.reports.all if report["name"].endswith(": sensors")]
        assert any("/detected_dock_pose: another marker is detected 0.6 m from" in message for message in told)
        assert_docked(here.pose)
