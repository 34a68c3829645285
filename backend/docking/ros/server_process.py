"""A process of servers that drive one robot, with the battery subscriber they need."""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import TimeoutError as CallTimeoutError

from rclpy.context import Context

from docking.battery import Battery
from docking.battery_node import BatteryStateSubscriber
from docking.ros.goal_server import GoalServer
from docking.ros.process import Spinner, StopSignals, ros_context

CLOSE_TIMEOUT = 0.8
LINGER = 0.2


def serve(make_servers: Callable[[Battery, Context], Sequence[GoalServer]], args: Sequence[str] | None) -> int:
    """Run servers and a battery subscriber until SIGINT or SIGTERM.

    Args:
        make_servers: Makes the servers.
        args: The command line with its `--ros-args`; None is that of the process.

    Returns:
        The exit code: 0 after a signal, 1 after a failure.
    """
    signals = StopSignals()
    with ros_context(args) as context:
        battery = Battery()
        servers = make_servers(battery, context)
        subscriber = BatteryStateSubscriber(battery, context=context)
        with Spinner(context, [*servers, subscriber], on_failure=signals.wake) as spinner:
            signals.wait()
            closed = [spinner.call(server.close) for server in servers]
            deadline = time.monotonic() + CLOSE_TIMEOUT
            for server, closing in zip(servers, closed, strict=True):
                try:
                    closing.result(max(0.0, deadline - time.monotonic()))
                except CallTimeoutError:  # a callback hangs
                    server.stop_robot()
            time.sleep(LINGER)
        return 0 if spinner.failure is None else 1
