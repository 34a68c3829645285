"""Kills or freezes a docking server or its gateway at random moments of goals. Prints a JSON line for each death.

Run it in a network namespace of its own, as `tests/chaos/test_silence.py` does:
`unshare --map-root-user --net python -m tests.chaos.deaths MOMENTS SEED`

Real processes: a gateway, a docking server and a simulated robot without a command timeout; the simulator tells how far
the robot truly goes on. They talk by UDP: through shared memory, Fast DDS can hold up every node when one is killed
(docs/stop.md).
"""

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import ExitStack

from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from docking.core.geometry import Pose
from docking.ros.geometry import pose_from, seconds_of
from docking.ros.simulator_clock import LONGEST_LAPSE
from tests.chaos.outages import DOMAIN, NETWORK
from tests.support.gateway import IMPATIENT, RunningGateway, running_gateway
from tests.support.observer import EVERYTHING, Observer, ros_observer
from tests.support.processes import BIN, Process, ros_environment
from tests.support.waiting import PATIENCE, wait_until

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
    """Follows the true pose of a robot, and its commands."""

    def __init__(self, observer: Observer, robot: str) -> None:
        self.pose: Pose | None = None
        self.speed = self.way = 0.0
        self.commanded_at = self.stamp = self.lived = 0.0
        self._past: deque[tuple[float, float, float]] = deque(maxlen=1000)
        self._commands: deque[tuple[float, bool]] = deque(maxlen=1000)
        self._observer, node = observer, observer.node
        self._hearing = [
            observer.call(lambda: node.create_subscription(Odometry, f"{robot}/ground_truth", self._see, EVERYTHING)),
            observer.call(lambda: node.create_subscription(Twist, f"{robot}/cmd_vel", self._hear, EVERYTHING)),
        ]

    def close(self) -> None:
        """Follow it no more: with hundreds of topics of the dead, what is heard would come seconds late."""
        for each in self._hearing:
            self._observer.call(lambda each=each: self._observer.node.destroy_subscription(each))

    def _see(self, message: Odometry) -> None:
        pose, stamp = pose_from(message.pose.pose), seconds_of(message.header.stamp)
        if self.pose is not None:
            self.way += pose.distance_to(self.pose)
            self.lived += min(LONGEST_LAPSE, stamp - self.stamp)
        self.pose, self.stamp, self.speed = pose, stamp, abs(message.twist.twist.linear.x)
        self._past.append((self.stamp, self.way, self.speed))

    def settle(self, since: float) -> None:
        """Wait until `SETTLED` seconds have passed for the simulated robot since a moment of the system's clock.

        This process may lag behind, and so may the simulation's clock. Fast DDS may hold up the peers of a process that
        is killed for a second or two, and the simulation with them.
        """
        end = self.lived + SETTLED
        wait_until(lambda: self.lived >= end and self.stamp >= since + SETTLED, "the pose after a death")

    def at(self, moment: float) -> tuple[float, float]:
        """The way, in m, and the speed, in m/s, at a moment of the system's clock: this process may lag behind."""
        return next(((way, speed) for at, way, speed in reversed(self._past) if at <= moment), (self.way, self.speed))

    def _hear(self, message: Twist) -> None:
        self._commands.append((time.time(), message != Twist()))
        if message != Twist():
            self.commanded_at = time.monotonic()

    def story(self, moment: float) -> list[str]:
        """The commands and the poses around a moment of the system's clock, in ms after it."""
        commands = [(at - moment, moves) for at, moves in self._commands if at > moment - 1.0]
        poses = [(at - moment, way) for at, way, _ in self._past if at > moment - 1.0]
        return [
            "commands at " + ", ".join(f"{1000 * at:.0f}{'' if moves else ' (zero)'}" for at, moves in commands),
            "way in m at " + ", ".join(f"{1000 * at:.0f}: {way:.3f}" for at, way in poses),
        ]


class Robot:
    """A simulated robot with its docking server; each death has its own, as DDS holds on to the dead for long."""

    def __init__(self, observer: Observer, name: str, start: Pose, stack: ExitStack) -> None:
        self.name = name
        self.watcher = Watcher(observer, name)
        stack.callback(self.watcher.close)
        places = (f"start_x:={start.x}", f"start_y:={start.y}", f"start_theta:={start.theta}")
        parameters = {
            "dock_simulator": ("cmd_vel_timeout:=0.0", "room:=false", *places),
            "docking_server": ("controller:=dock_pose", "odometry_timeout:=10.0"),
        }
        for program, values in parameters.items():
            arguments = ("-r", f"__ns:={name}", *(part for value in values for part in ("-p", value)))
            command = (str(BIN / program), "--ros-args", *arguments)
            self.server = stack.enter_context(Process(*command, env=ros_environment(DOMAIN, **NETWORK)))


class Gateway:
    """A gateway, and the next one after its death."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self.start()

    def start(self) -> None:
        network = (f"{name}={value}" for name, value in NETWORK.items())
        self.running: RunningGateway = self._stack.enter_context(running_gateway(DOMAIN, "env", *network, **IMPATIENT))

    def dock(self, robot: Robot) -> None:
        deadline = time.monotonic() + PATIENCE
        while (answer := self.running.http.post("/dock", params={"robot": robot.name})).status_code != 202:
            assert time.monotonic() < deadline, answer.text
            time.sleep(0.1)


def bury(process: Process) -> None:
    process.send_signal(KILL)
    process.wait()


def judge(watcher: Watcher, since: float, moment: str) -> tuple[float, list[str]]:
    """How far the robot went on since a moment of the system's clock, in m, and what was wrong."""
    watcher.settle(since)
    way, speed = watcher.at(since)
    went, limit = watcher.way - way, ALLOWED + speed * speed / (2.0 * DECELERATION)
    wrong = [f"{moment} at {speed:.2f} m/s: {went:.3f} m, more than {limit:.3f} m"] if went > limit else []
    if watcher.speed > 0.0:
        wrong.append(f"{moment}: still moves at {watcher.speed:.2f} m/s")
    return went, wrong


def server_dies(gateway: Gateway, robot: Robot, how: signal.Signals, moment: str) -> tuple[float | None, list[str]]:
    """How far the robot goes on, if it was driven, and what was wrong."""
    driven = time.monotonic() - robot.watcher.commanded_at < 0.5
    died_at = time.time()
    robot.server.send_signal(how)
    went, wrong = judge(robot.watcher, died_at, moment)
    if wrong:
        lines = [line for line in gateway.running.process.output.splitlines() if f"{robot.name} " in line]
        wrong += [*robot.watcher.story(died_at), *lines]
    return went if driven else None, wrong


def gateway_dies(gateway: Gateway, robot: Robot, how: signal.Signals, moment: str) -> tuple[float | None, list[str]]:
    """The goal goes on, and the next gateway can cancel it."""
    gateway.running.process.send_signal(how)
    time.sleep(SETTLED)
    bury(gateway.running.process)
    gateway.start()
    http = gateway.running.http
    wait_until(lambda: f'"{robot.name}"' in http.get("/robots").text, "the robot at the next gateway")
    stopped_at = time.time()
    http.post("/stop", params={"robot": robot.name}, json={"by": "a test"}).raise_for_status()
    _, wrong = judge(robot.watcher, stopped_at, f"{moment}, stopped")
    return None, wrong


Death = Callable[[Gateway, Robot, signal.Signals, str], tuple[float | None, list[str]]]
DEATHS: list[tuple[str, Death, signal.Signals]] = [
    ("docking server killed", server_dies, KILL),
    ("docking server frozen", server_dies, FREEZE),
    ("gateway killed", gateway_dies, KILL),
    ("gateway frozen", gateway_dies, FREEZE),
]


def main(moments: int, seed: int) -> None:
    subprocess.run(("ip", "link", "set", "lo", "up"), check=True)
    os.environ.update(NETWORK)
    chance = random.Random(seed)
    with ros_observer(DOMAIN) as observer, ExitStack() as stack:
        gateway = Gateway(stack)
        for number in range(moments):
            name, happens, how = DEATHS[number % 2 if number % 10 < 9 else 2 + number // 10 % 2]
            start = Pose(chance.uniform(-1.4, -0.8), chance.uniform(-0.2, 0.2), chance.uniform(-0.4, 0.4))
            after = chance.uniform(0.0, LONGEST_GOAL)
            with ExitStack() as processes:
                robot = Robot(observer, f"/robot{number}", start, processes)
                wait_until(lambda robot=robot: robot.watcher.pose is not None, f"{robot.name} on the graph")
                gateway.dock(robot)
                time.sleep(after)
                went, wrong = happens(gateway, robot, how, f"moment {number}, {name} after {after:.2f} s")
            print(json.dumps({"death": name, "after": round(after, 2), "went": went, "wrong": wrong}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
