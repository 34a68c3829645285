"""Has nav2 drive the robot to its staging pose, by the action `navigate_to_pose`, if there is such a server."""

import traceback
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.node import Node

from docking.goal.navigation import CannotNavigate, Navigation, RideState
from docking.parameters import StagingGoal
from docking.ros.geometry import stamped_pose
from docking.ros.sensors import Sensors

try:
    from nav2_msgs.action import NavigateToPose
except ImportError:  # not on PyPI
    NavigateToPose = None

__all__ = ["ACTION", "NavigateToPose", "NavigationClient"]

ACTION = "navigate_to_pose"
UNDER_WAY = frozenset({RideState.ASKED, RideState.DRIVING})
ENDS = {GoalStatus.STATUS_ABORTED: "aborted the goal", GoalStatus.STATUS_CANCELED: "was canceled by another client"}


class NavigationClient:
    """The client of the action. All calls must come from the thread that spins the node."""

    def __init__(self, node: Node) -> None:
        """Start without a client.

        Args:
            node: The node that asks.
        """
        self.node = node
        self.client: ActionClient | None = None
        self.ride: _Ride | None = None

    def switch(self, *, on: bool) -> None:
        """Make the client, which takes a moment to find the server, or destroy it.

        While a ride has not ended, the client stays: its cancel request may still have to go out.
        """
        if on and self.client is None and NavigateToPose is not None:
            self.client = ActionClient(self.node, NavigateToPose, ACTION)
        elif not on and (self.ride is None or self.ride.state not in UNDER_WAY):
            self.close()

    def close(self) -> None:
        """Destroy the client."""
        if self.client is not None:
            self.client.destroy()
            self.client = None

    def navigation(self, staging: StagingGoal, sensors: Sensors) -> Navigation:
        """A navigation to a staging pose.

        Args:
            staging: The pose.
            sensors: Where the robot is.
        """
        return Navigation(_Navigator(self, staging, sensors), staging.settings)

    @property
    def name(self) -> str:
        """The full name of the action."""
        return str(self.node.resolve_topic_name(ACTION))


class _Navigator:
    """See `docking.goal.navigation.Navigator`."""

    def __init__(self, client: NavigationClient, staging: StagingGoal, sensors: Sensors) -> None:
        self._client = client
        self._staging = staging
        self._sensors = sensors
        self._logger = client.node.get_logger()

    def distance(self) -> float:
        if NavigateToPose is None:
            raise CannotNavigate("nav2_msgs is not installed")
        if self._client.client is None or not self._client.client.server_is_ready():
            raise CannotNavigate(f"there is no action server {self._client.name}")
        try:
            return self._sensors.robot_in(self._staging.frame).distance_to(self._staging.pose)
        except ValueError as error:
            raise CannotNavigate(f"the pose of the dock {self._staging.dock!r} {error}") from None

    def send(self) -> "_Ride":
        staging = self._staging
        self._logger.info(
            f"{self._client.name} drives the robot to the staging pose of the dock {staging.dock!r},"
            f" ({staging.pose.x:.2f}, {staging.pose.y:.2f}) in {staging.frame}"
        )
        self._client.ride = ride = _Ride(self._client, staging)
        return ride

    def skip(self, reason: str) -> None:
        self._logger.warning(f"The robot is not driven to its staging pose before the dock is looked for: {reason}")


class _Ride:
    """See `docking.goal.navigation.Ride`."""

    def __init__(self, client: NavigationClient, staging: StagingGoal) -> None:
        assert client.client is not None
        self.reason = ""
        self.feedback = 0
        self._state = RideState.ASKED
        self._canceled = False
        self._handle: Any = None
        self._name = client.name
        self._client = client.client
        self._logger = client.node.get_logger()
        pose = stamped_pose(staging.pose, staging.frame, client.node.get_clock().now().to_msg())
        goal = NavigateToPose.Goal(pose=pose, behavior_tree=staging.settings.navigator_bt_xml)
        sent = self._client.send_goal_async(goal, feedback_callback=self._take_feedback)
        sent.add_done_callback(self._take_answer)

    @property
    def state(self) -> RideState:
        if self._state in UNDER_WAY and not self._client.server_is_ready():
            self.reason = f"{self._name} has left the ROS graph"
            return RideState.FAILED
        return self._state

    def cancel(self) -> None:
        self._canceled = True  # not accepted yet? `_take_answer` cancels it then
        if self._state is not RideState.DRIVING:
            return
        try:
            self._handle.cancel_goal_async().add_done_callback(self._take_cancellation)
        except Exception:  # noqa: BLE001 - whatever it is, the docking goal must still end
            self._logger.error(f"Cannot cancel the goal of {self._name}: {traceback.format_exc()}")

    def _take_feedback(self, _: Any) -> None:
        self.feedback += 1

    def _take_answer(self, future: Any) -> None:
        self._handle = future.result()
        if not self._handle.accepted:
            self._fail(f"{self._name} rejected the staging pose")
            return
        self._state = RideState.DRIVING
        self._handle.get_result_async().add_done_callback(self._take_result)
        if self._canceled:
            self.cancel()

    def _take_result(self, future: Any) -> None:
        status, result = future.result().status, future.result().result
        if status == GoalStatus.STATUS_SUCCEEDED:
            self._state = RideState.REACHED
            return
        # Older versions of nav2 have no error_code and no error_msg.
        code, message = getattr(result, "error_code", 0), getattr(result, "error_msg", "")
        details = ", ".join(part for part in (message, f"error_code {code}" if code else "") if part)
        end = ENDS.get(status, f"ended with the status {status}")
        self._fail(f"{self._name} {end}{f': {details}' if details else ''}")

    def _take_cancellation(self, future: Any) -> None:
        if not future.result().goals_canceling and self._state is RideState.DRIVING:
            self._logger.error(f"{self._name} refuses to cancel its goal: it may go on driving the robot")

    def _fail(self, reason: str) -> None:
        self._state, self.reason = RideState.FAILED, reason
