"""`dock-gateway up`: where it says that the gateway is, and what it starts where."""

import asyncio
import os
import signal
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from dock_gateway.cli.output import Output
from dock_gateway.cli.supervisor import supervise
from dock_gateway.cli.up import (
    SIMULATED,
    TUTORIAL,
    default_robot,
    fleet,
    robot_commands,
    stay_on_this_machine,
)
from dock_gateway.doctor.machine import own_url
from dock_gateway.settings import Settings
from tests.support.waiting import until


@pytest.mark.parametrize(
    ("host", "url"),
    [
        ("127.0.0.1", "http://127.0.0.1:8000"),
        ("0.0.0.0", "http://127.0.0.1:8000"),
        ("::1", "http://[::1]:8000"),
        ("::", "http://[::1]:8000"),
        ("robot.local", "http://robot.local:8000"),
    ],
)
def test_the_address_that_is_announced(host: str, url: str) -> None:
    assert own_url(Settings(host=host)) == url
    secure = Settings(host=host, tls_cert=Path("cert.pem"), tls_key=Path("key.pem"))
    assert own_url(secure) == url.replace("http://", "https://")


def test_a_port_that_cannot_be_announced_is_refused() -> None:
    result = CliRunner().invoke(main, ["up", "--port", "0"])
    assert result.exit_code == 2
    assert "the port must not be 0" in result.output


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, "LOCALHOST"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, "LOCALHOST"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT", "ROS_STATIC_PEERS": "192.168.1.7"}, "LOCALHOST"),
        ({"ROS_STATIC_PEERS": "192.168.1.7"}, "LOCALHOST"),
    ],
)
def test_a_simulated_robot_stays_on_this_machine(given: dict[str, str], expected: str) -> None:
    environment = dict(given)
    stay_on_this_machine(environment, always=True)
    assert environment == {"ROS_AUTOMATIC_DISCOVERY_RANGE": expected}


def test_without_one_the_environment_counts() -> None:
    environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": "192.168.1.7"}
    stay_on_this_machine(environment, always=False)
    assert environment == {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": "192.168.1.7"}
    empty: dict[str, str] = {}
    stay_on_this_machine(empty, always=False)
    assert empty == {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def test_the_programs_of_a_robot() -> None:
    server, simulator = robot_commands(SIMULATED, Settings(namespace="/robot1")).values()
    assert server[0].endswith("/docking_server")
    driving = ["-p", "controller:=dock_pose", "-p", "use_sim_time:=true"]
    assert server[1:] == ["--ros-args", *driving, "-r", "__ns:=/robot1"]
    assert simulator[0].endswith("/dock_simulator")
    assert simulator[1:] == ["--ros-args", "-p", "publish_clock:=true", "-r", "__ns:=/robot1"]
    (tutorial,) = robot_commands(TUTORIAL, Settings()).values()
    assert tutorial[0].endswith("/connect_to_charging_dock_server")
    assert tutorial[1:] == []


# Counts its starts in a file. The first one runs for longer than a gateway whose settings are wrong.
GATEWAY = """
import pathlib, sys, time
starts = pathlib.Path(sys.argv[1])
starts.write_text(starts.read_text() + "x")
time.sleep({1: 1.5, 2: 0}.get(len(starts.read_text()), 60))
"""


async def test_a_gateway_that_has_run_is_started_again_and_again(tmp_path: Path) -> None:
    starts = tmp_path / "starts"
    starts.touch()
    command = [sys.executable, "-c", GATEWAY, str(starts)]
    with Output(tmp_path / "up.log") as output:
        supervising = asyncio.create_task(
            supervise({"the gateway": command}, "http://127.0.0.1:1", output, start_window=1.0, longest_delay=0.1)
        )
        await until(lambda: supervising.done() or starts.read_text() == "xxx")
        assert not supervising.done()
        os.kill(os.getpid(), signal.SIGTERM)
        assert await supervising


async def test_a_gateway_that_cannot_start_ends_everything(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "print('the last word')"]
    with Output(tmp_path / "up.log") as output:
        assert not await supervise({"the gateway": command}, "http://127.0.0.1:1", output)
    assert (tmp_path / "up.log").read_text() == "the last word\n"


def test_a_fleet_and_the_robot_that_is_meant_without_a_name() -> None:
    assert fleet(5)[1:] == ["-m", "docking.nodes.simulated_fleet", "5"]
    assert fleet(5, 2)[1:] == ["-m", "docking.nodes.simulated_fleet", "5", "--docks", "2"]
    assert default_robot(Settings(), 5) == "/robot1"
    assert default_robot(Settings(namespace="/robot5"), 5) == "/robot5"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--robots", "0"], "0 is not in the range"),
        (["--robots", "21"], "21 is not in the range"),
        (["--robots", "many"], "not a valid int"),
        (["--robots", "3", "--no-sim"], "leave out --no-sim"),
        (["--docks", "2"], "--docks is for --robots"),
        (["--robots", "2", "--docks", "3"], "one for each at most"),
        (["--robots", "3", "--namespace", "/robot4"], "/robot1 to /robot3, and /robot4 is none of them"),
    ],
)
def test_fleets_that_cannot_be(options: list[str], said: str) -> None:
    result = CliRunner().invoke(main, ["up", *options])
    assert result.exit_code == 2
    assert said in result.output
