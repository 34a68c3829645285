"""A process of servers that drive one robot, with the battery subscriber they need."""

import faulthandler
import time
from collections.abc import Callable, Sequence
from concurrent import futures
from contextlib import ExitStack
from functools import partial
from typing import Any

from rclpy.context import Context
from rclpy.node import Node

from docking.core.battery import Battery
from docking.ros.battery_subscriber import BatteryStateSubscriber
from docking.ros.given import given_to
from docking.ros.node import ActionNode
from docking.ros.process import Spinner, StopSignals, ros_context, run_process
from robot_io.halt import PERIOD

CLOSE_TIMEOUT = 0.8
"""Seconds in which goals must be ended; a callback that hangs gets no more."""
LINGER = 0.5
"""Seconds in which results go out."""
HALT_TIMEOUT = 2.0
"""Seconds in which the robot has to stand, by its odometry if it has one, before the process leaves it."""
EXIT_TIMEOUT = 15.0
"""Seconds after the signal in which the process must be gone; then it ends itself and says what it waited for."""


MakeServers = Callable[[Battery, Context], Sequence[ActionNode[Any]]]
MakeNodes = Callable[[Context], Sequence[Node]]


def serve(make_servers: MakeServers, args: Sequence[str] | None, make_others: MakeNodes = lambda _: ()) -> int:
    """Run servers and a battery subscriber until a signal ends them.

    Args:
        make_servers: Makes the servers.
        args: The command line with its `--ros-args`; None is that of the process.
        make_others: Makes other nodes that run in the same process, in a thread of their own.

    Returns:
        The exit code: 0 after a signal, 1 after a failure, 2 where the command line or a parameter is wrong.
    """
    return run_process(partial(_serve, make_servers, make_others), args)


def _serve(make_servers: MakeServers, make_others: MakeNodes, args: Sequence[str] | None) -> int:
    signals = StopSignals()
    with ros_context(args) as context:
        battery = Battery()
        servers = make_servers(battery, context)
        subscriber = BatteryStateSubscriber(battery, context=context)
        others = make_others(context)
        nodes: list[Any] = [*servers, subscriber, *others]
        if len({node.get_fully_qualified_name() for node in nodes}) < len(nodes):
            raise ValueError(
                "-r __node:=… renames all nodes of this program alike. Name the node that is meant:"
                f" -r {servers[0].own_name}:__node:=…"
            )
        given_to(context).warn(nodes)
        with ExitStack() as stack:
            # A wait costs as much as there is to wait for, and others, such as a simulator, wake up often.
            groups = [group for group in (others, [*servers, subscriber]) if group]
            spinners = [stack.enter_context(Spinner(context, group, on_failure=signals.wake)) for group in groups]
            try:
                signals.wait()
            finally:
                faulthandler.dump_traceback_later(EXIT_TIMEOUT, exit=True)  # needs neither the lock of Python nor DDS
                _close(servers, spinners[-1])
        return 0 if all(spinner.failure is None for spinner in spinners) else 1


def _close(servers: Sequence[ActionNode[Any]], spinner: Spinner) -> None:
    """End the goals, and stay until the robot stands."""
    closing = [spinner.call(server.close) for server in servers]
    if futures.wait(closing, PERIOD).not_done:  # a callback hangs, or takes long
        for server in servers:
            server.hold_still()
        futures.wait(closing, CLOSE_TIMEOUT)
    began = time.monotonic()
    while (took := time.monotonic() - began) < LINGER or (_halting(servers) and took < HALT_TIMEOUT):
        time.sleep(PERIOD)
    for closed in closing:
        if closed.done():
            closed.result()


def _halting(servers: Sequence[ActionNode[Any]]) -> bool:
    return any(server.halting for server in servers)
