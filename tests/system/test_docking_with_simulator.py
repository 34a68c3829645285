"""Docking and undocking a simulated robot, over DDS: it gets there, and whatever breaks ends in its own error code."""

import math
import random
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import pytest
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool

from docking.core.geometry import Pose, yaw_of
from docking.simulation.dock import DOCKED
from robot_io.qos import LATCHED
from tests.support.docking import (
    ABORTED,
    CANCELED,
    SUCCEEDED,
    Reports,
    Wheels,
    docking_servers,
    send_dock_goal,
    send_undock_goal,
    watch_wheels,
)
from tests.support.observer import GoalOfTest, Observer, Recording
from tests.support.processes import Process, ros_environment
from tests.support.simulator import SimulatorControls, dock_simulator
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

NEAR = Pose(-1.3, 0.0, 0.0)
"""A start from which the dock is seen, a few seconds away."""
FAR = Pose(-2.0, 0.3, 0.0)
NOT_CHARGING, CHARGING = 3, 1
MARGIN = 3.0
"""Seconds that a busy machine may add to a time-out."""


@dataclass
class Site:
    """A simulated robot that the servers drive, as a test sees it."""

    observer: Observer
    controls: SimulatorControls
    reports: Reports
    wheels: Wheels
    truth: Recording
    battery: Recording

    @property
    def pose(self) -> Pose:
        """Where the robot is, in world."""
        message = self.truth.messages[-1].pose.pose
        turn = message.orientation
        return Pose(message.position.x, message.position.y, yaw_of(turn.x, turn.y, turn.z, turn.w))

    @property
    def stands(self) -> bool:
        """Whether the robot itself stands still."""
        return bool(self.truth.messages[-1].twist.twist == Twist())

    def place(self, pose: Pose) -> None:
        """Lift the robot, set it down, and wait until that is seen."""
        self.controls.place(pose)
        wait_until(lambda: self.pose.distance_to(pose) < 0.01, f"the robot at {pose}")

    def wait_for_stage(self, goal: GoalOfTest, stage: str) -> None:
        """Wait until the goal has come to a stage."""
        self.reports.wait_for(30.0, goal_id=goal.goal_id, stage=stage)

    def expect_abort(self, goal: GoalOfTest, code: str, within: float) -> dict[str, str]:
        """The goal is aborted with a code, in time, and the robot stands still and is told to."""
        since = time.monotonic()
        assert goal.result(within + MARGIN).status == ABORTED
        took = time.monotonic() - since
        report = self.reports.wait_for(goal_id=goal.goal_id, stage="ABORTED")
        assert (report["error_code"], took < within + MARGIN) == (code, True), report
        self.expect_standstill()
        return report

    def expect_standstill(self) -> None:
        """The robot comes to a standstill, and stays there."""
        wait_until(lambda: self.wheels.standing, "zero velocity")
        wait_until(lambda: self.stands, "a standstill")
        since = len(self.truth.messages)
        wait_until(lambda: len(self.truth.messages) > since + 15, "half a second of odometry")
        assert all(message.twist.twist == Twist() for message in self.truth.messages[since:])
        assert self.wheels.standing


@contextmanager
def site(
    domain: int, observer: Observer, *parameters: str, controller: str = "dock_pose", robot: Sequence[str] = ()
) -> Iterator[Site]:
    """A simulator and the servers, with the robot at NEAR.

    Args:
        domain: The ROS domain.
        observer: The test's node.
        parameters: Of the servers.
        controller: How the robot is driven.
        robot: Parameters of the simulator.
    """
    with (
        dock_simulator(domain, f"start_x:={NEAR.x}", f"start_y:={NEAR.y}", f"start_theta:={NEAR.theta}", *robot),
        docking_servers(domain, f"controller:={controller}", *parameters),
    ):
        yield look_at(observer)


def look_at(observer: Observer) -> Site:
    """The site of a simulator and servers that run already."""
    seen = Site(
        observer,
        SimulatorControls(observer),
        Reports(observer),
        watch_wheels(observer),
        observer.record(Odometry, "ground_truth"),
        observer.record(BatteryState, "battery_status"),
    )
    wait_until(lambda: seen.truth.messages and seen.battery.messages, "the simulator")
    return seen


def random_starts(count: int, seed: int) -> list[Pose]:
    """Places up to 2.5 m from the dock and 60° off, looking up to 60° past it."""
    dice = random.Random(seed)
    starts = []
    for _ in range(count):
        distance, bearing, turn = dice.uniform(0.5, 2.5), dice.uniform(-1.0, 1.0), dice.uniform(-1.0, 1.0)
        starts.append(DOCKED.compose(Pose(-distance * math.cos(bearing), distance * math.sin(bearing), turn - bearing)))
    return starts


def assert_docked(robot: Pose) -> None:
    """In the contact zone, as the dock sees it, with a little room for the way after the contact."""
    offset = robot.relative_to(DOCKED)
    assert math.hypot(offset.x, offset.y) < 0.025
    assert abs(offset.theta) < math.radians(6)


@pytest.mark.parametrize("start", random_starts(1, seed=20), ids=str)
def test_dock_pose_docks_and_undocks(domain: int, observer: Observer, start: Pose) -> None:
    with site(domain, observer) as here:
        poses = {
            topic: observer.record(PoseStamped, topic) for topic in ("dock_pose", "filtered_dock_pose", "staging_pose")
        }
        here.place(start)
        goal = send_dock_goal(observer)
        answer = goal.result(75.0)
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

        undocking = send_undock_goal(observer)
        answer = undocking.result(20.0)
        assert answer.status == SUCCEEDED
        assert answer.result.final_battery_state.power_supply_status not in {CHARGING, 4}
        here.expect_standstill()
        assert here.pose.relative_to(DOCKED).x == pytest.approx(-0.7, abs=0.1)
        here.wait_for_stage(undocking, "UNDOCKING")
        assert here.controls.status["docked"] == "false"


@pytest.mark.parametrize(
    "robot",
    [
        ("enable_stamped_cmd_vel:=true", "command_delay:=0.2", "odometry_delay:=0.1", "linear_acceleration:=0.3"),
        (
            "linear_max:=0.15",
            "angular_max:=0.5",
            "linear_dead_zone:=0.05",
            "angular_dead_zone:=0.1",
            "odometry_twist:=false",
            "marker_rate:=4.0",
            "marker_noise:=0.03",
        ),
    ],
    ids=["late, by TwistStamped", "weak, with a poor camera"],
)
@pytest.mark.timeout(180)
def test_robots_that_are_not_perfect_dock_within_their_limits(
    domain: int, observer: Observer, robot: Sequence[str]
) -> None:
    with site(domain, observer, robot=robot) as here:
        assert send_dock_goal(observer).result(120.0).status == SUCCEEDED
        assert_docked(here.pose)
        here.expect_standstill()
        assert any(message != Twist() for message in here.wheels.messages)
        assert all(abs(message.linear.x) <= 0.26 and abs(message.angular.z) <= 1.0 for message in here.wheels.messages)


@pytest.mark.timeout(240)
def test_infrared_docks(domain: int, observer: Observer) -> None:
    with site(domain, observer, controller="infrared") as here:
        here.place(Pose(-0.7, 0.03, 0.1))
        goal = send_dock_goal(observer)
        assert goal.result(180.0).status == SUCCEEDED
        assert_docked(here.pose)
        here.expect_standstill()


def test_a_robot_that_is_docked_already_docks_without_a_move(domain: int, observer: Observer) -> None:
    with site(domain, observer) as here:
        here.place(DOCKED)
        here.battery.wait_for(lambda state: state.power_supply_status == CHARGING)
        assert send_dock_goal(observer).result().status == SUCCEEDED
        assert not any(message != Twist() for message in here.wheels.messages)


# Whatever breaks ends in its own error code, in time, with the robot standing still.


def test_a_dead_charger(domain: int, observer: Observer) -> None:
    with site(domain, observer, "wait_charge_timeout:=1.0", "max_retries:=1") as here:
        here.controls.switch("dead_charger")
        goal = send_dock_goal(observer)
        here.wait_for_stage(goal, "WAIT_FOR_CHARGE")
        assert here.controls.status["contact"] == "true"
        retry = here.reports.wait_for(30.0, goal_id=goal.goal_id, stage="RETRY")
        assert (retry["error_code"], retry["retries"]) == ("FAILED_TO_CHARGE", "1")
        report = here.expect_abort(goal, "FAILED_TO_CHARGE", within=30.0)
        assert (report["retries"], report["error_number"]) == ("1", "906")


def test_a_charger_that_comes_back_charges_at_the_second_attempt(domain: int, observer: Observer) -> None:
    with site(domain, observer, "wait_charge_timeout:=1.0") as here:
        here.controls.switch("dead_charger")
        goal = send_dock_goal(observer)
        here.reports.wait_for(30.0, goal_id=goal.goal_id, stage="RETRY", error_code="FAILED_TO_CHARGE")
        here.controls.switch("dead_charger", on=False)
        assert goal.result(40.0).status == SUCCEEDED
        report = here.reports.wait_for(goal_id=goal.goal_id, stage="SUCCEEDED")
        assert (report["retries"], report["error_code"]) == ("1", "NONE")
        here.expect_standstill()


def test_a_marker_that_is_never_seen(domain: int, observer: Observer) -> None:
    with site(domain, observer, "initial_perception_timeout:=2.0", "max_retries:=0") as here:
        here.controls.switch("occluded_marker")
        time.sleep(0.3)  # until the last detection is too old to count
        goal = send_dock_goal(observer)
        report = here.expect_abort(goal, "FAILED_TO_DETECT_DOCK", within=2.0)
        assert report["error_number"] == "904"


def test_a_marker_that_is_covered_on_the_way(domain: int, observer: Observer) -> None:
    with site(domain, observer, "external_detection_timeout:=0.5", "max_retries:=0") as here:
        goal = send_dock_goal(observer)
        here.wait_for_stage(goal, "CONTROLLING")
        here.controls.switch("occluded_marker")
        here.expect_abort(goal, "LOST_MARKER", within=0.5)
        assert here.controls.status["contact"] == "false"


def test_a_wheel_that_is_stuck(domain: int, observer: Observer) -> None:
    with site(domain, observer, "blocked_after:=1.0", "max_retries:=0") as here:
        here.place(FAR)
        goal = send_dock_goal(observer)
        wait_until(lambda: not here.stands, "a move")
        here.controls.switch("stuck_wheel")
        here.expect_abort(goal, "BLOCKED", within=2.0)


def test_a_battery_that_falls_silent(domain: int, observer: Observer) -> None:
    with site(domain, observer, "battery_stale_after:=0.5", "battery_lost_after:=2.0") as here:
        goal = send_dock_goal(observer)
        wait_until(lambda: here.wheels.moving, "a move")
        here.controls.switch("silent_battery")
        here.reports.wait_for(goal_id=goal.goal_id, stage="WAIT_FOR_BATTERY", error_code="BATTERY_STALE")
        wait_until(lambda: here.stands, "a standstill")
        here.controls.switch("silent_battery", on=False)
        wait_until(lambda: here.wheels.moving, "a move after the silence")
        here.controls.switch("silent_battery")
        here.expect_abort(goal, "BATTERY_LOST", within=2.0)


def test_a_percentage_of_a_hundred_is_told_and_does_no_harm(domain: int, observer: Observer) -> None:
    with site(domain, observer) as here:
        here.controls.switch("percentage_0_to_100")
        goal = send_dock_goal(observer)
        assert goal.result(40.0).status == SUCCEEDED
        assert goal.feedback[-1].current_battery_state.percentage > 1.0
        complaint = "/battery_status has a percentage of "
        assert any(complaint in report["message"] and report["level"] == 1 for report in here.reports.all)


def test_a_wheel_that_is_stuck_on_the_dock(domain: int, observer: Observer) -> None:
    with site(domain, observer, "blocked_after:=1.0") as here:
        here.place(DOCKED)
        here.battery.wait_for(lambda state: state.power_supply_status == CHARGING)
        here.controls.switch("stuck_wheel")
        report = here.expect_abort(send_undock_goal(observer), "FAILED_TO_UNDOCK", within=2.0)
        assert "(blocked_after)" in report["error_msg"]


def test_undocking_that_takes_too_long(domain: int, observer: Observer) -> None:
    with site(domain, observer, "undocking_timeout:=4.6") as here:
        here.place(DOCKED)
        here.battery.wait_for(lambda state: state.power_supply_status == CHARGING)
        here.expect_abort(send_undock_goal(observer), "FAILED_TO_UNDOCK", within=4.6)


# Whoever wants it to end can end it.


def test_a_cancel_on_the_way(domain: int, observer: Observer) -> None:
    with site(domain, observer) as here:
        goal = send_dock_goal(observer)
        wait_until(lambda: not here.stands, "a move")
        assert goal.cancel()
        assert goal.result().status == CANCELED
        here.expect_standstill()


def test_a_goal_that_preempts_another(domain: int, observer: Observer) -> None:
    with site(domain, observer, "goal_policy:=preempt") as here:
        first = send_dock_goal(observer)
        wait_until(lambda: not here.stands, "a move")
        second = send_dock_goal(observer)
        assert first.result().status == ABORTED
        here.reports.wait_for(goal_id=first.goal_id, stage="ABORTED", error_code="PREEMPTED")
        assert second.result(40.0).status == SUCCEEDED
        here.expect_standstill()


def test_a_stop_that_is_latched_on_the_way(domain: int, observer: Observer) -> None:
    with site(domain, observer) as here:
        goal = send_dock_goal(observer)
        wait_until(lambda: not here.stands, "a move")
        observer.publish(Bool(data=True), "stop_latched", LATCHED)
        here.expect_abort(goal, "STOP_LATCHED", within=0.0)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_the_end_of_the_server_on_the_way(domain: int, observer: Observer, number: signal.Signals) -> None:
    environment = ros_environment(domain)
    with (
        Process("dock_simulator", env=environment),
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
