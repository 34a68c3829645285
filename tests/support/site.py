"""A simulated robot, its dock and the servers that drive it."""

import math
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from docking.core.geometry import Pose, yaw_of
from docking.simulation.dock import DOCKED
from tests.support.docking import ABORTED, Reports, Wheels, docking_servers, watch_wheels
from tests.support.observer import GoalOfTest, Observer, Recording
from tests.support.simulator import SimulatorControls, dock_simulator
from tests.support.waiting import wait_until

NEAR = Pose(-1.3, 0.0, 0.0)
"""A start from which the dock is seen, a few seconds away."""
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
        self.reports.wait_for(goal_id=goal.goal_id, stage=stage)

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


def assert_docked(robot: Pose) -> None:
    """In the contact zone, as the dock sees it, with a little room for the way after the contact."""
    offset = robot.relative_to(DOCKED)
    assert math.hypot(offset.x, offset.y) < 0.025
    assert abs(offset.theta) < math.radians(6)
