"""The node `disconnect_from_charging_dock_action_server`: backs the robot out until its battery no longer charges."""

import time
from typing import Any

from rclpy.context import Context

from action_tutorials_interfaces.action import DisconnectFromChargingDock
from docking.core.battery import Battery
from docking.goal.admission import UNDOCKING
from docking.goal.engine import Command
from docking.parameters import GoalPolicy, UndockSettings
from docking.plans.undock import UndockGoal
from docking.ros.active_goal import ActiveGoal
from docking.ros.goal_server import GoalServer
from docking.ros.sensors import Sensor


class UndockServer(GoalServer):
    """Action server `disconnect_from_charging_dock`."""

    action_type = DisconnectFromChargingDock
    action_name = "disconnect_from_charging_dock"
    purpose = UNDOCKING
    settings_type = UndockSettings

    def __init__(
        self, battery: Battery, *, active_goal: ActiveGoal | None = None, context: Context | None = None, **options: Any
    ) -> None:
        """Make the node.

        Args:
            battery: Where the battery subscriber puts its readings.
            active_goal: Shared by all servers that drive this robot; None where there is no other.
            context: The ROS context; None is the default one.
            options: For rclpy's Node.

        Raises:
            rclpy.exceptions.ParameterException: A parameter is wrong.
        """
        super().__init__(
            "disconnect_from_charging_dock_action_server", battery, active_goal=active_goal, context=context, **options
        )

    def _take_settings(self, settings: UndockSettings) -> None:
        self._settings = settings

    @property
    def _goal_policy(self) -> GoalPolicy:
        return self._settings.goal_policy

    @property
    def _needs(self) -> frozenset[Sensor]:
        return frozenset({Sensor.ODOMETRY})

    @property
    def _control_period(self) -> float:
        return self._settings.control_period

    def _make_goal(self) -> UndockGoal:
        settings = self._settings
        return UndockGoal(settings.staging.distance, settings.motion, settings.timeouts, time.monotonic())

    def _tell_progress(self, command: Command) -> None:
        if command.error_msg == "":
            self.get_logger().info("BACKING OUT...", throttle_duration_sec=1.0)

    def _tell_success(self) -> None:
        self.get_logger().info("NOT CHARGING...")
        self.get_logger().info("Successfully disconnected from the charging dock!")
