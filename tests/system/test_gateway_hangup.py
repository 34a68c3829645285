"""SIGHUP: the log level and the allow lists are read again; a gateway whose terminal closes ends."""

import fcntl
import os
import pty
import signal
import subprocess
import sys
import termios
from pathlib import Path

import pytest

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import ros_environment
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros


def publish(gateway: RunningGateway) -> int:
    answer = gateway.http.post("/topics/chatter?type=std_msgs/msg/String", json={"data": "a"})
    return answer.status_code


def test_what_may_be_published_is_read_again(domain: int, tmp_path: Path) -> None:
    file = tmp_path / "gateway.toml"
    file.write_text('allow_publish = []\nlog_level = "info"\n')
    with running_gateway(domain, config=str(file)) as gateway:
        assert publish(gateway) == 403
        file.write_text('allow_publish = ["/chatter"]\nmax_robots = 7\n')
        gateway.process.send_signal(signal.SIGHUP)
        gateway.process.wait_for("settings are read again: allow_publish = /chatter")
        gateway.process.wait_for("not taken before the next start: max_robots")
        assert publish(gateway) == 200
        file.write_text("allow_publsh = []\n")
        gateway.process.send_signal(signal.SIGHUP)
        gateway.process.wait_for("Did you mean allow_publish?")
        assert publish(gateway) == 200


def test_a_terminal_that_closes_ends_the_gateway(domain: int, tmp_path: Path) -> None:
    ours, its = pty.openpty()

    def take_terminal() -> None:
        os.setsid()
        fcntl.ioctl(its, termios.TIOCSCTTY, 0)

    command = (sys.executable, "-m", "dock_gateway", "serve", "--port", "0", "--database-url", "memory:")
    environment = ros_environment(domain, XDG_DATA_HOME=str(tmp_path), DOCK_GATEWAY_RECORDINGS="none")
    with subprocess.Popen(
        command,
        stdin=its,
        stdout=its,
        stderr=its,
        env=environment,
        preexec_fn=take_terminal,  # noqa: PLW1509
    ) as gateway:
        os.close(its)
        output = b""

        def listens() -> bool:
            nonlocal output
            output += os.read(ours, 65536)
            return b"listening on" in output

        wait_until(listens, "the gateway")
        os.close(ours)
        assert gateway.wait(PATIENCE) == 0
