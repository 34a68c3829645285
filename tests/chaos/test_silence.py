"""A robot whose base has no command timeout stands still soon after the process that drives it has died or frozen.

Real processes: a gateway, a docking server and a simulated robot. One of the first two is killed or frozen at a random
moment of a goal, again and again; the simulator tells how far the robot truly goes on.
"""

import math
import os
import random
import signal
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from nav_msgs.msg import Odometry

from docking.core.geometry import Pose
from docking.nodes.simulator import LONGEST_LAPSE
from docking.ros.geometry import pose_from, pose_message, seconds_of
from tests.chaos.report import report
from tests.support.gateway import IMPATIENT, RunningGateway, running_gateway, running_program
from tests.support.observer import EVERYTHING, Observer
from tests.support.processes import Process
from tests.support.waiting import wait_until

MOMENTS = int(os.environ.get("CHAOS_MOMENTS", "6"))
SEED = int(os.environ.get("CHAOS_SEED", "1"))
pytestmark = [pytest.mark.ros, pytest.mark.timeout(7200)]

ALLOWED = 0.15
"""How far a robot may go on after a death, in m, and then it has to stop."""
DECELERATION = 1.0
"""Of the simulated robot, in m/s²."""
LONGEST_GOAL = 4.0
"""Seconds of a goal from which the moment is chosen; most are in its motion."""
SETTLED = 1.5
"""Seconds after a death in which the robot has to stand, and after which it must not move."""
KILL, FREEZE = signal.SIGKILL, signal.SIGSTOP


class Watcher:
    """Follows the true pose of the robot, and its commands."""

    def __init__(self, observer: Observer) -> None:
        self.pose, self.speed, self.way = Pose(), 0.0, 0.0
        self.commanded_at = self.stamp = self.lived = 0.0
        self._past: deque[tuple[float, float, float]] = deque(maxlen=1000)
        node = observer.node
        observer.call(lambda: node.create_subscription(Odometry, "ground_truth", self._see, EVERYTHING))
        observer.call(lambda: node.create_subscription(Twist, "cmd_vel", self._hear, EVERYTHING))
        self._seen = False

    def _see(self, message: Odometry) -> None:
        pose = pose_from(message.pose.pose)
        step = pose.distance_to(self.pose) if self._seen else 0.0
        self._seen, self.pose, self.speed = True, pose, abs(message.twist.twist.linear.x)
        if step < 0.1:  # else it was lifted
            self.way += step
        stamp = seconds_of(message.header.stamp)
        self.lived += min(LONGEST_LAPSE, stamp - self.stamp)
        self.stamp = stamp
        self._past.append((self.stamp, self.way, self.speed))

    def settle(self) -> None:
        """Wait until `SETTLED` seconds have passed for the simulated robot.

        Fast DDS may hold up the peers of a process that is killed for a second or two, and the simulation with them.
        """
        end = self.lived + SETTLED
        wait_until(lambda: self.lived >= end, "the pose after a death")

    def at(self, moment: float) -> tuple[float, float]:
        """The way, in m, and the speed, in m/s, at a moment of the system's clock: this process may lag behind."""
        return next(((way, speed) for at, way, speed in reversed(self._past) if at <= moment), (self.way, self.speed))

    def _hear(self, message: Twist) -> None:
        if message != Twist():
            self.commanded_at = time.monotonic()


class System:
    """The processes."""

    def __init__(self, domain: int, observer: Observer, stack: ExitStack) -> None:
        self._domain = domain
        self._observer = observer
        self._stack = stack
        stack.enter_context(
            running_program(domain, "dock_simulator", "-p", "cmd_vel_timeout:=0.0", "-p", "room:=false")
        )
        self.watcher = Watcher(observer)
        self.start_server()
        self.start_gateway()

    def start_server(self) -> None:
        self.server: Process = self._stack.enter_context(
            running_program(
                self._domain, "docking_server", "-p", "controller:=dock_pose", "-p", "odometry_timeout:=10.0"
            )
        )

    def start_gateway(self) -> None:
        self.gateway: RunningGateway = self._stack.enter_context(
            running_gateway(self._domain, allow_duplicate_servers="true", **IMPATIENT)
        )

    def place(self, pose: Pose) -> None:
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "world"
        message.pose.pose = pose_message(pose)

        def placed() -> bool:
            self._observer.publish(message, "initialpose")
            time.sleep(0.1)
            return self.watcher.pose.distance_to(pose) < 0.05

        wait_until(placed, "the robot at its place")

    def send_goal(self) -> str:
        def accepted() -> Any:
            answer = self.gateway.http.post("/dock")
            return answer.json() if answer.status_code == 202 else None

        goal_id: str = wait_until(accepted, "a goal that is accepted")["goal_id"]
        return goal_id


def bury(process: Process) -> None:
    process.send_signal(KILL)
    process.wait()


@pytest.fixture
def system(domain: int, observer: Observer) -> Iterator[System]:
    with ExitStack() as stack:
        yield System(domain, observer, stack)


def judge(watcher: Watcher, since: float, moment: str) -> tuple[float, list[str]]:
    """How far the robot went on since a moment of the system's clock, in m, and what was wrong."""
    watcher.settle()
    way, speed = watcher.at(since)
    went, limit = watcher.way - way, ALLOWED + speed * speed / (2.0 * DECELERATION)
    wrong = [f"{moment} at {speed:.2f} m/s: {went:.3f} m, more than {limit:.3f} m"] if went > limit else []
    if watcher.speed > 0.0:
        wrong.append(f"{moment}: still moves at {watcher.speed:.2f} m/s")
    return went, wrong


def server_dies(system: System, how: signal.Signals, moment: str) -> tuple[float, list[str]]:
    """How far the robot goes on, and what was wrong."""
    driven = time.monotonic() - system.watcher.commanded_at < 0.5
    died_at = time.time()
    system.server.send_signal(how)
    went, wrong = judge(system.watcher, died_at, moment)
    bury(system.server)
    system.start_server()
    return went if driven else math.nan, wrong


def gateway_dies(system: System, how: signal.Signals, moment: str) -> tuple[float, list[str]]:
    """The goal goes on, and the next gateway can cancel it."""
    system.gateway.process.send_signal(how)
    time.sleep(SETTLED)
    bury(system.gateway.process)
    system.start_gateway()
    wait_until(lambda: system.gateway.http.get("/readyz").json()["ready"], "a gateway that is ready")
    stopped_at = time.time()
    system.gateway.stop_once()
    _, wrong = judge(system.watcher, stopped_at, f"{moment}, canceled")
    return math.nan, wrong


DEATHS: list[tuple[str, Callable[[System, signal.Signals, str], tuple[float, list[str]]], signal.Signals]] = [
    ("docking server killed", server_dies, KILL),
    ("docking server frozen", server_dies, FREEZE),
    ("gateway killed", gateway_dies, KILL),
    ("gateway frozen", gateway_dies, FREEZE),
]


def test_a_robot_without_a_command_timeout_stands_still_after_any_death(system: System) -> None:
    chance = random.Random(SEED)
    ways: list[float] = []
    wrong: list[str] = []
    counts: dict[str, int] = dict.fromkeys((name for name, *_ in DEATHS), 0)
    for number in range(MOMENTS):
        began = time.monotonic()
        name, happens, how = DEATHS[number % 2 if number % 10 < 9 else 2 + number // 10 % 2]
        start = Pose(chance.uniform(-1.4, -0.8), chance.uniform(-0.2, 0.2), chance.uniform(-0.4, 0.4))
        system.place(start)
        system.send_goal()
        after = chance.uniform(0.0, LONGEST_GOAL)
        time.sleep(after)
        went, faults = happens(system, how, f"moment {number}, {name} after {after:.2f} s")
        wrong += faults
        counts[name] += 1
        if not math.isnan(went):
            ways.append(went)
        took = time.monotonic() - began
        print(f"{number} {name} after {after:.2f} s: {went:.3f} m {faults or ''}, {took:.0f} s in all", flush=True)
    ways.sort()
    figures = {
        **counts,
        "while it was driven": len(ways),
        "went on, median / p99 / worst, m": " / ".join(
            f"{ways[min(len(ways) - 1, int(share * len(ways)))]:.3f}" for share in (0.5, 0.99, 1.0)
        )
        if ways
        else "",
        "too far": len(wrong),
    }
    report("Deaths of one process, base without a command timeout", figures)
    assert wrong == []
