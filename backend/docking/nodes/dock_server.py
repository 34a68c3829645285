"""The node `connect_to_charging_dock_action_server`: drives the robot until its battery is charging."""

import sys
from collections.abc import Sequence
from dataclasses import replace

from action_tutorials_interfaces.action import ConnectToChargingDock
from docking.core.errors import Stage
from docking.goal.admission import DOCKING
from docking.goal.dock import Docking
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.obstacle_watch import watch_obstacles
from docking.parameters import DockSettings
from docking.plans.registry import make_plan, sensors_of
from docking.ros.node import ActionNode
from docking.ros.robot_action import RobotAction
from docking.ros.sensors import Sensor
from docking.ros.server_process import serve


def docking_objective(settings: DockSettings, memory: DockMemory) -> Docking:
    """Return the objective of a docking goal, from the parameters."""
    return Docking(
        settings.goal_timeouts,
        memory,
        charging=settings.charging,
        docking_threshold=settings.approach.docking_threshold,
        slowdown_radius=settings.approach.slowdown_radius,
        recovery=settings.recovery,
        staging=settings.dock,
        dock_type=settings.dock_type,
        dock_name=settings.dock_name,
        search=settings.search,
    )


class DockAction(RobotAction[DockSettings]):
    """Docking."""

    node_name = "connect_to_charging_dock_action_server"
    action_name = "connect_to_charging_dock"
    action_type = ConnectToChargingDock
    purpose = DOCKING
    settings_type = DockSettings
    progress = (Stage.CONTROLLING, "NOT CHARGING...")
    success = ("CHARGING...", "Successfully connected to the charging dock!")
    ends_with_charge = True
    shows_footprint = True
    knows_docks = True

    def needs(self, settings: DockSettings) -> frozenset[Sensor]:
        """Return the sensors of the controller, and the laser scan where obstacles are watched."""
        needs = frozenset(map(Sensor, sensors_of(settings)))
        watched = settings.collision.use_collision_detection and Sensor.ODOMETRY in needs
        needs |= {Sensor.JOINTS} if settings.joints and Sensor.ODOMETRY in needs else set()
        return needs | {Sensor.SCAN} if watched else needs

    def make_goal(self, settings: DockSettings, memory: DockMemory, started_at: float) -> Goal:
        """A docking goal that knows how the robot was docked last."""
        obstacles = watch_obstacles(settings, backward=settings.dock.backward)
        last = memory.last_at(settings.dock_name, settings.dock)
        place = None if last.place is None else settings.dock.base_link(last.place)
        settings = replace(settings, last_docked=place, last_turn=last.turn, last_camera=last.camera)
        return Goal(make_plan(settings), docking_objective(settings, memory), started_at, obstacles)

    def uses_frames(self, settings: DockSettings) -> bool:
        """Also to navigate, and to look for a dock where the database has it."""
        has_places = settings.database.has_poses or settings.place is not None
        located = has_places and Sensor.ODOMETRY in self.needs(settings)
        return super().uses_frames(settings) or settings.navigates or located


def main(args: Sequence[str] | None = None) -> int:
    """Run the action server and the battery subscriber until SIGINT or SIGTERM; see `serve`."""
    return serve(lambda battery, context: [ActionNode(DockAction(), battery, context=context)], args)


if __name__ == "__main__":
    sys.exit(main())
