"""Python, ROS and its variables."""

import sys
from pathlib import Path

import pytest

from dock_gateway.doctor.check import Level
from dock_gateway.doctor.environment import check_environment, check_settings, find_twin_fault
from dock_gateway.settings import Settings


def levels(environment: dict[str, str]) -> dict[str, Level]:
    return {check.name: check.level for check in check_environment(Settings(), environment)}


def text(name: str, environment: dict[str, str]) -> str:
    return next(check.text for check in check_environment(Settings(), environment) if check.name == name)


def test_this_environment_works() -> None:
    assert set(levels({}).values()) == {Level.OK}
    assert "ROS 2 Jazzy (rclpy 7.1." in text("ros", {})
    assert "with rmw_fastrtps_cpp" in text("ros", {})
    assert f"the environment {sys.prefix}" in text("ros", {})
    assert "action_tutorials_interfaces" in text("docking", {})


def test_without_ros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    assert levels({})["ros"] is Level.ERROR
    assert levels({})["docking"] is Level.ERROR
    assert "`make setup`" in text("ros", {})


@pytest.mark.parametrize(
    ("environment", "found"),
    [
        ({}, "on the local network"),
        ({"ROS_STATIC_PEERS": "10.0.0.7"}, "on the local network are found, and on 10.0.0.7"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, "this machine are found, as ROS_AUTOMATIC_DISCOVERY_RANGE"),
        ({"ROS_LOCALHOST_ONLY": "1"}, "this machine are found, as ROS_LOCALHOST_ONLY"),
        ({"ROS_DISCOVERY_SERVER": ";10.0.0.1:11811", "ROS_SUPER_CLIENT": "1"}, "discovery server 10.0.0.1:11811"),
    ],
)
def test_where_nodes_are_found(environment: dict[str, str], found: str) -> None:
    assert levels(environment)["discovery"] is Level.OK
    assert found in text("discovery", environment)


@pytest.mark.parametrize(
    ("environment", "name", "level"),
    [
        ({"ROS_DOMAIN_ID": "233"}, "domain", Level.ERROR),
        ({"ROS_DOMAIN_ID": "150"}, "domain", Level.WARNING),
        ({"RMW_IMPLEMENTATION": "rmw_nonsense_cpp"}, "ros", Level.ERROR),
        ({"ROS_DISCOVERY_SERVER": "10.0.0.1:11811"}, "discovery", Level.ERROR),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, "discovery", Level.WARNING),
        ({"FASTDDS_DEFAULT_PROFILES_FILE": "/no/such.xml"}, "discovery", Level.WARNING),
    ],
)
def test_what_does_not_work(environment: dict[str, str], name: str, level: Level) -> None:
    found = levels(environment)
    assert found.pop(name) is level
    assert set(found.values()) == {Level.OK}


def test_both_distributions_own_the_same_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    for name in ("dock_gateway", "dock_gateway_core"):
        assert find_twin_fault() is None
        folder = tmp_path / f"{name}-1.0.dist-info"
        folder.mkdir()
        folder.joinpath("METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    assert "`pip uninstall dock-gateway dock-gateway-core`" in (find_twin_fault() or "")


def test_settings() -> None:
    assert check_settings(Settings(), {"DOCK_GATEWAY_PORT": "8000"}).level is Level.OK
    misspelled = check_settings(Settings(), {"DOCK_GATEWAY_PROT": "8000"})
    assert misspelled.level is Level.WARNING
    assert "Did you mean DOCK_GATEWAY_PORT?" in misspelled.text
    exposed = check_settings(Settings(host="0.0.0.0"), {})
    assert exposed.level is Level.ERROR
    assert "--authentication" in exposed.text
