"""Docking and undocking a simulated robot, over DDS: it gets there, and whatever breaks ends in its own error code."""

import signal

import pytest
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Path

from docking.core.geometry import Pose
from docking.ros.geometry import pose_from
from docking.simulation.dock import DOCKED
from tests.support.docking import SUCCEEDED, send_dock_goal, send_undock_goal
from tests.support.observer import Observer
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.site import assert_docked, look_at, site
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

ASIDE = Pose(-2.35, 0.84, 0.16)
"""2.3 m from the dock, and 20° off its axis."""
NOT_CHARGING, CHARGING = 3, 1


def test_dock_pose_docks_and_undocks(domain: int, observer: Observer) -> None:
    with site(domain, observer) as here:
        poses = {
            topic: observer.record(PoseStamped, topic) for topic in ("dock_pose", "filtered_dock_pose", "staging_pose")
        }
        plans = observer.record(Path, "plan")
        here.place(ASIDE)
        goal = send_dock_goal(observer)
        answer = goal.result()
        assert answer.status == SUCCEEDED
        assert answer.result.final_battery_state.power_supply_status == CHARGING
        assert_docked(here.pose)
        here.expect_standstill()
        assert_docked(here.pose)
        here.controls.wait_for_status(docked="true")
        stages = [report["stage"] for report in here.reports.all if report.get("goal_id") == goal.goal_id]
        for earlier, later in (("INITIAL_PERCEPTION", "NAV_TO_STAGING_POSE"), ("CONTROLLING", "SUCCEEDED")):
            assert stages.index(earlier) < stages.index(later)
        assert all(abs(message.linear.x) <= 0.26 and abs(message.angular.z) <= 1.0 for message in here.wheels.messages)
        assert all(recording.messages[-1].header.frame_id == "odom" for recording in poses.values())
        plans.wait_for(lambda plan: not plan.poses)
        assert {len(plan.poses) for plan in plans.messages} == {0, 2, 3}, "by way of the staging pose, then the rest"
        ahead = [plan for plan in plans.messages if plan.poses]
        docked = pose_from(poses["filtered_dock_pose"].messages[-1].pose)
        assert all(pose_from(plan.poses[-1].pose).distance_to(docked) < 0.3 for plan in ahead)
        assert {plan.header.frame_id for plan in plans.messages} == {"odom"}

        undocking = send_undock_goal(observer)
        answer = undocking.result()
        assert answer.status == SUCCEEDED
        assert answer.result.final_battery_state.power_supply_status not in {CHARGING, 4}
        here.expect_standstill()
        assert here.pose.relative_to(DOCKED).x == pytest.approx(-0.7, abs=0.1)
        here.wait_for_stage(undocking, "UNDOCKING")
        assert here.controls.status["docked"] == "false"


def test_a_robot_that_is_late_docks_within_its_limits(domain: int, observer: Observer) -> None:
    robot = "enable_stamped_cmd_vel:=true", "command_delay:=0.2", "odometry_delay:=0.1", "linear_acceleration:=0.3"
    with site(domain, observer, robot=robot) as here:
        assert send_dock_goal(observer).result(120.0).status == SUCCEEDED
        assert_docked(here.pose)
        here.expect_standstill()
        assert any(message != Twist() for message in here.wheels.messages)
        assert all(abs(message.linear.x) <= 0.26 and abs(message.angular.z) <= 1.0 for message in here.wheels.messages)


def test_infrared_docks(domain: int, observer: Observer) -> None:
    with site(domain, observer, controller="infrared") as here:
        here.place(Pose(-0.5, 0.02, 0.05))
        goal = send_dock_goal(observer)
        assert goal.result(180.0).status == SUCCEEDED
        assert_docked(here.pose)
        here.expect_standstill()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_the_end_of_the_server_on_the_way(domain: int, observer: Observer, number: signal.Signals) -> None:
    environment = ros_environment(domain)
    with (
        ForkedProcess("dock_simulator", env=environment),
        Process("docking_server", "--ros-args", "-p", "controller:=dock_pose", env=environment) as server,
    ):
        here = look_at(observer)
        goal = send_dock_goal(observer)
        wait_until(lambda: not here.stands, "a move")
        server.send_signal(number)
        if number == signal.SIGTERM:
            here.expect_abort(goal, "SHUTTING_DOWN", within=0.0)
            assert server.wait() == 0
        wait_until(lambda: here.stands, "a standstill", timeout=3.0)  # SIGKILL: the base has a watchdog, too
