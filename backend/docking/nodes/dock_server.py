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
from docking.parameters import ControllerName, DockSettings
from docking.plans.registry import make_plan, sensors_of
from docking.ros.action_spec import ActionSpec
from docking.ros.node import FEEDBACK_PERIOD, ActionNode
from docking.ros.process import run_process
from docking.ros.sensors import Sensor
from docking.ros.server_process import serve


def _needs(settings: DockSettings) -> frozenset[Sensor]:
    needs = frozenset(map(Sensor, sensors_of(settings.controller)))
    watched = settings.collision.use_collision_detection and Sensor.ODOMETRY in needs
    return needs | {Sensor.SCAN} if watched else needs


def _control_period(settings: DockSettings) -> float:
    # `rotate` gives ten velocities a second, as the tutorial does.
    return FEEDBACK_PERIOD if settings.controller == ControllerName.ROTATE else settings.control_period


def docking_objective(settings: DockSettings, memory: DockMemory) -> Docking:
    """What a docking goal is for, by the parameters."""
    return Docking(
        settings.goal_timeouts,
        memory,
        charging=settings.charging,
        docking_threshold=settings.approach.docking_threshold,
        slowdown_radius=settings.approach.slowdown_radius,
        staging=settings.dock,
        dock_type=settings.dock_type,
        dock_name=settings.dock_name,
    )


def _make_goal(settings: DockSettings, memory: DockMemory, started_at: float) -> Goal:
    obstacles = watch_obstacles(settings, backward=settings.dock.backward)
    last, turn = memory.places.get(settings.dock_name), memory.turns.get(settings.dock_name, 0.0)
    settings = replace(settings, last_docked=None if last is None else settings.dock.base_link(last), last_turn=turn)
    return Goal(make_plan(settings), docking_objective(settings, memory), started_at, obstacles)


DOCK = ActionSpec(
    node_name="connect_to_charging_dock_action_server",
    action_name="connect_to_charging_dock",
    action_type=ConnectToChargingDock,
    purpose=DOCKING,
    settings=DockSettings,
    needs=_needs,
    control_period=_control_period,
    make_goal=_make_goal,
    progress={Stage.CONTROLLING: "NOT CHARGING..."},
    success=("CHARGING...", "Successfully connected to the charging dock!"),
    ends_with_charge=True,
    outline=lambda settings: settings.outline.points,
    at_dock=DockSettings.at_dock,
    dock_types=lambda settings: settings.database.dock_plugins,
    marker_tilt=lambda settings: settings.dock.tilt,
    navigates=lambda settings: settings.navigates,
    staging=lambda settings: settings.staging_goal,
    place=lambda settings: settings.place if Sensor.ODOMETRY in _needs(settings) else None,
    has_places=lambda settings: settings.database.has_poses and Sensor.ODOMETRY in _needs(settings),
)


def _run(args: Sequence[str] | None) -> int:
    return serve(lambda battery, context: [ActionNode(DOCK, battery, context=context)], args)


def main(args: Sequence[str] | None = None) -> int:
    """Run the action server and the battery subscriber until SIGINT or SIGTERM.

    Returns:
        The exit code: 0 after a signal, 1 after a failure, 2 where a parameter is wrong.
    """
    return run_process(_run, args)


if __name__ == "__main__":
    sys.exit(main())
