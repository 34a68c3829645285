"""Obstacles over DDS: a robot with a laser scanner waits for them, and never touches one."""

import math

import pytest

from docking.simulation.faults import IN_THE_WAY
from tests.support.docking import SUCCEEDED, docking_servers, send_dock_goal
from tests.support.observer import Observer
from tests.support.simulator import dock_simulator
from tests.support.site import NEAR, Site, assert_docked, look_at
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

START = [f"start_x:={NEAR.x}", f"start_y:={NEAR.y}", f"start_theta:={NEAR.theta}"]
# A busy machine is no broken scanner.
WATCHED = ("controller:=dock_pose", "use_collision_detection:=true", "scan_timeout:=5.0", "obstacle_timeout:=6.0")
# The simulated scanner is not where the server would look for it by default.
MOUNTED = ("laser_x:=0.1", "laser_yaw:=0.5"), ("scan_from_tf:=true",)


def gap(here: Site) -> float:
    """The least that there has been between the robot and the obstacle, in m."""
    places = [message.pose.pose.position for message in here.truth.messages]
    nearest = min(math.hypot(place.x - IN_THE_WAY.x, place.y - IN_THE_WAY.y) for place in places)
    return nearest - IN_THE_WAY.radius - 0.15


def test_the_robot_waits_for_an_obstacle_and_is_aborted_where_it_stays(domain: int, observer: Observer) -> None:
    simulated, told = MOUNTED
    with dock_simulator(domain, *START, *simulated), docking_servers(domain, *WATCHED, *told):
        here = look_at(observer)
        goal = send_dock_goal(observer)
        wait_until(lambda: here.wheels.moving, "a move")
        here.controls.switch("obstacle")
        waiting = here.reports.wait_for(goal_id=goal.goal_id, stage="WAIT_FOR_CLEARANCE")
        assert (waiting["error_code"], waiting["level"]) == ("OBSTRUCTED", 1)
        assert waiting["message"] == "an obstacle is in the way: the robot waits"
        here.expect_standstill()
        assert 0.0 < gap(here) < 0.3
        here.controls.switch("obstacle", on=False)
        wait_until(lambda: here.wheels.moving, "the way on")
        assert goal.result().status == SUCCEEDED
        assert_docked(here.pose)

        here.place(NEAR)
        seen = len(here.reports.all)
        goal = send_dock_goal(observer)
        wait_until(lambda: here.wheels.moving, "a move")
        here.truth.messages.clear()
        here.controls.switch("obstacle")
        report = here.expect_abort(goal, "OBSTRUCTED", within=30.0)
        assert (report["error_number"], report["retries"]) == ("974", "0")
        assert gap(here) > 0.0
        assert len(here.reports.all) > seen


def test_a_scanner_that_falls_silent(domain: int, observer: Observer) -> None:
    with (
        dock_simulator(domain, *START, "laser_rate:=0.1"),
        docking_servers(domain, *WATCHED, "scan_timeout:=0.5", "obstacle_timeout:=2.0"),
    ):
        here = look_at(observer)
        goal = send_dock_goal(observer)
        here.reports.wait_for(goal_id=goal.goal_id, stage="WAIT_FOR_CLEARANCE", error_code="SCAN_LOST")
        report = here.expect_abort(goal, "SCAN_LOST", within=3.0)
        assert report["error_msg"] == "the robot has waited for 2 s (obstacle_timeout): there is no scan"
        assert here.controls.status["contact"] == "false"
