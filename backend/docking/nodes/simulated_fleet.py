"""The program `python -m docking.nodes.simulated_fleet 5`: simulated robots /robot1, /robot2, … with docking servers.

Each robot is one process and one DDS participant: discovery that is limited to a machine finds some thirty of them.
They are forks of a process that has imported everything, so that a robot starts at once and takes little memory.
"""

import argparse
import gc
import multiprocessing
import signal
import sys
from collections.abc import Sequence
from multiprocessing.connection import wait
from multiprocessing.context import ForkProcess

from rcl_interfaces.msg import ParameterEvent
from rclpy.context import Context
from rclpy.logging import get_logger
from rclpy.type_support import check_for_type_support

from docking.nodes.docking_server import make_servers
from docking.nodes.simulator import DockSimulator
from docking.ros.server_process import serve
from robot_io.children import MAX_ROBOTS, end_with_parent

CHECK_PERIOD = 0.5
"""Seconds between two checks whether a signal has come or a robot has to be started again."""

_context = multiprocessing.get_context("fork")


def _run(number: int) -> None:
    end_with_parent()
    parameters = ("-p", "controller:=dock_pose", "-p", f"seed:={number}")
    args = ("--ros-args", "-r", f"__ns:=/robot{number}", *parameters)
    sys.exit(serve(make_servers, args, _simulate))


def _simulate(context: Context) -> list[DockSimulator]:
    simulator = DockSimulator(context=context)
    simulator.get_logger().info("Simulating a robot and its dock...")
    return [simulator]


def _start(number: int) -> ForkProcess:
    process = _context.Process(target=_run, args=(number,))
    process.start()
    return process


def main(args: Sequence[str] | None = None) -> int:
    """Run the robots until SIGINT or SIGTERM. One that ends is started again.

    Args:
        args: The number of robots; None is the command line of the process.

    Returns:
        The exit code.
    """
    parser = argparse.ArgumentParser(description="Simulated robots and their docking servers.")
    parser.add_argument("robots", type=int, choices=range(1, MAX_ROBOTS + 1), metavar=f"1-{MAX_ROBOTS}")
    count = parser.parse_args(args).robots
    # What the first message and the first log line import and find: a quarter of the work of each start.
    check_for_type_support(ParameterEvent)
    get_logger("simulated_fleet").info(f"Starting {count} simulated robots...")
    gc.collect()
    gc.freeze()  # what is not touched is not copied
    robots = {number: _start(number) for number in range(1, count + 1)}
    for stop in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(stop, lambda *_: sys.exit())  # in this process: the robots have their own
    try:
        while True:
            wait([robot.sentinel for robot in robots.values()], CHECK_PERIOD)
            for number, robot in robots.items():
                if robot.exitcode is not None:
                    print(f"/robot{number} ended ({robot.exitcode}); starting it again", file=sys.stderr)  # noqa: T201
                    robots[number] = _start(number)
    finally:
        for robot in robots.values():
            robot.terminate()
        for robot in robots.values():
            robot.join()


if __name__ == "__main__":
    sys.exit(main())
