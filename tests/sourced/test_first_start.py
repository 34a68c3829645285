"""First starts on a sourced ROS that lacks our docking actions, with a real compiler: `make test-ros`."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from robot_io.installation import DOCKING, SOURCED, find_folder
from tests.support.processes import BIN, PATIENT_CLIENT, Process, free_port, ros_environment

COMPILING, WAITING = f"Compiling {DOCKING}", "Waiting for another program"


@pytest.fixture
def environment(domain: int, tmp_path: Path) -> dict[str, str]:
    """The variables of a terminal in which the workspace with our docking actions is not sourced."""
    folder = find_folder(DOCKING)
    assert folder is not None
    prefix = folder.parents[3]
    variables = ros_environment(domain, XDG_CACHE_HOME=str(tmp_path / "cache"))
    for name in (*SOURCED, "CMAKE_PREFIX_PATH"):
        paths = variables.pop(name, "").split(os.pathsep)
        variables[name] = os.pathsep.join(path for path in paths if not Path(path).is_relative_to(prefix))
    return variables


def test_two_first_starts_and_a_docking(environment: dict[str, str]) -> None:
    port = str(free_port())
    with (
        Process(str(BIN / "dock-gateway"), "up", "--port", port, env=environment) as up,
        Process(str(BIN / "fibonacci_action_server"), env=environment) as server,
    ):
        up.wait_for("is ready", timeout=300)
        assert (COMPILING in up.output) != (COMPILING in server.output)
        (cached,) = [path for path in Path(environment["XDG_CACHE_HOME"], "dock-gateway").iterdir() if path.is_dir()]
        assert list(cached.glob(f"lib/python*/*-packages/{DOCKING}/action"))
        docked = subprocess.run(
            [BIN / "dock-gateway", "dock"],
            env=environment | {"DOCK_GATEWAY_URL": f"http://127.0.0.1:{port}"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert docked.returncode == 0, docked.stdout + docked.stderr
        again = subprocess.run(
            [BIN / "fibonacci_action_client", *PATIENT_CLIENT],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert again.returncode == 0, again.stdout + again.stderr
        assert COMPILING not in again.stderr


def test_without_a_compiler(environment: dict[str, str], tmp_path: Path) -> None:
    environment["PATH"] = str(tmp_path)
    assert shutil.which("c++", path=environment["PATH"]) is None
    refused = subprocess.run([BIN / "docking_server"], env=environment, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    (line,) = refused.stderr.splitlines()
    assert "sudo apt-get install cmake g++ make" in line
