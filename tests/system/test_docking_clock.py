"""Docking by a simulated clock: at half speed, and while it stands still."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

from robot_io.halt import LONGEST
from tests.support.docking import PATIENT, SUCCEEDED, Reports, Wheels, send_dock_goal, watch_wheels
from tests.support.observer import Observer
from tests.support.processes import ForkedProcess, ros_environment
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
