"""`navigate_to_pose` of the dock simulator: around walls, with its plan, and stopped by whatever stops a robot."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import Bool

from docking.core.geometry import Pose
from docking.ros.geometry import stamped_pose
from robot_io.qos import LATCHED
from tests.support.observer import GoalOfTest, Observer, Recording
from tests.support.simulator import SimulatorControls, dock_simulator, moving, pose_of
from tests.support.waiting import wait_until

NavigateToPose = pytest.importorskip(
    "nav2_msgs.action", reason="`make test` installs the interface packages of tests/interfaces"
).NavigateToPose

pytestmark = pytest.mark.ros

BEHIND_COLUMN = Pose(-2.5, -2.05, 1.0)
FAST = "real_time_factor:=3.0"


class Robot:
    """A simulated robot that is asked to drive somewhere."""

    def __init__(self, observer: Observer) -> None:
        self.controls = SimulatorControls(observer)
        self.truth: Recording = observer.record(Odometry, "ground_truth")
        self.plans: Recording = observer.record(Path, "plan")
        self._observer = observer

    def send(self, pose: Pose, frame: str = "map") -> GoalOfTest:
        message = stamped_pose(pose, frame, self._observer.node.get_clock().now().to_msg())
        return self._observer.send_goal(NavigateToPose, "navigate_to_pose", NavigateToPose.Goal(pose=message))

    @property
    def pose(self) -> Pose:
        return pose_of(self.truth.messages[-1])

    @property
    def drives(self) -> bool:
        return bool(self.truth.messages) and moving(self.truth.messages[-1])

    def drive_away(self) -> GoalOfTest:
        """A goal that the robot is on the way to, far away."""
        goal = self.send(Pose(-8.8, 3.0))
        wait_until(lambda: self.drives, "a move")
        return goal

    def expect_abort(self, goal: GoalOfTest, reason: str) -> Any:
        response = goal.result()
        assert (response.status, response.result.error_code) == (GoalStatus.STATUS_ABORTED, 208)
        assert response.result.error_msg == reason
        wait_until(lambda: not self.drives, "a standstill")


@contextmanager
def robot(domain: int, observer: Observer, *parameters: str) -> Iterator[Robot]:
    with dock_simulator(domain, FAST, *parameters):
        yield Robot(observer)


def test_it_drives_around_what_is_in_the_way(domain: int, observer: Observer) -> None:
    with robot(domain, observer, "start_x:=-3.9", "start_y:=-2.05", "start_theta:=0.0", "odometry_drift:=0.05") as here:
        goal = here.send(BEHIND_COLUMN)
        assert goal.result().status == GoalStatus.STATUS_SUCCEEDED
        wait_until(lambda: not here.drives, "a standstill")
        assert here.pose.distance_to(BEHIND_COLUMN) < 0.1
        assert goal.feedback[-1].distance_remaining < 0.3
        assert goal.feedback[-1].current_pose.header.frame_id == "map"
        here.plans.wait_for(lambda plan: not plan.poses)
        first = here.plans.messages[0]
        assert first.header.frame_id == "map"
        assert len(first.poses) > 2
        assert (first.poses[-1].pose.position.x, first.poses[-1].pose.position.y) == (-2.5, -2.05)

        here.expect_abort(here.send(Pose(-3.2, -2.05)), "there is no room for the robot at (-3.20, -2.05)")
        assert not here.send(Pose(), frame="elsewhere").accepted
        assert here.send(Pose(), frame="base_link").result().status == GoalStatus.STATUS_SUCCEEDED


def test_whatever_stops_a_robot_stops_it(domain: int, observer: Observer) -> None:
    with robot(domain, observer) as here:
        goal = here.drive_away()
        assert goal.cancel()
        assert goal.result().status == GoalStatus.STATUS_CANCELED
        wait_until(lambda: not here.drives, "a standstill")

        goal = here.drive_away()
        observer.publish(Bool(data=True), "stop_latched", LATCHED)
        here.expect_abort(goal, "a stop was latched")
        assert not here.send(Pose(-2.0)).accepted
        observer.publish(Bool(data=False), "stop_latched", LATCHED)
        here.controls.wait_for_status(halted="false")

        replaced = here.drive_away()
        goal = here.drive_away()
        assert replaced.result().result.error_msg == "another goal came"
        here.controls.reset()
        here.expect_abort(goal, "the simulator was reset")

        here.controls.switch("obstacle")
        goal = here.send(Pose(-0.35))
        here.expect_abort(goal, "an obstacle is in the way")
        assert here.pose.distance_to(Pose(-0.55, 0.05)) > 0.23
