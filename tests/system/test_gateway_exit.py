"""On every way out: streams are told, requests are answered, the robot stands still, and the process is gone."""

import os
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest
from websockets.exceptions import ConnectionClosed

from tests.support.clients import HttpClient
from tests.support.gateway import LOW, RunningGateway, ready_gateway, running_dock_server, running_gateway
from tests.support.installed import needs
from tests.support.processes import BIN, GONE_WITHIN, Process, free_port, ros_environment
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def wait_gone(pids: list[int], timeout: float) -> None:
    wait_until(lambda: not any(alive(pid) for pid in pids), "the end of each process", timeout)


def test_a_signal_with_streams_and_a_goal_and_a_waiting_request(domain: int) -> None:
    answers: list[httpx2.Response] = []
    with running_dock_server(domain) as server, running_gateway(domain, "env") as gateway, gateway.stream() as stream:
        gateway.wait_until_ready()
        gateway.publish(LOW)

        def wait_for_the_end() -> None:
            with HttpClient(gateway.url) as http:
                answers.append(http.post("/dock", headers={"Prefer": "wait=60"}, timeout=70))

        waiting = threading.Thread(target=wait_for_the_end)
        waiting.start()
        stream.until_type("feedback")
        started = time.monotonic()
        gateway.process.send_signal(signal.SIGTERM)
        closing = stream.until_type("closing")
        assert closing["reason"] == "shutting_down"
        with pytest.raises(ConnectionClosed) as closed:
            stream.next()
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1012
        gateway.process.wait()
        assert time.monotonic() - started < GONE_WITHIN
        waiting.join(5)
        assert answers[0].status_code == 202
        assert answers[0].json()["status"] == "executing"
        assert "Traceback" not in gateway.process.output
        assert server.running


@pytest.mark.parametrize(("said", "number"), [("registry]: robot /", signal.SIGTERM), ("listening on", signal.SIGINT)])
def test_a_signal_in_the_middle_of_a_start(domain: int, tmp_path: Path, said: str, number: signal.Signals) -> None:
    """ROS is there and the web is not, or the database is not."""
    kept = {
        "DATABASE_URL": f"sqlite:///{tmp_path}/h.db",
        "SPOOL_PATH": f"{tmp_path}/spool",
        "STOP_PATH": f"{tmp_path}/s",
    }
    settings = {f"DOCK_GATEWAY_{name}": value for name, value in {"PORT": "0", **kept}.items()}
    with Process(str(BIN / "dock-gateway"), "serve", env=ros_environment(domain, **settings)) as process:
        process.wait_for(said)
        process.send_signal(number)
        begun = time.monotonic()
        process.wait()
        assert time.monotonic() - begun < GONE_WITHIN
        assert "ERROR" not in process.output
        assert "Traceback" not in process.output


def test_a_reader_that_never_reads_is_cut_off_and_harms_nobody(domain: int) -> None:
    with (
        running_dock_server(domain),
        running_gateway(domain, subscriber_timeout="2", subscriber_queue="16") as gateway,
        gateway.stream() as reader,
    ):
        gateway.wait_until_ready()
        host, port = gateway.url.removeprefix("http://").split(":")
        with socket.socket() as sleeper:
            sleeper.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            sleeper.connect((host, int(port)))
            sleeper.sendall(
                b"GET /ws/feedback?include=battery HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                b"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
            )
            gateway.http.put(
                "/battery/publisher", json={"state": LOW | {"location": "x" * 60_000}, "rate_hz": 100}
            ).raise_for_status()
            goal_id = gateway.http.post("/dock").json()["goal_id"]
            deadline = time.monotonic() + PATIENCE
            while gateway.http.get("/healthz").json()["subscribers"] > 1:
                assert time.monotonic() < deadline, "the sleeper was not cut off"
                reader.until_type("feedback")
        gateway.http.post(f"/dock/{goal_id}/cancel").raise_for_status()
        assert reader.until_type("result")["status"] == "canceled"


def test_a_reader_of_server_sent_events_that_never_reads_is_cut_off(domain: int) -> None:
    with ready_gateway(domain, subscriber_timeout="2") as gateway:
        state = LOW | {"location": "x" * 60_000}
        gateway.http.put("/battery/publisher", json={"state": state, "rate_hz": 100}).raise_for_status()
        goal_id = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
        host, port = gateway.url.removeprefix("http://").split(":")
        with socket.socket() as sleeper:
            sleeper.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            sleeper.connect((host, int(port)))
            sleeper.sendall(f"GET /dock/{goal_id}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            wait_for_subscribers(gateway, 1)
            wait_for_subscribers(gateway, 0)
        assert gateway.goal(goal_id)["status"] == "executing"
        gateway.http.post(f"/dock/{goal_id}/cancel").raise_for_status()
        gateway.wait_for_goal(goal_id, "canceled")
        assert "Traceback" not in gateway.process.output


def wait_for_subscribers(gateway: RunningGateway, number: int) -> None:
    wait_until(lambda: gateway.http.get("/healthz").json()["subscribers"] == number, f"{number} subscribers")


@contextmanager
def up(domain: int, port: int, *arguments: str) -> Iterator[tuple[Process, RunningGateway]]:
    command = (str(BIN / "dock-gateway"), "up", "--port", str(port), *arguments)
    with Process(*command, env=ros_environment(domain)) as process:
        process.wait_for("dock-gateway is ready")
        url = f"http://127.0.0.1:{port}"
        with HttpClient(url) as http:
            yield process, RunningGateway(process, url, http)


def children(pid: int) -> list[int]:
    with open(f"/proc/{pid}/task/{pid}/children") as listing:  # noqa: PTH123
        return [int(child) for child in listing.read().split()]


@needs("simulator")
def test_up_runs_a_simulated_robot_that_docks_and_one_ctrl_c_ends_it(domain: int) -> None:
    with up(domain, free_port()) as (process, gateway):
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        goal = gateway.http.post("/dock", headers={"Prefer": "wait=60"}, timeout=70).json()
        assert (goal["status"], gateway.http.get("/simulator").json()["docked"]) == ("succeeded", True)
        parts = children(process.pid)
        assert len(parts) == 3
        started = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait() == 0
        assert time.monotonic() - started < GONE_WITHIN
        wait_gone(parts, 1)
        assert "Traceback" not in process.output


def test_up_runs_the_tutorial_and_one_ctrl_c_ends_it(domain: int) -> None:
    with up(domain, free_port(), "--no-sim") as (process, gateway):
        gateway.publish(LOW)
        with gateway.stream("?include=cmd_vel") as stream:
            gateway.http.post("/dock").raise_for_status()
            stream.until(lambda e: e["type"] == "cmd_vel" and e["cmd_vel"]["angular"]["z"] != 0)
            parts = children(process.pid)
            assert len(parts) == 2
            started = time.monotonic()
            process.send_signal(signal.SIGINT)
            assert process.wait() == 0
            assert time.monotonic() - started < GONE_WITHIN
        wait_gone(parts, 1)
        assert "Traceback" not in process.output


def test_up_starts_a_dead_action_server_again(domain: int) -> None:
    with up(domain, free_port(), "--no-sim") as (process, gateway):
        gateway_pid, server_pid = children(process.pid)
        os.kill(server_pid, signal.SIGKILL)
        process.wait_for("the action server ended (-9)")
        gateway.wait_until_ready()
        assert gateway_pid in children(process.pid)
        wait_until(lambda: gateway.http.post("/dock").status_code == 202, "a goal is accepted")


def test_the_parts_do_not_outlive_a_killed_up(domain: int) -> None:
    with up(domain, free_port()) as (process, _):
        parts = children(process.pid)
        process.send_signal(signal.SIGKILL)
        process.wait()
        wait_gone(parts, 10)


def test_up_on_a_port_that_is_taken_says_so(domain: int) -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        port = str(listener.getsockname()[1])
        with Process(str(BIN / "dock-gateway"), "up", "--port", port, env=ros_environment(domain)) as process:
            assert process.wait() == 1
            assert "address already in use" in process.output
            assert "--port takes another" in process.output


def test_up_with_a_simulated_robot_stays_on_this_machine(domain: int) -> None:
    environment = ros_environment(domain, ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET")
    port = free_port()
    with Process(str(BIN / "dock-gateway"), "up", "--port", str(port), env=environment) as process:
        process.wait_for("dock-gateway is ready")
        with HttpClient(f"http://127.0.0.1:{port}") as http:
            health = http.get("/healthz").json()
        assert health["ros"]["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_wrong_settings_are_said_plainly(domain: int) -> None:
    with Process(str(BIN / "dock-gateway"), "serve", "--port", "eighty", env=ros_environment(domain)) as process:
        assert process.wait() == 2
        assert "port" in process.output
        assert "Traceback" not in process.output
