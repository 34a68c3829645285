"""The real gateway as a process, and clients that speak to it as users do."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from tempfile import TemporaryDirectory
from typing import Any

import orjson
from websockets.sync.client import ClientConnection

from dock_gateway.settings import Settings
from tests.support.clients import HttpClient, connect
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import PATIENCE, wait_until

LOW = {"voltage": 2.16, "percentage": 0.24, "power_supply_status": 3}
CHARGING = {"voltage": 2.16, "percentage": 0.24, "power_supply_status": 1}
ACTION = "/connect_to_charging_dock"
# What an action server gets for its answers, in seconds: more than by default, as a machine may be busy.
PATIENT = {"server_wait": "4", "accept_timeout": "30", "cancel_timeout": "30"}
IMPATIENT = {name: str(Settings.model_fields[name].default) for name in PATIENT}


class Stream:
    """A reader of /ws/feedback."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.seen: list[dict[str, Any]] = []

    def next(self, timeout: float = PATIENCE) -> dict[str, Any]:
        event: dict[str, Any] = orjson.loads(self.connection.recv(timeout))
        self.seen.append(event)
        return event

    def until(self, matches: Callable[[dict[str, Any]], bool], timeout: float = PATIENCE) -> dict[str, Any]:
        """Read on to the first event that matches."""
        deadline = time.monotonic() + timeout
        while (left := deadline - time.monotonic()) > 0:
            try:
                event = self.next(left)
            except TimeoutError:
                break
            if matches(event):
                return event
        raise AssertionError(f"no such event; the last ones were {self.seen[-5:]}")

    def once_seen(self, matches: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The first event that matches, of those that came and those to come.

        What a gateway learns by several topics may come in any order.
        """
        return next(filter(matches, self.seen), None) or self.until(matches)

    def until_zero(self) -> None:
        """Read on until the last velocity is zero, which may come after the result of the goal."""
        while any((*self._velocity["linear"].values(), *self._velocity["angular"].values())):
            self.until_type("cmd_vel")

    @property
    def _velocity(self) -> dict[str, Any]:
        return next(event["cmd_vel"] for event in reversed(self.seen) if event["type"] == "cmd_vel")

    def until_type(self, kind: str, timeout: float = PATIENCE) -> dict[str, Any]:
        return self.until(lambda event: event["type"] == kind, timeout)

    def until_status(self, status: str, timeout: float = PATIENCE) -> dict[str, Any]:
        return self.until(lambda event: event["type"] == "status" and event["status"] == status, timeout)


@dataclass
class RunningGateway:
    """A gateway, its address and an HTTP client for it."""

    process: Process
    url: str
    http: HttpClient

    @contextmanager
    def stream(
        self, query: str = "", path: str = "/ws/feedback", headers: dict[str, str] | None = None
    ) -> Iterator[Stream]:
        url = f"{self.url.replace('http', 'ws')}{path}{query}"
        with connect(url, additional_headers=headers) as connection:
            yield Stream(connection)

    @contextmanager
    def echo(self, topic: str, query: str = "") -> Iterator[Stream]:
        with self.stream(f"?topic={topic}{query}", "/ws/topics") as stream:
            yield stream

    def goal(self, goal_id: str) -> dict[str, Any]:
        answer: dict[str, Any] = self.http.get(f"/goals/{goal_id}").raise_for_status().json()
        return answer

    def wait_until_stored(self) -> None:
        """Wait until the database has been opened and has taken over what is in the spool."""
        self._wait(lambda state: state["history"]["database_reachable"] and not state["history"]["spooled"])

    def wait_for_goal(self, goal_id: str, *statuses: str, timeout: float = PATIENCE) -> dict[str, Any]:
        """Poll a goal until it has one of these states."""
        deadline = time.monotonic() + timeout
        while (goal := self.goal(goal_id))["status"] not in statuses:
            assert time.monotonic() < deadline, f"still {goal['status']}, not {statuses}"
            time.sleep(0.05)
        return goal

    def wait_until_ready(self, timeout: float = PATIENCE) -> None:
        self._wait(lambda state: state["ready"], timeout)

    def _wait(self, holds: Callable[[dict[str, Any]], bool], timeout: float = PATIENCE) -> None:
        """Poll /readyz until something holds of it."""
        deadline = time.monotonic() + timeout
        while not holds(state := self.http.get("/readyz").json()):
            assert time.monotonic() < deadline, state
            time.sleep(0.02)

    def stop_once(self, query: str = "") -> dict[str, Any]:
        """Stop, wait for what it brings about, and let goals through again at once."""
        answer = self.http.post(f"/stop{query}", json={"latch": False}, headers={"Prefer": "wait=30"})
        report: dict[str, Any] = answer.raise_for_status().json()
        return report

    def set_fault(self, name: str, *, active: bool = True, robot: str = "") -> None:
        """Switch a fault of the simulator on or off; without a robot, that of the settings."""
        params = {"robot": robot} if robot else {}
        self.http.put(f"/simulator/faults/{name}", params=params, json={"active": active}).raise_for_status()

    def publish(self, state: dict[str, Any], rate_hz: float = 5.0) -> None:
        self.http.put("/battery/publisher", json={"state": state, "rate_hz": rate_hz}).raise_for_status()


@contextmanager
def running_gateway(domain: int, *prefix: str, **settings: str) -> Iterator[RunningGateway]:
    """`dock-gateway serve` on a free port, with a database of its own; it records nothing unless it is told to.

    Args:
        domain: The ROS domain.
        prefix: A command that runs it, in a Python of its own, as from a shell; without one it is a fork.
        settings: As in DOCK_GATEWAY_<NAME>.
    """
    with TemporaryDirectory(prefix="dock-gateway-", ignore_cleanup_errors=True) as folder, ExitStack() as stack:
        stored = {"database_url": f"sqlite:///{folder}/history.db", "spool_path": f"{folder}/spool"}
        stored |= {"stop_path": f"{folder}/stops.json", "recordings_path": f"{folder}/recordings"}
        settings = {"port": "0", "recordings": "none", **PATIENT, **stored, **settings}
        variables = {f"DOCK_GATEWAY_{name.upper()}": value for name, value in settings.items()}
        environment = ros_environment(domain, **variables)
        start = Process if prefix else ForkedProcess
        process = stack.enter_context(start(*prefix, "dock-gateway", "serve", env=environment))
        url = re.sub(r'.*(https?://[^"]+).*', r"\1", process.wait_for("listening on "))
        with HttpClient(url) as http:
            yield RunningGateway(process, url, http)


@contextmanager
def running_program(domain: int, name: str, *ros_args: str) -> Iterator[Process]:
    """One of our ROS programs."""
    arguments = ("--ros-args", *ros_args) if ros_args else ()
    with ForkedProcess(name, *arguments, env=ros_environment(domain)) as process:
        yield process


@contextmanager
def running_servers(domain: int, *arguments: str) -> Iterator[Process]:
    """Docking servers that are not ours, see `tests.support.docking_servers`."""
    environment = ros_environment(domain)
    with ForkedProcess("-m", "tests.support.docking_servers", *arguments, env=environment) as process:
        process.wait_for("serving")
        yield process


@contextmanager
def running_dock_server(domain: int, *ros_args: str) -> Iterator[Process]:
    """Our action server."""
    with running_program(domain, "connect_to_charging_dock_server", *ros_args) as process:
        yield process


@contextmanager
def ready_gateway(domain: int, **settings: str) -> Iterator[RunningGateway]:
    """A gateway that has found our action server."""
    with running_dock_server(domain), running_gateway(domain, **settings) as gateway:
        gateway.wait_until_ready()
        yield gateway


@contextmanager
def running_talker(domain: int, *arguments: str) -> Iterator[Process]:
    """Nodes that talk, see `tests/support/talker.py`."""
    with ForkedProcess("-m", "tests.support.talker", *arguments, env=ros_environment(domain)) as process:
        process.wait_for("talking")
        yield process


@contextmanager
def running_service_node(domain: int) -> Iterator[Process]:
    """A node with services, parameters and topics, see `tests/support/service_node.py`."""
    with ForkedProcess("-m", "tests.support.service_node", env=ros_environment(domain)) as process:
        process.wait_for("serving")
        yield process


@contextmanager
def running_hostile_node(domain: int, *arguments: str) -> Iterator[Process]:
    """A node that floods, see `tests/support/hostile_node.py`."""
    with ForkedProcess("-m", "tests.support.hostile_node", *arguments, env=ros_environment(domain)) as process:
        process.wait_for("flooding")
        yield process


@contextmanager
def running_gateway_with_talker(domain: int, **settings: str) -> Iterator[RunningGateway]:
    """Run a gateway beside an action, a topic of scans and one that keeps its last message, and wait for them."""
    with ExitStack() as stack:
        topics = ("--topic", "scan:sensor_msgs/msg/LaserScan:20", "--topic", "latched:std_msgs/msg/String:latched")
        stack.enter_context(running_talker(domain, "--long", "720", *topics))
        stack.enter_context(running_program(domain, "fibonacci_action_server", "-p", "step_period:=0.2"))
        gateway = stack.enter_context(running_gateway(domain, server_wait="1", **settings))
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        wait_until(lambda: gateway.http.get("/graph/topics/talker0/scan").status_code == 200, "the topic")
        yield gateway
