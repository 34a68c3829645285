"""The program `docking_server`: docking and undocking in one process, one goal at a time over both."""

import sys
from collections.abc import Sequence
from typing import Any

from rclpy.context import Context

from docking.core.battery import Battery
from docking.nodes.dock_server import DOCK
from docking.nodes.undock_server import UNDOCK
from docking.ros.active_goal import ActiveGoal
from docking.ros.node import ActionNode
from docking.ros.process import run_process
from docking.ros.server_process import serve


def make_servers(battery: Battery, context: Context) -> list[ActionNode[Any]]:
    """The docking and the undocking node, which share the robot.

    Args:
        battery: Where the battery subscriber puts its readings.
        context: The ROS context.
    """
    active_goal = ActiveGoal()
    return [
        ActionNode(DOCK, battery, active_goal=active_goal, context=context),
        ActionNode(UNDOCK, battery, active_goal=active_goal, context=context),
    ]


def _run(args: Sequence[str] | None) -> int:
    return serve(make_servers, args)


def main(args: Sequence[str] | None = None) -> int:
    """Run both action servers and the battery subscriber until SIGINT or SIGTERM.

    Returns:
        The exit code: 0 after a signal, 1 after a failure, 2 where a parameter is wrong.
    """
    return run_process(_run, args)


if __name__ == "__main__":
    sys.exit(main())
