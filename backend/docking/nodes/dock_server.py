"""The node `connect_to_charging_dock_action_server`: drives the robot until its battery is charging."""

import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.context import Context

from action_tutorials_interfaces.action import ConnectToChargingDock
from docking.core.battery import Battery
from docking.core.errors import Stage
from docking.goal.admission import DOCKING
from docking.goal.engine import Command, DockGoal
from docking.goal.plan import Plan
from docking.parameters import ControllerName, DockSettings, GoalPolicy
from docking.plans.registry import make_plan
from docking.ros.active_goal import ActiveGoal
from docking.ros.footprint import FootprintPublisher
from docking.ros.goal_server import FEEDBACK_PERIOD, GoalServer
from docking.ros.poses import PosePublishers
from docking.ros.process import run_process
from docking.ros.sensors import Sensor
from docking.ros.server_process import serve

NEEDS: dict[ControllerName, frozenset[Sensor]] = {
    ControllerName.ROTATE: frozenset(),
    ControllerName.DOCK_POSE: frozenset({Sensor.ODOMETRY, Sensor.MARKER}),
    ControllerName.INFRARED: frozenset({Sensor.ODOMETRY, Sensor.INFRARED}),
}


class DockServer(GoalServer):
    """Action server `connect_to_charging_dock`."""

    action_type = ConnectToChargingDock
    action_name = "connect_to_charging_dock"
    purpose = DOCKING
    settings_type = DockSettings

    def __init__(
        self,
        battery: Battery,
        *,
        active_goal: ActiveGoal | None = None,
        make_plan: Callable[[DockSettings], Plan] = make_plan,
        context: Context | None = None,
        **options: Any,
    ) -> None:
        """Make the node.

        Args:
            battery: Where the battery subscriber puts its readings.
            active_goal: Shared by all servers that drive this robot; None where there is no other.
            make_plan: Makes the plan of each goal.
            context: The ROS context; None is the default one.
            options: For rclpy's Node.

        Raises:
            rclpy.exceptions.ParameterException: A parameter is wrong.
        """
        self._make_plan = make_plan
        self._poses = PosePublishers(self)
        self._footprint = FootprintPublisher(self)
        super().__init__(
            "connect_to_charging_dock_action_server", battery, active_goal=active_goal, context=context, **options
        )
        battery.on_connected = self.control  # at once, not at the next turn of the timer

    def _take_settings(self, settings: DockSettings) -> None:
        self._settings = settings

    @property
    def _goal_policy(self) -> GoalPolicy:
        return self._settings.goal_policy

    @property
    def _needs(self) -> frozenset[Sensor]:
        return NEEDS[self._settings.controller]

    @property
    def _control_period(self) -> float:
        # `rotate` gives ten velocities a second, as the tutorial does.
        return FEEDBACK_PERIOD if self._settings.controller is ControllerName.ROTATE else self._settings.control_period

    def _equip(self) -> None:
        super()._equip()
        self._footprint.publish(self._settings.outline)
        if self._running is None:
            self._poses.switch(on=Sensor.MARKER in self._needs)

    def _make_goal(self) -> DockGoal:
        return DockGoal(self._make_plan(self._settings), self._settings.timeouts, time.monotonic())

    def _tell_progress(self, command: Command) -> None:
        if command.stage is Stage.CONTROLLING:
            self.get_logger().info("NOT CHARGING...", throttle_duration_sec=1.0)
        self._poses.publish(command, self._sensors.odometry_frame)

    def _tell_success(self) -> None:
        self.get_logger().info("CHARGING...")
        self.get_logger().info("Successfully connected to the charging dock!")


def _run(args: Sequence[str] | None) -> int:
    return serve(lambda battery, context: [DockServer(battery, context=context)], args)


def main(args: Sequence[str] | None = None) -> int:
    """Run the action server and the battery subscriber until SIGINT or SIGTERM.

    Returns:
        The exit code: 0 after a signal, 1 after a failure, 2 where a parameter is wrong.
    """
    return run_process(_run, args)


if __name__ == "__main__":
    sys.exit(main())
