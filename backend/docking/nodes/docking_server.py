"""The program `docking_server`: docking and undocking in one process, one goal at a time over both."""

import sys
from collections.abc import Sequence
from typing import Any

from rclpy.context import Context

from docking.core.battery import Battery
from docking.nodes.dock_server import DockAction
from docking.nodes.undock_server import UndockAction
from docking.parameters import ControllerName, DockSettings, UndockSettings
from docking.ros.active_goal import ActiveGoal
from docking.ros.node import ActionNode
from docking.ros.server_process import serve


def make_servers(battery: Battery, context: Context) -> list[ActionNode[Any]]:
    """The docking and the undocking node, which share the robot.

    Args:
        battery: Where the battery subscriber puts its readings.
        context: The ROS context.
    """
    active_goal = ActiveGoal()
    dock = ActionNode(DockAction(), battery, active_goal=active_goal, context=context)
    undock = ActionNode(UndockAction(), battery, active_goal=active_goal, context=context)
    if sentence := compare_directions(dock.settings, undock.settings):
        undock.get_logger().warning(sentence)
    return [dock, undock]


def compare_directions(docking: DockSettings, undocking: UndockSettings) -> str | None:
    """Return why a robot that is on a dock at the start may leave it the wrong way, as a sentence; None if it does not.

    Args:
        docking: The parameters of the docking node.
        undocking: Those of the undocking node, which knows the dock only after a goal has docked the robot.
    """
    directions = {dock.dock_direction for dock in docking.database.types.values() or [docking.dock]}
    own = undocking.staging.dock_direction
    if docking.controller == ControllerName.ROTATE or directions == {own}:
        return None
    others = " and ".join(sorted(directions))
    return (
        f"The robot docks {others}, but until a goal has docked it, it undocks as if it had docked {own}: set"
        f" dock_direction of {UndockAction.node_name}"
    )


def main(args: Sequence[str] | None = None) -> int:
    """Run both action servers and the battery subscriber until SIGINT or SIGTERM; see `serve`."""
    return serve(make_servers, args)


if __name__ == "__main__":
    sys.exit(main())
