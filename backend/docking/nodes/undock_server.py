"""The node `disconnect_from_charging_dock_action_server`: drives the robot off its dock."""

from action_tutorials_interfaces.action import DisconnectFromChargingDock
from docking.core.errors import Stage
from docking.goal.admission import UNDOCKING
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.obstacle_watch import watch_obstacles
from docking.goal.undock import Undocking
from docking.parameters import UndockSettings
from docking.plans.undock import UndockPlan
from docking.ros.action_spec import ActionSpec
from docking.ros.sensors import Sensor


def _needs(settings: UndockSettings) -> frozenset[Sensor]:
    watched = settings.collision.use_collision_detection
    return frozenset({Sensor.ODOMETRY, Sensor.SCAN} if watched else {Sensor.ODOMETRY})


def _make_goal(settings: UndockSettings, memory: DockMemory, started_at: float) -> Goal:
    objective = Undocking(settings.timeouts, memory, charging=settings.charging, assume_docked=settings.assume_docked)
    staging = memory.staging or settings.staging
    plan = UndockPlan(staging.distance, settings.motion, forwards=staging.backward)
    return Goal(plan, objective, started_at, watch_obstacles(settings))


UNDOCK = ActionSpec(
    node_name="disconnect_from_charging_dock_action_server",
    action_name="disconnect_from_charging_dock",
    action_type=DisconnectFromChargingDock,
    purpose=UNDOCKING,
    settings=UndockSettings,
    needs=_needs,
    control_period=lambda settings: settings.control_period,
    make_goal=_make_goal,
    progress={Stage.UNDOCKING: "BACKING OUT..."},
    success=("NOT CHARGING...", "Successfully disconnected from the charging dock!"),
)
