"""docs/turtlebot4.md: a robot that is found through a Fast DDS discovery server alone docks."""

import os
import socket
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.support.gateway import running_gateway, running_servers
from tests.support.processes import Process, free_port
from tests.support.waiting import wait_until

pytest.importorskip("irobot_create_msgs", reason="`make test` installs the interface packages of tests/interfaces")

SERVER = Path(sys.prefix, "bin/fast-discovery-server")
# The wheel's program does not find its libraries by itself.
LIBRARIES = f"{sys.prefix}/lib:{sysconfig.get_path('purelib')}/ros_fastrtps.libs"


@contextmanager
def running_discovery_server(number: int) -> Iterator[str]:
    """A discovery server on this machine, and its address."""
    port = free_port(socket.SOCK_DGRAM)
    command = (str(SERVER), "-i", str(number), "-l", "127.0.0.1", "-p", str(port))
    with Process(*command, env={**os.environ, "LD_LIBRARY_PATH": LIBRARIES}) as process:
        process.wait_for("Server is running")
        yield f"127.0.0.1:{port}"


@pytest.mark.ros
@pytest.mark.skipif(not SERVER.exists(), reason="the environment has no discovery server of Fast DDS")
def test_a_robot_behind_the_second_discovery_server_docks(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    with running_discovery_server(0) as first, running_discovery_server(1) as second:
        monkeypatch.setenv("ROS_DISCOVERY_SERVER", f";{second}")
        with running_servers(domain, "--offer", "create3", "--robot", "/tb4"):
            monkeypatch.setenv("ROS_DISCOVERY_SERVER", f"{first};{second}")
            monkeypatch.setenv("ROS_SUPER_CLIENT", "true")
            with running_gateway(domain) as gateway:
                wait_until(lambda: gateway.http.get("/docks?robot=/tb4").status_code == 200, "the robot")
                goal = gateway.http.post("/dock?robot=/tb4", headers={"Prefer": "wait=60"}).json()
                assert (goal["status"], goal["action_name"]) == ("succeeded", "/tb4/dock")
