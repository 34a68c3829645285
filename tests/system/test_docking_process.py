"""The docking action server as the process that users start: signals, command line, `ros2 run`."""

import os
import signal
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.support.docking import ABORTED, LOW, SUCCEEDED, Reports, battery_state, send_dock_goal, watch_wheels
from tests.support.observer import Observer
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

SERVER = "connect_to_charging_dock_server"
# A base that listens best-effort may miss one: ten are published in half a second, on a machine that has the time.
ZEROS = 5


@pytest.mark.parametrize(
    "signals", [[signal.SIGTERM], [signal.SIGHUP], [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGINT]]
)
def test_a_signal_in_the_middle_of_a_goal_stops_the_robot(
    domain: int, observer: Observer, signals: list[signal.Signals]
) -> None:
    with Process(SERVER, env=ros_environment(domain)) as server:
        wheels = watch_wheels(observer)
        reports = Reports(observer)
        with observer.publishing(LOW, "battery_status"):
            goal = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            for number in signals:
                server.send_signal(number)
                time.sleep(0.05)
            answer = goal.result()
            assert server.wait() == 0
        assert answer.status == ABORTED
        assert wheels.zeros >= ZEROS
        reports.wait_for(goal_id=goal.goal_id, stage="ABORTED", error_code="SHUTTING_DOWN")
        assert "Traceback" not in server.output


def test_a_signal_right_after_a_freeze_stops_the_robots(domain: int, observer: Observer) -> None:
    """The kernel hands such a signal to any thread of the process."""
    with ExitStack() as stack:
        robots = [f"/robot{number}" for number in range(3)]
        servers = [
            stack.enter_context(Process(SERVER, "--ros-args", "-r", f"__ns:={robot}", env=ros_environment(domain)))
            for robot in robots
        ]
        wheels = [watch_wheels(observer, f"{robot}/cmd_vel") for robot in robots]
        for robot in robots:
            stack.enter_context(observer.publishing(LOW, f"{robot}/battery_status"))
            send_dock_goal(observer, action=f"{robot}/connect_to_charging_dock")
        wait_until(lambda: all(one.moving for one in wheels), "moves")
        for server in servers:
            server.send_signal(signal.SIGSTOP)
        for server in servers:
            server.send_signal(signal.SIGCONT)
            server.send_signal(signal.SIGTERM)
        assert [server.wait() for server in servers] == [0, 0, 0]
        wait_until(lambda: all(one.zeros >= ZEROS for one in wheels), "zero velocity, several times")


DRIVES_AND_BREAKS = """
import sys
from docking.nodes import dock_server
from docking.ros.sensors import Sensors
steps = iter(range(5))
observe = Sensors.observe
Sensors.observe = lambda *args: observe(*args) if next(steps, None) is not None else sys.exit("broken")
sys.exit(dock_server.main())
"""


def test_an_exception_that_ends_the_process_stops_the_robot(domain: int, observer: Observer) -> None:
    with Process(sys.executable, "-c", DRIVES_AND_BREAKS, env=ros_environment(domain)) as server:
        wheels = watch_wheels(observer)
        with observer.publishing(LOW, "battery_status"):
            send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            assert server.wait() == 1
        wait_until(lambda: wheels.zeros >= ZEROS, "zero velocity, several times")


DRIVES_AND_HANGS = """
import sys, time
from docking.nodes import dock_server
from docking.behaviors.turns import Rotate
steps = iter(range(5))
step = Rotate.step
Rotate.step = lambda *args: step(*args) if next(steps, None) is not None else time.sleep(600)
sys.exit(dock_server.main())
"""


def test_the_watchdog_stops_the_robot_of_a_process_that_hangs(domain: int, observer: Observer) -> None:
    with Process(sys.executable, "-c", DRIVES_AND_HANGS, env=ros_environment(domain)) as server:
        wheels = watch_wheels(observer)
        with observer.publishing(LOW, "battery_status"):
            send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            wait_until(lambda: wheels.standing, "zero velocity, from nobody but the watchdog", timeout=3.0)
            assert server.running
            server.send_signal(signal.SIGTERM)
            assert server.wait() == 1


HANGING_CONTROLLER = """
import sys, time
from docking.nodes import dock_server
from docking.behaviors.turns import Rotate
Rotate.step = lambda self, observation, dt: time.sleep(600)
sys.exit(dock_server.main())
"""


def test_a_callback_that_hangs_cannot_keep_the_process(domain: int, observer: Observer) -> None:
    with Process(sys.executable, "-c", HANGING_CONTROLLER, env=ros_environment(domain)) as server:
        wheels = watch_wheels(observer)
        with observer.publishing(LOW, "battery_status"):
            send_dock_goal(observer)
            server.wait_for("Executing goal...")
            server.send_signal(signal.SIGTERM)
            assert server.wait() == 1
        wait_until(lambda: wheels.zeros >= ZEROS, "zero velocity, several times")


HANGING_MIDDLEWARE = """
import sys, time
from docking.nodes import dock_server
from docking.ros import node, process, server_process
server_process.EXIT_TIMEOUT = 2.0
node.ActionNode.destroy_node = lambda self: time.sleep(600)
process.StopSignals.wait = lambda self: 1
sys.exit(dock_server.main())
"""


def test_a_middleware_that_hangs_cannot_keep_the_process(domain: int) -> None:
    with Process(sys.executable, "-c", HANGING_MIDDLEWARE, env=ros_environment(domain)) as server:
        assert server.wait() == 1
        assert "Timeout (0:00:02)!" in server.output
        assert "in <lambda>" in server.output


def test_names_namespaces_and_parameters_come_from_the_command_line(domain: int, observer: Observer) -> None:
    arguments = (
        *("-r", "__ns:=/robot1"),
        *("-r", "cmd_vel:=wheels/cmd_vel"),
        *("-p", "rotate_speed:=-0.3"),
        *("-p", "qos_overrides./robot1/wheels/cmd_vel.publisher.depth:=3"),
    )
    with ForkedProcess(SERVER, "--ros-args", *arguments, env=ros_environment(domain)):
        wheels = watch_wheels(observer, "/robot1/wheels/cmd_vel")
        reports = Reports(observer)
        with observer.publishing(LOW, "/robot1/battery_status"):
            goal = send_dock_goal(observer, action="/robot1/connect_to_charging_dock")
            wait_until(lambda: wheels.moving, "a move")
        assert wheels.messages[-1].angular.z == -0.3
        observer.publish(battery_state(1), "/robot1/battery_status")
        assert goal.result().status == SUCCEEDED
        report = reports.wait_for(goal_id=goal.goal_id, stage="SUCCEEDED")
        assert report["name"] == "robot1/connect_to_charging_dock_action_server: connect_to_charging_dock"


def test_nodes_are_not_renamed_alike(domain: int) -> None:
    with ForkedProcess(SERVER, "--ros-args", "-r", "__node:=x", env=ros_environment(domain)) as server:
        assert server.wait() == 2
        assert "-r connect_to_charging_dock_action_server:__node:=…" in server.own_lines[-1]


def test_one_node_is_renamed_and_parameters_come_from_a_file(domain: int, observer: Observer, tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(
        "/**:\n  ros__parameters:\n    rotate_speed: -0.3\ndocker:\n  ros__parameters:\n    goal_policy: preempt\n"
    )
    arguments = ("-r", "connect_to_charging_dock_action_server:__node:=docker", "--params-file", str(file))
    with ForkedProcess(SERVER, "--ros-args", *arguments, env=ros_environment(domain)):
        wheels = watch_wheels(observer)
        wait_until(lambda: {"docker", "battery_state_subscriber"} <= set(observer.node.get_node_names()), "the nodes")
        with observer.publishing(LOW, "battery_status"):
            first = send_dock_goal(observer)
            wait_until(lambda: wheels.moving, "a move")
            assert wheels.messages[-1].angular.z == -0.3
            assert send_dock_goal(observer).accepted
            assert first.result().status == ABORTED


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("-p", "goal_timeout:=-4.0"), "goal_timeout out of range"),
        (("-p", "goal_timeout:=4"), "expecting type 'DOUBLE'"),
        (("-p", "goal_policy:=queue"), "must be one of: reject, preempt"),
        (("-p", "footprint:='[[0.2, 0.1], [0.2, -0.1]]'"), "footprint has 2 points, but must have 3 to 100"),
        (("-p", "footprint:='0.2'"), "footprint must be a list of points"),
        (("-p", "robot_radius:=0.0"), "robot_radius out of range"),
        (("-p", "controller:=magic"), "must be one of: rotate, dock_pose, infrared"),
        (("-p", "battery_stale_after:=90.0"), "must not be below battery_stale_after"),
        (("-p", "controller:=dock_pose", "-p", "retry_timeout:=2.0"), "backwards at 0.156 m/s"),
        (("--no-such-argument",), "wrong ROS arguments"),
    ],
)
def test_a_wrong_command_line_is_refused_in_one_line(domain: int, arguments: tuple[str, ...], complaint: str) -> None:
    with ForkedProcess(SERVER, "--ros-args", *arguments, env=ros_environment(domain)) as server:
        assert server.wait() == 2
        assert complaint in server.output
        assert len(server.own_lines) == 1


def test_ros_that_does_not_start_is_said_in_one_sentence(domain: int) -> None:
    with ForkedProcess(SERVER, env=ros_environment(domain, ROS_STATIC_PEERS="no.such.host.invalid")) as server:
        assert server.wait() == 2
        assert "error: ROS does not start: error creating node: Unable to resolve peer" in server.output
        assert "Traceback" not in server.output


def test_a_frozen_time_changes_nothing(domain: int, observer: Observer) -> None:
    """With use_sim_time and no /clock, ROS time stands still for ever."""
    with ForkedProcess(SERVER, "--ros-args", "-p", "use_sim_time:=true", env=ros_environment(domain)):
        wheels = watch_wheels(observer)
        with observer.publishing(LOW, "battery_status"):
            goal = send_dock_goal(observer)
            wait_until(lambda: len(wheels.messages) > 3, "moves")
            assert goal.cancel()


@pytest.mark.parametrize(
    "name",
    [
        SERVER,
        "connect_to_charging_dock_client",
        "disconnect_from_charging_dock_client",
        "docking_server",
        "dock_simulator",
        "docking_replay",
        "fibonacci_action_server",
        "fibonacci_action_client",
    ],
)
def test_ros2_run_finds_each_program(name: str) -> None:
    """`ros2 run` looks for the package in the ament index and for an executable in lib/<package>."""
    prefix = Path(sys.prefix)
    assert (prefix / "share/ament_index/resource_index/packages/action_tutorials_py").is_file()
    assert (prefix / "share/action_tutorials_py/package.xml").is_file()
    assert os.access(prefix / "lib/action_tutorials_py" / name, os.X_OK)
