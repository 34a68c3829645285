"""What `serve` and `up` refuse: each fault is one sentence that says what mends it."""

import socket
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from dock_gateway.cli.options import TYPE
from dock_gateway.cli.start import load_ros
from dock_gateway.doctor.machine import find_database_fault, find_port_fault
from dock_gateway.settings import Settings

# That of the gateway, and those of the WebSockets of extensions.
PORTS = [f"--{name.replace('_', '-')}" for name in TYPE.model_fields if name == "port" or name.endswith("_port")]


def refusal(*arguments: str, **environment: str) -> str:
    """Return the sentence with which a start ends."""
    result = CliRunner().invoke(main, arguments, env=environment)
    assert result.exit_code == 1
    (sentence,) = result.output.splitlines()
    return sentence


@pytest.mark.parametrize("command", ["serve", "up"])
@pytest.mark.parametrize(
    ("variable", "value", "mends"),
    [
        ("ROS_DOMAIN_ID", "233", "`unset ROS_DOMAIN_ID`"),
        ("RMW_IMPLEMENTATION", "rmw_nonsense_cpp", "`unset RMW_IMPLEMENTATION`"),
        ("DOCK_GATEWAY_DATABASE_URL", "sqlite:////dev/null/history.db", "--database-url"),
        ("DOCK_GATEWAY_DATABASE_URL", "sqlite:////tmp", "--database-url"),
        ("DOCK_GATEWAY_DATABASE_URL", "postgresql://ada@db:port/history", "postgresql://user@host/name"),
    ],
)
def test_what_cannot_work(command: str, variable: str, value: str, mends: str) -> None:
    assert mends in refusal(command, "--port", "0" if command == "serve" else "8999", **{variable: value})


@pytest.mark.parametrize("option", PORTS)
@pytest.mark.parametrize("command", ["serve", "up"])
def test_a_port_in_use(command: str, option: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        # Click takes the last one.
        sentence = refusal(command, "--port", "0" if command == "serve" else "8999", option, str(port))
    assert f"cannot listen on 127.0.0.1 port {port}: address already in use" in sentence
    assert f"{option} takes another" in sentence


def test_addresses_that_work_and_one_of_another_machine() -> None:
    assert find_port_fault(Settings(port=0)) is None
    assert find_port_fault(Settings(port=0, host="localhost")) is None
    sentence = refusal("serve", "--port", "0", "--host", "192.0.2.1", "--allow-open")
    assert "--host has to be an address of this machine" in sentence


def test_databases_that_may_work(tmp_path: Path) -> None:
    assert find_database_fault(Settings(database_url=f"sqlite:///{tmp_path}/new/history.db")) is None
    assert (
        find_database_fault(Settings(database_url="postgresql://ada@192.0.2.1/history")) is None
    )  # it need not answer
    assert find_database_fault(Settings(database_url="memory:")) is None


def test_without_rclpy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    assert "there is no rclpy" in refusal("up", "--port", "8999")


def test_messages_of_another_distribution(monkeypatch: pytest.MonkeyPatch) -> None:
    """They do not load: a library lacks what they need."""
    monkeypatch.setitem(sys.modules, "sensor_msgs.sensor_msgs_s__rosidl_typesupport_c", None)
    with pytest.raises(Exception, match="the ROS package sensor_msgs does not load") as caught:
        load_ros({})
    assert "`make setup`" in str(caught.value)
