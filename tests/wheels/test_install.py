"""What a user does with the wheels in dist/, without a compiler, git and Node: `make test-wheels`."""

import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import httpx2
import pytest

import dock_gateway
from tests.support.gateway import CHARGING, ready_gateway
from tests.support.processes import Process, free_port

ROOT = Path(__file__).parents[2]
DIST = ROOT / "dist"
UV = shutil.which("uv") or str(ROOT / ".tools/uv/bin/uv")
PYTHON = str(Path(sys.base_prefix) / "bin" / "python{}.{}".format(*sys.version_info))
# Of the shell and of the tests, what no user's terminal has.
LEFT_OUT = (
    "VIRTUAL_ENV",
    "PYTHON",
    "LD_LIBRARY_PATH",
    "AMENT",
    "CMAKE",
    "COLCON",
    "ROS_",
    "RMW_",
    "_ROS_",
    "DOCK_GATEWAY",
)


@pytest.fixture
def environment(tmp_path: Path, domain: int) -> dict[str, str]:
    """The variables of an empty machine: uv is its only program."""
    programs = tmp_path / "bin"
    programs.mkdir()
    programs.joinpath("uv").symlink_to(UV)
    return {name: value for name, value in os.environ.items() if not name.startswith(LEFT_OUT)} | {
        "PATH": str(programs),
        "UV_TOOL_DIR": str(tmp_path / "tools"),
        "UV_TOOL_BIN_DIR": str(programs),
        "ROS_DOMAIN_ID": str(domain),
    }


def run(environment: dict[str, str], *command: str) -> str:
    """Run a program of that machine and return what it wrote."""
    program = shutil.which(command[0], path=environment["PATH"])
    assert program is not None, command[0]
    done = subprocess.run([program, *command[1:]], env=environment, capture_output=True, text=True, check=False)
    output = done.stdout + done.stderr
    assert done.returncode == 0, output
    return output


def test_install_dock_and_stop(environment: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert not [
        name for name in ("cc", "c++", "gcc", "g++", "git", "node") if shutil.which(name, path=environment["PATH"])
    ]
    port = free_port()
    url = f"http://127.0.0.1:{port}"
    start = time.monotonic()
    run(environment, "uv", "tool", "install", "--python", PYTHON, "--find-links", str(DIST), "dock-gateway")
    installed = time.monotonic()
    program = str(Path(environment["UV_TOOL_BIN_DIR"]) / "dock-gateway")
    with Process(program, "up", "--port", str(port), env=environment) as up:
        up.wait_for("is ready")
        ready = time.monotonic()
        run(environment | {"DOCK_GATEWAY_URL": url}, "dock-gateway", "dock")
        docked = time.monotonic()
        assert "<script" in httpx2.get(url).text
        up.send_signal(signal.SIGINT)
        assert up.wait() == 0
    times = f"installed in {installed - start:.1f} s, ready after {ready - start:.1f} s"
    with capsys.disabled():
        print(f"\n{times}, docked after {docked - start:.1f} s")


def test_messages_for_a_clone_without_a_compiler(environment: dict[str, str], tmp_path: Path) -> None:
    for name in ("bash", "dirname", "sed", "uname"):
        Path(environment["PATH"], name).symlink_to(str(shutil.which(name)))
    folder = tmp_path / "environment"
    run(environment, "uv", "venv", "--python", PYTHON, str(folder))
    arguments = (str(folder / "bin/python"), str(tmp_path / "compiled"), "backend/tf2_msgs")
    assert "those in dist/" in run(environment, str(ROOT / "scripts/install-interfaces"), *arguments)
    assert list(folder.glob("lib/python*/site-packages/tf2_msgs/__init__.py"))


def test_the_core_needs_nothing_of_ros(environment: dict[str, str], tmp_path: Path) -> None:
    folder = tmp_path / "environment"
    run(environment, "uv", "venv", "--python", PYTHON, str(folder))
    here = ("--python", str(folder / "bin/python"))
    run(environment, "uv", "pip", "install", *here, "--find-links", str(DIST), "dock-gateway-core")
    names = {line.partition("==")[0] for line in run(environment, "uv", "pip", "freeze", *here).splitlines()}
    assert "dock-gateway-core" in names
    (sources,) = folder.glob("lib/python*/site-packages/robot_io/action_tutorials_interfaces")
    assert {path.name for path in sources.iterdir()} == {"CMakeLists.txt", "action", "package.xml"}
    assert not [name for name in names if name.startswith(("ros-", "action-")) or name.endswith("-msgs")]
    version = run(environment | {"PATH": str(folder / "bin")}, "dock-gateway", "--version")
    assert version == f"dock-gateway, version {dock_gateway.__version__}\n"


def test_the_client_docks_without_ros_and_gateway(environment: dict[str, str], tmp_path: Path, domain: int) -> None:
    folder = tmp_path / "environment"
    run(environment, "uv", "venv", "--python", PYTHON, str(folder))
    here = ("--python", str(folder / "bin/python"))
    run(environment, "uv", "pip", "install", *here, "--no-build", "--find-links", str(DIST), "dock-gateway-client")
    names = {line.partition("==")[0] for line in run(environment, "uv", "pip", "freeze", *here).splitlines()}
    assert {"dock-gateway-client", "httpx2", "orjson", "websockets"} <= names
    assert not names & {"click", "dock-gateway", "fastapi", "numpy", "pydantic", "sqlalchemy"}
    assert not [name for name in names if name.startswith("ros-")]
    with ready_gateway(domain) as gateway:
        gateway.publish(CHARGING)
        here_only = environment | {"PATH": str(folder / "bin"), "DOCK_GATEWAY_URL": gateway.url}
        assert run(here_only, "python", str(ROOT / "examples/dock.py")).endswith("succeeded\n")


def test_a_hub_needs_nothing_of_ros(environment: dict[str, str], tmp_path: Path) -> None:
    folder = tmp_path / "environment"
    run(environment, "uv", "venv", "--python", PYTHON, str(folder))
    here = ("--python", str(folder / "bin/python"))
    how = ("--constraints", str(ROOT / "requirements.lock"), "--refresh-package", "dock-gateway-hub")
    run(environment, "uv", "pip", "install", *here, *how, "--find-links", str(DIST), "dock-gateway-hub")
    names = {line.partition("==")[0] for line in run(environment, "uv", "pip", "freeze", *here).splitlines()}
    assert not [name for name in names if name.startswith(("ros-", "action-")) or name.endswith("-msgs")]
    assert [path.name for path in folder.glob("bin/*dock*")] == ["dock-gateway"]
    only = environment | {"PATH": str(folder / "bin"), "HOME": str(tmp_path), "XDG_DATA_HOME": str(tmp_path)}
    assert '"keys"' in run(only, "dock-gateway", "hub", "key")
    assert "--nats" in run(only, "dock-gateway", "hub", "--help")
    assert '"/sites/{site}"' in run(only, "dock-gateway", "schema", "openapi", "--hub")
    assert "Usage" in run(only, "dock-gateway", "stop", "--help")
    for command in ("serve", "up", "schema openapi", "schema asyncapi"):
        done = subprocess.run(
            [folder / "bin/dock-gateway", *command.split()], env=only, capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr.count("\n"), done.stderr[:7]) == (1, 1, "Error: "), done.stderr


@pytest.mark.parametrize("name", ["dock_gateway", "dock_gateway_core", "dock_gateway_hub"])
def test_a_gateway_fits_beside_the_client(name: str) -> None:
    (gateway,) = DIST.glob(f"{name}-*.whl")
    (client,) = DIST.glob("dock_gateway_client-*.whl")
    with zipfile.ZipFile(gateway) as ours, zipfile.ZipFile(client) as its:
        assert not {*ours.namelist()} & {*its.namelist()}
        (metadata,) = [each for each in ours.namelist() if each.endswith(".dist-info/METADATA")]
        assert f"Requires-Dist: dock-gateway-client=={dock_gateway.__version__}\n" in ours.read(metadata).decode()
