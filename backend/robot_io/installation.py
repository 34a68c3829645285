"""Finds in its files what is installed of ROS, and what is missing.

Nothing of ROS is imported: a ROS that does not fit ends the process.
"""

import os
import re
import sys
import sysconfig
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.machinery import EXTENSION_SUFFIXES, PathFinder
from pathlib import Path
from xml.etree import ElementTree

# The packages of messages without which neither the gateway nor the docking nodes start.
MESSAGES = (
    "action_msgs",
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "nav_msgs",
    "rcl_interfaces",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
    "unique_identifier_msgs",
)
# The package of the actions that the docking nodes offer.
DOCKING = "action_tutorials_interfaces"
# The variables by which a sourced ROS installation is found.
SOURCED = ("PYTHONPATH", "AMENT_PREFIX_PATH", "LD_LIBRARY_PATH")
WHEEL = re.compile(r"ros_(\w+?)_rclpy-.*\.dist-info")
INDEX = Path("share/ament_index/resource_index/rmw_typesupport")
PYTHON = f"Python {sys.version_info.major}.{sys.version_info.minor}"


@dataclass(frozen=True)
class Installation:
    """The ROS that Python finds.

    Attributes:
        rclpy: The folder of rclpy.
        wheels: Whether it was installed into the Python environment; otherwise it was sourced.
        distribution: Such as `jazzy`; empty if it is not known.
        version: The version of rclpy; empty if it is not known.
        middlewares: The RMW implementations that can be used, such as `rmw_fastrtps_cpp`; empty if they are not known.
    """

    rclpy: Path
    wheels: bool
    distribution: str
    version: str
    middlewares: tuple[str, ...]

    @property
    def prefix(self) -> Path:
        """The folder where it is installed, such as `/opt/ros/jazzy`."""
        return _prefix(self.rclpy)

    @property
    def source(self) -> str:
        """The source of the installation, in words."""
        return f"the environment {sys.prefix}" if self.wheels else f"the sourced installation in {self.prefix}"


def find_installation(environment: Mapping[str, str]) -> Installation | None:
    """Return the ROS that Python finds, whether it works or not; None if there is none."""
    rclpy = find_folder("rclpy")
    if rclpy is None:
        return None
    prefix = _prefix(rclpy)
    wheels = rclpy.is_relative_to(sys.prefix)
    named = (match[1] for each in rclpy.parent.glob("ros_*_rclpy-*.dist-info") if (match := WHEEL.match(each.name)))
    distribution = (next(named, "") if wheels else "") or environment.get("ROS_DISTRO", "")
    sourced = environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    prefixes = [prefix] if wheels else [prefix, *map(Path, filter(None, sourced))]
    found = {each.name for each in prefixes if each.is_dir() for each in each.joinpath(INDEX).glob("rmw_*")}
    return Installation(rclpy, wheels, distribution, _version(prefix), tuple(sorted(found - {"rmw_implementation"})))


def find_package_fault(environment: Mapping[str, str], packages: Iterable[str] = MESSAGES) -> str | None:
    """Return what is missing of rclpy and of packages of messages, and what mends it; None if nothing is.

    Args:
        environment: The variables.
        packages: The packages of messages that are needed.
    """
    if find_folder("rclpy") is None:
        for prefix in find_rclpy_versions(environment):
            if prefix.joinpath("setup.bash").is_file():
                return f"ROS is in {prefix}, but PYTHONPATH does not say so: run `source {prefix}/setup.bash`"
        return f"there is no rclpy for {sys.executable}: {_install('rclpy[fastrtps]', environment)}"
    faults = (
        _find_misfit("rclpy", "_rclpy_pybind11", environment),
        *(_find_misfit(package, f"{package}_s__rosidl_typesupport_c", environment) for package in packages),
    )
    return next(filter(None, faults), None)


def _find_misfit(package: str, module: str, environment: Mapping[str, str]) -> str | None:
    """Return why a package cannot be imported: it is missing, or was made for another Python."""
    folder = find_folder(package)
    if folder is None:
        return f"the ROS package {package} is not installed: {_install(package, environment)}"
    if any((folder / f"{module}{suffix}").is_file() for suffix in EXTENSION_SUFFIXES):
        return None
    return f"the ROS package {package} in {folder.parent} is not for {PYTHON}: {mend(package, environment)}"


def mend(package: str, environment: Mapping[str, str]) -> str:
    """Return what to do about a package that does not work: a clause that ends a sentence."""
    folder = find_folder(package)
    for path in filter(None, environment.get("PYTHONPATH", "").split(os.pathsep)):
        if folder is not None and folder.is_relative_to(Path(path).absolute()):
            if not _has_wheels():
                return (
                    "open a new terminal, and source only the ROS whose Python made this environment (docs/install.md)"
                )
            return f"PYTHONPATH names that folder; run `unset {' '.join(SOURCED)}` and start again"
    return f"reinstall it; {_install(package, environment)}"


def find_mixture_fault(environment: Mapping[str, str]) -> str | None:
    """Return that two ROS are there, whose libraries would mix, and what mends it; None if not.

    One is sourced next to the ROS wheels, or two distributions are sourced, which differ in the first number of rclpy.
    """
    installation = find_installation(environment)
    if installation is None or installation.wheels:
        return None
    versions = find_rclpy_versions(environment)
    if len({version.partition(".")[0] for version in versions.values()}) > 1:
        listed = " and ".join(f"{prefix} (rclpy {version})" for prefix, version in versions.items())
        return f"several ROS distributions are sourced, {listed}: open a new terminal, and source one of them"
    if not _has_wheels():
        return None
    return (
        f"ROS is there twice, as wheels in the environment {sys.prefix} and as {installation.source}: run `unset "
        f"{' '.join(SOURCED)}`, or use an environment with dock-gateway-core (docs/install.md)"
    )


def find_middleware_fault(environment: Mapping[str, str]) -> str | None:
    """Return that RMW_IMPLEMENTATION names one that is not installed, and what mends it; None if it does not."""
    installation, wanted = find_installation(environment), environment.get("RMW_IMPLEMENTATION", "")
    if installation is None or not wanted or wanted in (installation.middlewares or (wanted,)):
        return None
    package = f"ros-{installation.distribution or '$ROS_DISTRO'}-{wanted.replace('_', '-')}"
    install = "" if installation.wheels else f", or install it with `sudo apt-get install {package}`"
    return (
        f"RMW_IMPLEMENTATION is {wanted}, but {installation.source} has only "
        f"{' and '.join(installation.middlewares)}: run `unset RMW_IMPLEMENTATION`{install}"
    )


def _install(package: str, environment: Mapping[str, str]) -> str:
    """Return how a package is installed: a clause that ends a sentence."""
    if package == DOCKING:
        return "run `make setup` in a clone of dock-gateway, or build it with `colcon build` and source the workspace"
    name = f"ros-jazzy-{package.replace('_', '-')}"
    if distribution := environment.get("ROS_DISTRO"):
        apt = name.partition("[")[0].replace("jazzy", distribution)
        return f"run `sudo apt-get install {apt}`, or `make setup` in a clone of dock-gateway where no ROS is sourced"
    return f"run `make setup` in a clone of dock-gateway, or `pip install '{name}'`, or source a ROS installation"


def find_rclpy_versions(environment: Mapping[str, str]) -> dict[Path, str]:
    """Return the prefixes with an rclpy that the variables of a sourced installation name, and its version there."""
    listed = {name: [Path(each) for each in environment.get(name, "").split(os.pathsep) if each] for name in SOURCED}
    python, ament, libraries = (listed[name] for name in SOURCED)
    prefixes = [*ament, *(_prefix(each / "rclpy") for each in python), *(each.parent for each in libraries)]
    found = {each.absolute(): _version(each) for each in prefixes}
    return {prefix: version for prefix, version in found.items() if version}


def find_setup(package: str, installation: Installation) -> Path:
    """Return the file to source for a package: that of its workspace, or of the installation."""
    folder = find_folder(package)
    prefixes = [] if folder is None else [_prefix(folder).parent, _prefix(folder)]
    found = (each / "setup.bash" for each in prefixes if each.joinpath("setup.bash").is_file())
    return next(found, installation.prefix / "setup.bash")


def _has_wheels() -> bool:
    """Return whether ROS wheels are installed in this Python environment."""
    return any(WHEEL.match(each.name) for each in Path(sysconfig.get_path("purelib")).iterdir())


def find_folder(package: str) -> Path | None:
    """Return the folder of a Python package; None if it is not installed."""
    spec = PathFinder.find_spec(package)
    if spec is None or spec.origin is None or spec.submodule_search_locations is None:
        return None
    return Path(spec.origin).parent


def _prefix(package: Path) -> Path:
    """Return the prefix of an installation: `/opt/ros/jazzy` of `/opt/ros/jazzy/lib/python3.12/site-packages/rclpy`."""
    return package.parents[3] if len(package.parents) > 3 else package.parent


def _version(prefix: Path) -> str:
    try:
        found = ElementTree.parse(prefix / "share/rclpy/package.xml").findtext("version")  # noqa: S314 - ROS's own file
    except (OSError, ElementTree.ParseError):
        return ""
    return found or ""
