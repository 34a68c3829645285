"""The package of our docking actions, where a sourced ROS installation lacks it: compiled once, into the user's cache.

Nothing of ROS is imported.
"""

import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping
from importlib.metadata import distributions
from pathlib import Path
from typing import IO

from robot_io.installation import DOCKING, SOURCED, Installation, find_folder, find_installation

FOLDER = Path(__file__).parent
# The package's sources: in the wheel, and in a clone.
SOURCES = (FOLDER / DOCKING, FOLDER.parent / DOCKING)
# What the rosidl generators import, and the packages of Debian and Ubuntu that bring it.
MODULES = "catkin_pkg, em, lark, numpy"
MODULE_PACKAGES = ("python3-catkin-pkg-modules", "python3-empy", "python3-lark", "python3-numpy")
# What make and ninja write before each step: "[ 12%]" and "[5/60]".
STEP = re.compile(r"\[ *(\d+)(?:/(\d+)|%)\]")


class CompileError(Exception):
    """The package cannot be compiled. The message says why, and what to do."""


def use_compiled(environment: Mapping[str, str]) -> str | None:  # noqa: RET503 - it ends as another program
    """Start this process again with the compiled package, if ROS is sourced and lacks it.

    It is compiled first if this is the first start. Progress goes to standard error.

    Returns:
        Why that is not possible, and what to do. None if it is not needed.
    """
    installation = find_installation(environment)
    sources = next((each for each in SOURCES if each.joinpath("CMakeLists.txt").is_file()), None)
    if find_folder(DOCKING) is not None or installation is None or installation.wheels or sources is None:
        return None
    try:
        prefix = _provide(sources, installation, environment)
    except CompileError as error:
        return str(error)
    except KeyboardInterrupt:
        raise SystemExit(130) from None
    overlay = dict(zip(SOURCED, (_site(prefix), prefix, prefix / "lib"), strict=True))
    if str(prefix) in environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        return f"{sys.executable} does not look into PYTHONPATH, where {DOCKING} is: start it without -E and -I"
    variables = {name: f"{path}{os.pathsep}{environment.get(name, '')}".rstrip(":") for name, path in overlay.items()}
    sys.stdout.flush()
    os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], {**environment, **variables})  # noqa: S606


def _provide(sources: Path, installation: Installation, environment: Mapping[str, str]) -> Path:
    """Return the prefix with the compiled package."""
    name = _name(sources, installation)
    try:
        cache = Path(environment.get("XDG_CACHE_HOME") or Path.home() / ".cache").absolute() / "dock-gateway"
        prefix = cache / name
        if _site(prefix) is None:
            cache.mkdir(mode=0o700, parents=True, exist_ok=True)
            with cache.joinpath(f"{name}.lock").open("w") as lock:
                _wait_for(lock)
                if _site(prefix) is None:
                    _compile(sources, prefix, installation, environment, lock)
    except (OSError, RuntimeError) as error:
        raise CompileError(
            f"the ROS package {DOCKING} is not installed and cannot be compiled into the user's cache ({error}): "
            "run `export XDG_CACHE_HOME=` with a folder that can be written, or build it with `colcon build`"
        ) from None
    return prefix


def _name(sources: Path, installation: Installation) -> str:
    """Return a name that differs where what is compiled would differ."""
    numpy = next((each.version for each in distributions(name="numpy")), "")
    state = hashlib.sha256(f"{installation.prefix} {installation.version} {numpy}".encode())
    for path in sorted([sources / "CMakeLists.txt", sources / "package.xml", *sources.glob("action/*.action")]):
        state.update(path.name.encode() + b"\0" + path.read_bytes())
    return f"{installation.distribution or 'ros'}-{sysconfig.get_config_var('SOABI')}-{state.hexdigest()[:12]}"


def _site(prefix: Path) -> Path | None:
    """Return the folder from which Python imports the package; None if it is not there."""
    return next((path.parents[1] for path in prefix.glob(f"**/{DOCKING}/__init__.py")), None)


def _wait_for(lock: IO[str]) -> None:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        _say(f"Waiting for another program that compiles {DOCKING} …\n")
        fcntl.flock(lock, fcntl.LOCK_EX)


def _compile(
    sources: Path, prefix: Path, installation: Installation, environment: Mapping[str, str], lock: IO[str]
) -> None:
    """Compile the package next to its prefix, and move it there when it is complete."""
    prefixes = [str(installation.prefix), *filter(None, environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep))]
    python = _find_python(environment)
    _require_tools(prefixes, installation, environment, python)
    variables = {
        **{name: value for name, value in environment.items() if name not in {"DESTDIR", "MAKEFLAGS", "VIRTUAL_ENV"}},
        "AMENT_PREFIX_PATH": os.pathsep.join(prefixes),
        "PYTHONHASHSEED": "0",  # the generators write includes in the order of a set
    }
    building, log = Path(f"{prefix}.building"), Path(f"{prefix}.log")
    definitions = {
        "BUILD_TESTING": "OFF",
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_INSTALL_PREFIX": building / "install",
        "CMAKE_PREFIX_PATH": ";".join(prefixes),
        "Python3_EXECUTABLE": python,
    }
    parallel = str(len(os.sched_getaffinity(0)))
    configure = ["cmake", "-S", str(sources), "-B", str(building / "build")]
    configure += [f"-D{name}={value}" for name, value in definitions.items()]
    build = ["cmake", "--build", str(building / "build"), "--target", "install", "--parallel", parallel]
    _say(f"Compiling {DOCKING} for ROS 2 {installation.distribution.capitalize()} (a minute, once) …")
    shutil.rmtree(building, ignore_errors=True)
    try:
        with log.open("w") as output:
            done = all(_run(command, variables, output, lock) for command in (configure, build))
        if not done or _site(building / "install") is None:
            raise CompileError(
                f"compiling the ROS package {DOCKING} failed, and {log} says why: mend that and start again, or build "
                "it with `colcon build` and source the workspace"
            )
        shutil.rmtree(prefix, ignore_errors=True)
        building.joinpath("install").rename(prefix)
        log.unlink()
        _say(" done.")
    finally:
        _say("\n")
        shutil.rmtree(building, ignore_errors=True)


def _find_python(environment: Mapping[str, str]) -> str | None:
    """Return a Python with the modules of the generators: the machine's or this one; None if neither has them."""
    machine = shutil.which("python{}.{}".format(*sys.version_info), path=str(Path(sys.base_prefix, "bin")))
    for python in filter(None, (machine, sys.executable)):
        command = [python, "-c", f"import {MODULES}"]
        tried = subprocess.run(command, env=environment, capture_output=True, check=False)  # noqa: S603
        if tried.returncode == 0:
            return python
    return None


def _require_tools(
    prefixes: list[str], installation: Installation, environment: Mapping[str, str], python: str | None
) -> None:
    """Raise `CompileError` with what is missing for a compilation."""

    def found(*programs: str) -> bool:
        return any(shutil.which(each, path=environment.get("PATH")) for each in programs)

    generators = "rosidl-default-generators"
    there = {
        "cmake": found("cmake"),
        "g++": bool(environment.get("CXX")) or found("c++", "g++", "clang++"),
        "make": found("make"),
        "python3-dev": Path(sysconfig.get_path("include"), "Python.h").is_file(),
        " ".join(MODULE_PACKAGES): python is not None,
        f"ros-{installation.distribution or '$ROS_DISTRO'}-{generators}": any(
            Path(each, "share", generators.replace("-", "_")).is_dir() for each in prefixes
        ),
    }
    if missing := " ".join(package for package, is_there in there.items() if not is_there):
        raise CompileError(
            f"the ROS package {DOCKING} is not installed, and something that compiles it is missing: run `sudo apt-get "
            f"install {missing}` and start again, or build it with `colcon build` and source the workspace"
        )


def _run(command: list[str], environment: Mapping[str, str], log: IO[str], lock: IO[str]) -> bool:
    """Run a command, log what it writes, and say how far it is in steps of 20 %. Return whether it succeeded."""
    said = 0
    # The compiler inherits the lock: if it outlives this process, no other one starts next to it.
    with subprocess.Popen(  # noqa: S603
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        pass_fds=(lock.fileno(),),
    ) as process:
        for line in process.stdout or ():
            log.write(line)
            if step := STEP.match(line):
                share = 100 * int(step[1]) // int(step[2] or 100)
                if share // 20 > said // 20:
                    said = share
                    _say(f" {share // 20 * 20} %")
    return process.returncode == 0


def _say(text: str) -> None:
    sys.stderr.write(text)
    sys.stderr.flush()
