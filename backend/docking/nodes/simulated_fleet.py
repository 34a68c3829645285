"""The program `python -m docking.nodes.simulated_fleet 5`: simulated robots /robot1, /robot2, … in one hall.

Each has a docking server, which knows all docks. Each robot is one process and one DDS participant: discovery that is
limited to a machine finds some thirty of them. They are forks of a process that has imported everything, so that a
robot starts at once and takes little memory.
"""

import argparse
import gc
import multiprocessing
import signal
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from multiprocessing.connection import wait
from multiprocessing.context import ForkProcess

from rcl_interfaces.msg import ParameterEvent
from rclpy.context import Context
from rclpy.logging import get_logger
from rclpy.type_support import check_for_type_support

from docking.nodes.docking_server import make_servers
from docking.nodes.simulator import DockSimulator
from docking.ros.server_process import serve
from docking.simulation.hall import Hall
from robot_io.children import MAX_ROBOTS, end_with_parent

CHECK_PERIOD = 0.5
"""Seconds between two checks whether a signal has come or a robot has to be started again."""

_context = multiprocessing.get_context("fork")


def server_arguments(hall: Hall, robot: int) -> list[str]:
    """Return the ROS arguments of a robot's docking servers.

    Args:
        hall: Where it is.
        robot: Its number, from 1.
    """
    home = hall.home(robot)
    docks = sorted(range(1, hall.docks + 1), key=lambda dock: dock != home)  # the first one is the default
    parameters: dict[str, object] = {
        "controller": "dock_pose",
        "use_sim_time": "true",
        "use_collision_detection": "true",
        "docks": f"[{', '.join(hall.dock_names[dock - 1] for dock in docks)}]",
    }
    for dock, name in enumerate(hall.dock_names, 1):
        pose = hall.docked(dock)
        parameters[f"{name}.pose"] = [pose.x, pose.y, pose.theta]
    return _ros_arguments(robot, parameters)


def simulator_arguments(hall: Hall, robot: int) -> list[str]:
    """Return the ROS arguments of a robot's simulator: `docks` is a parameter of both.

    Args:
        hall: Where it is.
        robot: Its number, from 1.
    """
    start = hall.start(robot)
    parameters: dict[str, object] = {
        "seed": robot,
        "publish_clock": "true",
        "start_x": start.x,
        "start_y": start.y,
        "start_theta": start.theta,
        "home_dock": hall.home(robot),
        "room_extension": hall.room_extension,
        "shares_room": "true" if hall.robots > 1 else "false",
    }
    if hall.docks > 1:
        parameters["docks"] = list(hall.dock_places[1:])
    # One map for all: the gateway and RViz read it once.
    return [*_ros_arguments(robot, parameters), "-r", "map:=/map"]


def _ros_arguments(robot: int, parameters: Mapping[str, object]) -> list[str]:
    given = (text for name, value in parameters.items() for text in ("-p", f"{name}:={value}"))
    return ["--ros-args", "-r", f"__ns:=/robot{robot}", "-r", "/clock:=clock", *given]


def _run(hall: Hall, robot: int) -> None:
    end_with_parent()
    sys.exit(serve(make_servers, server_arguments(hall, robot), partial(_simulate, hall, robot)))


def _simulate(hall: Hall, robot: int, context: Context) -> list[DockSimulator]:
    arguments = simulator_arguments(hall, robot)
    simulator = DockSimulator(context=context, cli_args=arguments, use_global_arguments=False)
    simulator.get_logger().info("Simulating a robot and its dock...")
    return [simulator]


def _start(hall: Hall, robot: int) -> ForkProcess:
    process = _context.Process(target=_run, args=(hall, robot))
    process.start()
    return process


def main(args: Sequence[str] | None = None) -> int:
    """Run the robots until SIGINT or SIGTERM. One that ends is started again.

    Args:
        args: The number of robots, and `--docks` with that of docks; None is the command line of the process.

    Returns:
        The exit code.
    """
    parser = argparse.ArgumentParser(description="Simulated robots and their docking servers.")
    parser.add_argument("robots", type=int, choices=range(1, MAX_ROBOTS + 1), metavar=f"1-{MAX_ROBOTS}")
    parser.add_argument("--docks", type=int, help="number of docks; one for each robot by default, and at most")
    given = parser.parse_args(args)
    count, docks = given.robots, given.robots if given.docks is None else given.docks
    if not 1 <= docks <= count:
        parser.error(f"--docks is {docks}, but must be from 1 to the number of robots, {count}")
    hall = Hall(count, docks)
    # What the first message and the first log line import and find: a quarter of the work of each start.
    check_for_type_support(ParameterEvent)
    get_logger("simulated_fleet").info(f"Starting {count} simulated robots...")
    gc.collect()
    gc.freeze()  # what is not touched is not copied
    robots = {number: _start(hall, number) for number in range(1, count + 1)}
    for stop in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(stop, lambda *_: sys.exit())  # in this process: the robots have their own
    try:
        while True:
            wait([robot.sentinel for robot in robots.values()], CHECK_PERIOD)
            for number, robot in robots.items():
                if robot.exitcode is not None:
                    print(f"/robot{number} ended ({robot.exitcode}); starting it again", file=sys.stderr)  # noqa: T201
                    robots[number] = _start(hall, number)
    finally:
        for robot in robots.values():
            robot.terminate()
        for robot in robots.values():
            robot.join()


if __name__ == "__main__":
    sys.exit(main())
