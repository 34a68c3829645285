"""The node `disconnect_from_charging_dock_action_server`: drives the robot off its dock."""

from dataclasses import replace

from action_tutorials_interfaces.action import DisconnectFromChargingDock
from docking.core.errors import Stage
from docking.goal.admission import UNDOCKING
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.obstacle_watch import watch_obstacles
from docking.goal.undock import Undocking
from docking.parameters import ChargingSource, UndockSettings
from docking.parameters.timeouts import at_least
from docking.plans.undock import UndockPlan
from docking.ros.robot_action import RobotAction
from docking.ros.sensors import Sensor


class UndockAction(RobotAction[UndockSettings]):
    """Undocking."""

    node_name = "disconnect_from_charging_dock_action_server"
    action_name = "disconnect_from_charging_dock"
    action_type = DisconnectFromChargingDock
    purpose = UNDOCKING
    settings_type = UndockSettings
    progress = (Stage.UNDOCKING, "BACKING OUT...")
    success = ("NOT CHARGING...", "Successfully disconnected from the charging dock!")

    def needs(self, settings: UndockSettings) -> frozenset[Sensor]:
        """Odometry, and the laser scan where obstacles are watched."""
        watched = settings.collision.use_collision_detection
        return frozenset({Sensor.ODOMETRY, Sensor.SCAN} if watched else {Sensor.ODOMETRY})

    def make_goal(self, settings: UndockSettings, memory: DockMemory, started_at: float) -> Goal:
        """An undocking goal that backs out as far as the last dock's staging pose is away."""
        charging, assume_docked = settings.charging, settings.assume_docked
        if not memory.charges:
            charging = replace(charging, charging_source=ChargingSource.NONE)
        staging = memory.staging or settings.staging
        way, motion = staging.distance, settings.motion
        timeout = at_least(settings.timeouts.undocking_timeout, way / motion.v_linear_back)
        objective = Undocking(
            replace(settings.timeouts, undocking_timeout=timeout),
            memory,
            charging=charging,
            assume_docked=assume_docked,
            slowest=way / motion.v_linear_min,
        )
        plan = UndockPlan(way, motion, forwards=staging.backward)
        return Goal(plan, objective, started_at, watch_obstacles(settings))
