"""Docking by a simulated clock: at half speed, while it stands still, and on a machine that is too slow."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState

from robot_io.halt import LONGEST
from tests.support.docking import PATIENT, SUCCEEDED, Reports, Wheels, battery_state, send_dock_goal, watch_wheels
from tests.support.observer import Observer
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

SPEED = 0.5


@dataclass
class SimulatedTime:
    """What is published on /clock."""

    seconds: float = 1000.0
    running: bool = True

    def pass_by(self, lapse: float) -> Clock:
        if self.running:
            self.seconds += SPEED * lapse
        message = Clock()
        message.clock.sec, message.clock.nanosec = int(self.seconds), int(self.seconds % 1.0 * 1e9)
        return message


@contextmanager
def simulated_time(observer: Observer) -> Iterator[SimulatedTime]:
    simulated, ticked_at = SimulatedTime(), [time.monotonic()]
    publisher = observer.call(lambda: observer.node.create_publisher(Clock, "/clock", 10))

    def tick() -> None:
        lapse, ticked_at[0] = time.monotonic() - ticked_at[0], time.monotonic()
        publisher.publish(simulated.pass_by(lapse))

    timer = observer.call(lambda: observer.node.create_timer(0.02, tick))
    try:
        yield simulated
    finally:
        observer.call(lambda: observer.node.destroy_timer(timer))


class SimulatorStatuses:
    """The values that the simulator publishes of itself."""

    def __init__(self, observer: Observer) -> None:
        self._heard = observer.record(DiagnosticArray, "/diagnostics")

    @property
    def last(self) -> dict[str, str]:
        """The newest; empty before the first."""
        found = (status for array in reversed(self._heard.messages) for status in array.status)
        status = next((each for each in found if each.name == "dock_simulator"), None)
        return {} if status is None else {value.key: value.value for value in status.values}


def is_silent(wheels: Wheels) -> bool:
    """Whether nothing is commanded for a second."""
    count = len(wheels.messages)
    time.sleep(1.0)
    return len(wheels.messages) == count


def test_the_servers_follow_a_simulated_clock(domain: int, observer: Observer) -> None:
    environment = ros_environment(domain)
    simulated = ("--ros-args", "-p", "use_sim_time:=true")
    start = ("-p", "start_x:=-1.0", "-p", "start_y:=0.1", "-p", "start_theta:=0.0")
    with (
        simulated_time(observer) as clock,
        ForkedProcess("dock_simulator", *simulated, "-p", f"real_time_factor:={SPEED}", *start, env=environment),
        ForkedProcess("docking_server", *simulated, "-p", "controller:=dock_pose", "-p", PATIENT, env=environment),
    ):
        wheels, reports = watch_wheels(observer), Reports(observer)
        truth = observer.record(Odometry, "ground_truth")
        wait_until(lambda: truth.messages, "the simulator")
        goal = send_dock_goal(observer)
        assert goal.accepted
        wait_until(lambda: wheels.moving, "a move")
        clock.running = False  # as when Gazebo is paused
        wait_until(lambda: wheels.standing, "zero velocity", timeout=5.0)
        stood = len(wheels.messages)
        # Odometry stands still with the clock, and still says that the robot moves.
        wait_until(lambda: is_silent(wheels), "an end of the zeros", timeout=LONGEST + 10.0)
        assert all(message == Twist() for message in wheels.messages[stood:])
        clock.running = True
        assert goal.result(timeout=120.0).status == SUCCEEDED
        report = reports.wait_for(goal_id=goal.goal_id, stage="SUCCEEDED")
        assert report["retries"] == "0"
        assert truth.messages[-1].header.stamp.sec < clock.seconds + 1.0


def test_a_goal_that_comes_before_the_clock_begins_with_it(domain: int, observer: Observer) -> None:
    """The clock begins at 1000 s, after a wait of far more than a battery may be silent."""
    simulated = ("--ros-args", "-p", "use_sim_time:=true", "-p", "controller:=rotate")
    with ForkedProcess("docking_server", *simulated, env=ros_environment(domain)):
        wheels, battery = watch_wheels(observer), "battery_status"
        goal = send_dock_goal(observer)
        assert goal.accepted
        time.sleep(1.0)
        assert not wheels.moving
        with simulated_time(observer):
            with observer.publishing(battery_state(BatteryState.POWER_SUPPLY_STATUS_DISCHARGING), battery):
                wait_until(lambda: wheels.moving, "a move")
            with observer.publishing(battery_state(BatteryState.POWER_SUPPLY_STATUS_CHARGING), battery):
                assert goal.result().status == SUCCEEDED


@contextmanager
def slow_machine(*processes: Process, stands: float = 0.3, runs: float = 0.1) -> Iterator[None]:
    """Let processes run for a part of the time only, all at once, as on a machine with too much to do."""
    ended = threading.Event()

    def freeze_and_thaw() -> None:
        while not ended.wait(runs):
            for number in (signal.SIGSTOP, signal.SIGCONT):
                for process in processes:
                    process.send_signal(number)
                ended.wait(stands if number == signal.SIGSTOP else 0.0)

    thread = threading.Thread(target=freeze_and_thaw)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def test_a_robot_docks_on_a_machine_that_is_too_slow(domain: int, observer: Observer) -> None:
    """The simulator's own clock slows down with everything else, and says so; then it is set to real time again."""
    environment = ros_environment(domain)
    start = ("-p", "start_x:=-1.0", "-p", "start_y:=0.1", "-p", "start_theta:=0.0")
    with (
        ForkedProcess(
            "dock_simulator", "--ros-args", "-p", "publish_clock:=true", *start, env=environment
        ) as simulator,
        ForkedProcess(
            "docking_server", "--ros-args", "-p", "use_sim_time:=true", "-p", "controller:=dock_pose", env=environment
        ) as server,
    ):
        truth, statuses = observer.record(Odometry, "ground_truth"), SimulatorStatuses(observer)
        wait_until(lambda: truth.messages, "the simulator")
        wait_until(lambda: statuses.last.get("too_slow") == "false", "a simulator that keeps up")
        with slow_machine(simulator, server, stands=0.6):
            goal = send_dock_goal(observer)
            assert goal.accepted
            wait_until(lambda: statuses.last.get("too_slow") == "true", "a simulator that says that it is too slow")
            assert float(statuses.last["real_time_factor"]) < 0.9
            result = goal.result(timeout=150.0)
            behind = time.time() - truth.messages[-1].header.stamp.sec
        assert result.status == SUCCEEDED, server.output
        assert "tries again" not in server.output, server.output
        assert behind > 2.0
        wait_until(lambda: time.time() - truth.messages[-1].header.stamp.sec < 1.5, "the clock is that of real time")
        wait_until(lambda: statuses.last.get("too_slow") == "false", "a simulator that keeps up again")
