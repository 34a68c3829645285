"""`dock-gateway up --sites 3`: what it starts where. tests/extensions/sites/system/test_up_with_sites.py runs it."""

import json
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from dock_gateway.cli.up import MAX_SITES
from dock_hub.demonstration import (
    NAMES,
    NO_BROKER,
    all_connected,
    broker_config,
    domain_of,
    find_broker,
    hub_environment,
    new_login,
    site_environment,
)

SHELL = {"PATH": "/bin", "ROS_DOMAIN_ID": "7", "DOCK_GATEWAY_PORT": "8080", "DOCK_GATEWAY_AUTHENTICATION": "true"}


def test_the_broker_takes_its_configuration_and_gives_each_site_its_own_subjects(tmp_path: Path) -> None:
    config = tmp_path / "broker.json"
    config.write_text(broker_config(4222, new_login("hub"), [new_login("berlin"), new_login("oslo")]))
    subprocess.run([find_broker(), "-t", "-c", str(config)], check=True, capture_output=True)
    hub, berlin, oslo = json.loads(config.read_text())["authorization"]["users"]
    assert berlin["permissions"] == {
        "publish": ["dock.hub.hello.berlin", "dock.hub.stream.berlin.*"],
        "subscribe": ["dock.site.berlin.>", "_INBOX.berlin.>"],
        "allow_responses": True,
    }
    assert len({user["password"] for user in (hub, berlin, oslo)}) == 3


def test_the_settings_of_the_shell_are_the_hubs(tmp_path: Path) -> None:
    hub = hub_environment(SHELL, tmp_path, "nats://hub@127.0.0.1:1")
    assert hub["DOCK_GATEWAY_PORT"] == "8080"
    assert hub["DOCK_GATEWAY_AUTHENTICATION"] == "true"
    assert hub["DOCK_GATEWAY_NATS"] == "nats://hub@127.0.0.1:1"
    chosen = hub_environment(SHELL | {"DOCK_GATEWAY_DATABASE_URL": "memory:"}, tmp_path, "")
    assert chosen["DOCK_GATEWAY_DATABASE_URL"] == "memory:"
    site = site_environment(SHELL, tmp_path / "oslo", 1, broker="nats://oslo@127.0.0.1:1", port=8082, namespace="")
    assert site["DOCK_GATEWAY_SITE"] == "oslo"
    assert site["DOCK_GATEWAY_PORT"] == "8082"
    assert "DOCK_GATEWAY_AUTHENTICATION" not in site
    assert site["PATH"] == "/bin"


def test_each_site_has_a_ros_domain_of_its_own() -> None:
    assert [domain_of(number, SHELL) for number in range(3)] == [8, 9, 10]
    assert domain_of(0, {"ROS_DOMAIN_ID": "101"}) == 0
    assert domain_of(0, {"ROS_DOMAIN_ID": ""}) == 1


def test_it_is_ready_when_the_hub_hears_all_sites() -> None:
    states = [{"name": "berlin", "state": "connected"}, {"name": "oslo", "state": "unreachable"}]
    assert all_connected(1, {"sites": states})
    assert not all_connected(2, {"sites": states})
    assert all_connected(2, {"code": "not_authenticated"})


def test_a_broker_that_is_not_installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(click.ClickException) as caught:
        find_broker()
    assert caught.value.message == NO_BROKER


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--sites", "6"], "6 is not in the range"),
        (["--sites", "2", "--no-sim"], "leave out --no-sim"),
        (["--sites", "2", "--namespace", "/robot1"], "the robots of --sites have no other names"),
    ],
)
def test_sites_that_cannot_be(options: list[str], said: str) -> None:
    result = CliRunner().invoke(main, ["up", *options])
    assert result.exit_code == 2
    assert said in result.output


def test_each_simulated_site_has_a_name() -> None:
    assert len(NAMES) == MAX_SITES
