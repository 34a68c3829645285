"""The node `disconnect_from_charging_dock_action_server`: backs the robot out until its battery no longer charges."""

from action_tutorials_interfaces.action import DisconnectFromChargingDock
from docking.core.errors import Stage
from docking.goal.admission import UNDOCKING
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.undock import Undocking
from docking.parameters import UndockSettings
from docking.plans.undock import UndockPlan
from docking.ros.node import ActionSpec
from docking.ros.sensors import Sensor


def _make_goal(settings: UndockSettings, memory: DockMemory, started_at: float) -> Goal:
    objective = Undocking(settings.timeouts, memory, assume_docked=settings.assume_docked)
    return Goal(UndockPlan(settings.staging.distance, settings.motion), objective, started_at)


UNDOCK = ActionSpec(
    node_name="disconnect_from_charging_dock_action_server",
    action_name="disconnect_from_charging_dock",
    action_type=DisconnectFromChargingDock,
    purpose=UNDOCKING,
    settings=UndockSettings,
    needs=lambda settings: frozenset({Sensor.ODOMETRY}),
    control_period=lambda settings: settings.control_period,
    make_goal=_make_goal,
    progress={Stage.UNDOCKING: "BACKING OUT..."},
    success=("NOT CHARGING...", "Successfully disconnected from the charging dock!"),
)
