"""Robots that a gateway does not reach for some 20 s: frozen, or out of the Wi-Fi. Prints a JSON line for each outage.

Run it in a network namespace of its own, as `tests/chaos/test_outages.py` does:
`unshare --map-root-user --net python -m tests.chaos.outages ROUNDS ROBOTS freeze|link SECONDS SPREAD`

Each robot is in another network namespace, behind a link of its own to the gateway.
"""

import json
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

from tests.support.gateway import IMPATIENT, LOW, RunningGateway, running_gateway
from tests.support.processes import BIN, Process, ros_environment

# A network that only these processes are in: any domain is free. Shared memory would pass by the links.
DOMAIN = 7
NETWORK = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4?non_blocking=true"}
GIVE_UP = 60.0
NOTHING_PASSES = "tbf rate 8bit burst 1 limit 1"


def sh(command: str) -> None:
    subprocess.run(command, shell=True, check=True)


@dataclass
class Robot:
    """An action server in a network namespace of its own."""

    number: int
    namespace_pid: int
    server: Process

    @property
    def name(self) -> str:
        return f"/robot{self.number}"

    @contextmanager
    def frozen(self) -> Iterator[None]:
        self.server.send_signal(signal.SIGSTOP)
        yield
        self.server.send_signal(signal.SIGCONT)

    @contextmanager
    def unlinked(self) -> Iterator[None]:
        ours, theirs = f"dev v{self.number} root", f"dev e{self.number} root"
        enter = f"nsenter -t {self.namespace_pid} -n"
        sh(f"tc qdisc add {ours} {NOTHING_PASSES}; {enter} tc qdisc add {theirs} {NOTHING_PASSES}")
        yield
        sh(f"tc qdisc del {ours}; {enter} tc qdisc del {theirs}")


@contextmanager
def robot(number: int) -> Iterator[Robot]:
    """An action server with a link to this network namespace."""
    with ExitStack() as stack:
        namespace = subprocess.Popen(("unshare", "--net", "sleep", "infinity"))
        stack.callback(namespace.wait)
        stack.callback(namespace.kill)
        time.sleep(0.5)  # `unshare` says nothing when it has done it
        ours, theirs, enter = f"v{number}", f"e{number}", ("nsenter", "-t", str(namespace.pid), "-n")
        sh(f"ip link add {ours} type veth peer name {theirs} && ip link set {theirs} netns {namespace.pid}")
        sh(f"ip addr add 10.9.{number}.1/24 dev {ours} && ip link set {ours} up")
        inside = f"ip link set lo up && ip addr add 10.9.{number}.2/24 dev {theirs} && ip link set {theirs} up"
        sh(f"{' '.join(enter)} sh -c '{inside} && ip route add default via 10.9.{number}.1'")
        arguments = ("--ros-args", "-r", f"__ns:=/robot{number}")
        server = Process(
            *enter, str(BIN / "connect_to_charging_dock_server"), *arguments, env=ros_environment(DOMAIN, **NETWORK)
        )
        yield Robot(number, namespace.pid, stack.enter_context(server))


def start_goal(gateway: RunningGateway, robot: Robot) -> str:
    deadline = time.monotonic() + 120
    while (answer := gateway.http.post("/dock", params={"robot": robot.name})).status_code != 202:
        assert time.monotonic() < deadline, answer.text
        time.sleep(0.5)
    goal_id: str = answer.json()["goal_id"]
    gateway.wait_for_goal(goal_id, "executing", timeout=60)
    return goal_id


def cancel_after(gateway: RunningGateway, robot: Robot, kind: str, seconds: float) -> dict[str, Any]:
    """Cancel a goal just after an outage; return how long that takes, and how the goal ends."""
    goal_id = start_goal(gateway, robot)
    time.sleep(random.uniform(1, 3))
    with robot.frozen() if kind == "freeze" else robot.unlinked():
        time.sleep(seconds)
    over = time.monotonic()
    gateway.http.post(f"/dock/{goal_id}/cancel")
    while (status := gateway.goal(goal_id)["status"]) not in ("canceled", "aborted", "succeeded"):
        if time.monotonic() - over > GIVE_UP:
            break
        time.sleep(0.1)
    return {"robot": robot.name, "outage": round(seconds, 1), "took": time.monotonic() - over, "status": status}


def main(rounds: int, robots: int, kind: str, seconds: float, spread: float) -> None:
    sh("ip link set lo up")
    with ExitStack() as stack:
        links = [stack.enter_context(robot(number)) for number in range(robots)]
        network = (f"{name}={value}" for name, value in NETWORK.items())
        gateway = stack.enter_context(running_gateway(DOMAIN, "env", *network, **IMPATIENT))

        def attack(robot: Robot, rounds: int) -> None:
            at = {"robot": robot.name}
            deadline = time.monotonic() + 120
            while not gateway.http.put("/battery/publisher", params=at, json={"state": LOW, "rate_hz": 5}).is_success:
                assert time.monotonic() < deadline, f"no {robot.name}"
                time.sleep(0.5)
            for _ in range(rounds):
                figures = cancel_after(gateway, robot, kind, seconds + random.uniform(0, spread))
                print(f"{json.dumps(figures)}\n", end="", flush=True)  # in one piece: robots print at once

        attacks = [
            threading.Thread(target=attack, args=(link, (rounds + robots - 1 - link.number) // robots))
            for link in links
        ]
        for thread in attacks:
            thread.start()
        waits = []
        while any(thread.is_alive() for thread in attacks):
            asked = time.monotonic()
            gateway.http.get("/healthz").raise_for_status()
            waits.append(time.monotonic() - asked)
            time.sleep(0.02)
        rejoined = gateway.process.output.count("answers only through another DDS participant")
        print(json.dumps({"rejoined": rejoined, "healthz": max(waits)}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], float(sys.argv[4]), float(sys.argv[5]))
