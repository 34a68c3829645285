"""The program `docking_server`: docking and undocking in one process, one goal at a time over both."""

import sys
from collections.abc import Sequence

from rclpy.context import Context

from docking.battery import Battery
from docking.dock_server_node import DockServer
from docking.ros.goal_server import GoalServer
from docking.ros.helm import Helm
from docking.ros.process import run_process
from docking.ros.server_process import serve
from docking.undock_server_node import UndockServer


def make_servers(battery: Battery, context: Context) -> list[GoalServer]:
    """The docking and the undocking node, which share the robot.

    Args:
        battery: Where the battery subscriber puts its readings.
        context: The ROS context.
    """
    helm = Helm()
    return [
        DockServer(battery, helm=helm, context=context),
        UndockServer(battery, helm=helm, context=context),
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
