"""The docking actions that a sourced ROS lacks are compiled once; `make test-ros` does so with a real compiler."""

import os
import sys
import threading
from collections.abc import Callable
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import NoReturn

import pytest

from robot_io import docking_messages
from robot_io.docking_messages import use_compiled
from robot_io.installation import DOCKING
from tests.support.waiting import wait_until

# Installs a package when it is called the second time, with --build. It writes down each call.
CMAKE = f"""#!/bin/sh
echo "$@" >>"$CALLS"
while [ -e "$CALLS.wait" ]; do sleep 0.02; done
case "$*" in
*--build*)
    echo '[100%] Built'
    mkdir -p "$2/../install/lib/{DOCKING}"
    touch "$2/../install/lib/{DOCKING}/__init__.py" ;;
*) echo '[ 50%] Configured'; mkdir -p "$4"; echo "see ${{FAULT:=nothing}}"; [ "$FAULT" = nothing ] ;;
esac
"""


class Restarted(Exception):
    """The process would start again."""


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """A sourced ROS without our docking actions, on a machine that can compile."""
    site = tmp_path / "ros/lib/python3/site-packages"
    for package, module in {"rclpy": "_rclpy_pybind11", "catkin_pkg": "", "em": "", "lark": "", "numpy": ""}.items():
        site.joinpath(package).mkdir(parents=True)
        site.joinpath(package, "__init__.py").touch()
        site.joinpath(package, f"{module}{EXTENSION_SUFFIXES[0]}").touch()
    tmp_path.joinpath("ros/share/rosidl_default_generators").mkdir(parents=True)
    programs = tmp_path / "bin"
    programs.mkdir()
    for name in ("cmake", "c++", "make"):
        programs.joinpath(name).write_text(CMAKE)
        programs.joinpath(name).chmod(0o755)
    header = tmp_path / "include/Python.h"
    header.parent.mkdir()
    header.touch()
    monkeypatch.setattr(docking_messages.sysconfig, "get_path", lambda _: str(header.parent))
    monkeypatch.setattr(sys, "path", [str(site)])

    def start_again(program: str, arguments: list[str], variables: dict[str, str]) -> NoReturn:
        assert (program, arguments) == (sys.executable, [sys.executable, *sys.orig_argv[1:]])
        raise Restarted(variables)

    monkeypatch.setattr(os, "execve", start_again)
    return {
        "PATH": f"{programs}:{os.defpath}",
        "PYTHONPATH": str(site),
        "ROS_DISTRO": "jazzy",
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "CALLS": str(tmp_path / "calls"),
    }


def variables(environment: dict[str, str]) -> dict[str, str]:
    """Those with which the process would start again."""
    with pytest.raises(Restarted) as restarted:
        use_compiled(environment)
    found: dict[str, str] = restarted.value.args[0]
    return found


def calls(environment: dict[str, str]) -> int:
    """How often CMake was called."""
    path = Path(environment["CALLS"])
    return len(path.read_text().splitlines()) if path.exists() else 0


def files(environment: dict[str, str]) -> list[str]:
    """What is in the cache."""
    return [path.name for path in Path(environment["XDG_CACHE_HOME"]).glob("dock-gateway/*")]


def test_the_first_start_compiles_and_the_second_does_not(
    environment: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    first = variables(environment)
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"Compiling {DOCKING} for ROS 2 Jazzy (a minute, once) … 40 % 100 % done."
    prefix = Path(first["AMENT_PREFIX_PATH"])
    assert first["PYTHONPATH"] == f"{prefix / 'lib'}:{environment['PYTHONPATH']}"
    assert first["LD_LIBRARY_PATH"] == str(prefix / "lib")
    assert prefix.name.startswith("jazzy-cpython-")
    assert variables(environment) == first
    assert capsys.readouterr().err == ""
    assert calls(environment) == 2
    assert sorted(files(environment)) == [prefix.name, f"{prefix.name}.lock"]
    assert "without -E and -I" in (use_compiled(first) or "")


@pytest.mark.parametrize(
    ("break_it", "package"),
    [
        (lambda folder: folder.joinpath("bin/cmake").unlink(), "cmake"),
        (lambda folder: folder.joinpath("bin/c++").unlink(), "g++"),
        (lambda folder: folder.joinpath("include/Python.h").unlink(), "python3-dev"),
        (lambda folder: folder.joinpath("ros/share/rosidl_default_generators").rmdir(), "ros-jazzy-rosidl-default-gen"),
        (
            lambda folder: folder.joinpath("ros/lib/python3/site-packages/em/__init__.py").write_text("0 / 0"),
            "python3-empy",
        ),
    ],
    ids=["cmake", "compiler", "headers", "generators", "modules"],
)
def test_without_what_compiles(
    environment: dict[str, str], tmp_path: Path, break_it: Callable[[Path], None], package: str
) -> None:
    break_it(tmp_path)
    environment["PATH"] = str(tmp_path / "bin")
    sentence = use_compiled(environment) or ""
    assert f"the ROS package {DOCKING} is not installed" in sentence
    assert "run `sudo apt-get install " in sentence
    assert package in sentence
    assert calls(environment) == 0


def test_a_compilation_that_fails_leaves_a_log_alone(environment: dict[str, str]) -> None:
    sentence = use_compiled(environment | {"FAULT": "the sun"}) or ""
    log = Path(sentence.partition(" failed, and ")[2].partition(" says why")[0])
    assert log.read_text().endswith("see the sun\n")
    assert sorted(files(environment)) == [f"{log.stem}.lock", log.name]
    variables(environment)
    assert log.name not in files(environment)


def test_a_cache_that_cannot_be_written(environment: dict[str, str], tmp_path: Path) -> None:
    tmp_path.joinpath("file").touch()
    sentence = use_compiled(environment | {"XDG_CACHE_HOME": str(tmp_path / "file")}) or ""
    assert f"{tmp_path}/file/dock-gateway" in sentence
    assert "run `export XDG_CACHE_HOME=`" in sentence


def test_two_starts_at_once_compile_once(environment: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    hold = Path(f"{environment['CALLS']}.wait")
    hold.touch()
    threads = [threading.Thread(target=variables, args=[environment]) for _ in range(2)]
    written = ""

    def waits() -> bool:
        nonlocal written
        written += capsys.readouterr().err
        return "Waiting for another program" in written and calls(environment) == 1

    for thread in threads:
        thread.start()
    try:
        wait_until(waits, "the second start waits")
    finally:
        hold.unlink()
        for thread in threads:
            thread.join()
    assert calls(environment) == 2
