"""`dock-gateway service install`: systemd takes the units, and they find the ROS of the shell."""

import getpass
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from dock_gateway.cli.service import service_variables
from dock_gateway.cli.service_unit import find_unreadable, system_unit

needs_systemd = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")


def install(*arguments: str, **environment: str) -> str:
    result = CliRunner().invoke(main, ("service", "install", *arguments), env=environment)
    assert result.exit_code == 0, result.output
    return result.output


def refusal(*arguments: str, **environment: str) -> str:
    result = CliRunner().invoke(main, ("service", "install", *arguments), env=environment)
    assert result.exit_code != 0
    return result.output.splitlines()[-1]


def analyze(*arguments: str, folder: Path) -> str:
    environment = {**os.environ, "XDG_RUNTIME_DIR": str(folder)}
    result = subprocess.run(
        ["systemd-analyze", *arguments], env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    assert result.returncode == 0, result.stderr
    assert "dock-gateway" not in result.stderr, result.stderr  # what is said of other units of the machine is not ours
    return result.stdout


@needs_systemd
@pytest.mark.parametrize("own", [True, False], ids=["a user of its own", "a given user"])
def test_a_service_of_the_machine_is_valid_and_confined(own: bool, tmp_path: Path) -> None:
    """`--threshold`: an exposure of 2.0 at most, where 10 is a program without any limit."""
    unit = tmp_path / "dock-gateway.service"
    odd = {"ROS_DOMAIN_ID": "7", "ROS_STATIC_PEERS": 'a"b\\c%d$e\nf'}
    unit.write_text(system_unit(Path("/bin/true"), None if own else getpass.getuser(), odd))
    analyze("verify", "--man=no", str(unit), folder=tmp_path)
    analyze("security", "--offline=true", "--threshold=20", "--no-pager", str(unit), folder=tmp_path)


def test_a_service_of_a_user_is_written_once_with_its_settings(tmp_path: Path) -> None:
    environment = {"XDG_CONFIG_HOME": str(tmp_path), "ROS_DOMAIN_ID": "7", "DOCK_GATEWAY_PORT": "9000"}
    said = install("--user", **environment)
    assert "systemctl --user enable --now dock-gateway" in said
    assert "DOCK_GATEWAY_PORT" in said
    unit, settings = tmp_path / "systemd/user/dock-gateway.service", tmp_path / "dock-gateway/settings.env"
    assert unit.read_text() == install("--user", "--print", **environment)
    assert 'Environment="ROS_DOMAIN_ID=7"\n' in unit.read_text()
    assert 'dock-gateway" serve\n' in unit.read_text()
    assert "9000" not in unit.read_text()
    assert settings.stat().st_mode & 0o777 == 0o600
    if shutil.which("systemd-analyze"):
        analyze("verify", "--user", "--man=no", str(unit), folder=tmp_path)

    settings.write_text("DOCK_GATEWAY_PORT=9000\n")
    install("--user", **environment)
    assert settings.read_text() == "DOCK_GATEWAY_PORT=9000\n"


def test_a_sourced_ros_is_found_again() -> None:
    shell = {
        "AMENT_PREFIX_PATH": "/ws:/opt/ros/jazzy",
        "PYTHONPATH": "/opt/ros/jazzy/lib",
        "ROS_LOG_DIR": "/x",
        "A": "b",
    }
    assert service_variables(shell) == {"AMENT_PREFIX_PATH": "/ws:/opt/ros/jazzy", "PYTHONPATH": "/opt/ros/jazzy/lib"}


def test_folders_that_are_closed_to_the_service(tmp_path: Path) -> None:
    closed = tmp_path / "closed"
    (closed / "bin").mkdir(parents=True, mode=0o755)
    closed.chmod(0o700)
    for folder in tmp_path.parents:
        if not folder.stat().st_mode & 0o001:
            break
    else:
        assert find_unreadable([closed / "bin/python"], None) == closed
    assert find_unreadable([closed / "bin/python"], getpass.getuser()) is None
    assert find_unreadable([Path("/usr/bin/env")], None) is None


def test_what_is_refused(tmp_path: Path) -> None:
    assert "`sudo useradd --system" in refusal("--user-name", "no-such-user")
    assert "--user-name does not go with it" in refusal("--user", "--user-name", "ada")
    assert "`unset ROS_DOMAIN_ID`" in refusal("--user", ROS_DOMAIN_ID="233")
    blocked = tmp_path / "systemd"
    blocked.touch()
    assert f"cannot write {blocked}" in refusal("--user", XDG_CONFIG_HOME=str(tmp_path))
