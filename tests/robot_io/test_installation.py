"""What is installed of ROS, and what is missing."""

import sys
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest

from robot_io.installation import (
    INDEX,
    find_installation,
    find_middleware_fault,
    find_mixture_fault,
    find_package_fault,
)


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only folder in which Python looks for packages: that of a sourced installation."""
    folder = tmp_path / "lib/python3/site-packages"
    folder.mkdir(parents=True)
    monkeypatch.setattr(sys, "path", [str(folder)])
    return folder


def add_package(site: Path, name: str, module: str, suffix: str = EXTENSION_SUFFIXES[0]) -> None:
    folder = site / name
    folder.mkdir()
    folder.joinpath("__init__.py").touch()
    folder.joinpath(f"{module}{suffix}").touch()


def add_middleware(prefix: Path, name: str) -> None:
    index = prefix / INDEX
    index.mkdir(parents=True, exist_ok=True)
    index.joinpath(name).touch()


def test_this_environment_works() -> None:
    installation = find_installation({})
    assert installation is not None
    assert (installation.wheels, installation.distribution) == (True, "jazzy")
    assert installation.version.startswith("7.1.")
    assert installation.middlewares == ("rmw_fastrtps_cpp",)
    assert find_package_fault({}) is None
    assert find_mixture_fault({}) is None
    assert find_middleware_fault({"RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}) is None


def test_a_sourced_installation_and_its_overlay(site: Path, tmp_path: Path) -> None:
    add_package(site, "rclpy", "_rclpy_pybind11")
    add_middleware(tmp_path, "rmw_fastrtps_cpp")
    add_middleware(tmp_path / "overlay", "rmw_zenoh_cpp")
    share = tmp_path / "share/rclpy"
    share.mkdir()
    share.joinpath("package.xml").write_text("<package><version>9.1.0</version></package>")
    environment = {"ROS_DISTRO": "kilted", "AMENT_PREFIX_PATH": f"{tmp_path}/overlay:{tmp_path}"}
    installation = find_installation(environment)
    assert installation is not None
    assert (installation.wheels, installation.distribution, installation.version) == (False, "kilted", "9.1.0")
    assert installation.middlewares == ("rmw_fastrtps_cpp", "rmw_zenoh_cpp")
    assert str(tmp_path) in installation.source
    assert find_middleware_fault(environment | {"RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}) is None
    fault = find_middleware_fault(environment | {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}) or ""
    assert "`unset RMW_IMPLEMENTATION`" in fault
    assert "ros-kilted-rmw-cyclonedds-cpp" in fault


def test_wheels_and_a_sourced_installation_do_not_mix(site: Path) -> None:
    assert find_mixture_fault({}) is None
    add_package(site, "rclpy", "_rclpy_pybind11")
    assert "run `unset PYTHONPATH AMENT_PREFIX_PATH LD_LIBRARY_PATH`" in (find_mixture_fault({}) or "")


def add_rclpy(prefix: Path, version: str) -> None:
    share = prefix / "share/rclpy"
    share.mkdir(parents=True)
    share.joinpath("package.xml").write_text(f"<package><version>{version}</version></package>")
    prefix.joinpath("setup.bash").touch()


def test_two_distributions_that_are_sourced_in_one_terminal(site: Path, tmp_path: Path) -> None:
    add_package(site, "rclpy", "_rclpy_pybind11")
    add_rclpy(tmp_path, "7.1.5")
    add_rclpy(tmp_path / "overlay", "7.1.6")
    add_rclpy(tmp_path / "kilted", "9.1.2")
    environment = {"PYTHONPATH": str(site), "AMENT_PREFIX_PATH": f"{tmp_path}/overlay:{tmp_path}"}
    assert "as wheels" in (find_mixture_fault(environment) or "")
    environment["LD_LIBRARY_PATH"] = f"{tmp_path}/lib:{tmp_path}/kilted/lib"
    fault = find_mixture_fault(environment) or ""
    assert f"{tmp_path} (rclpy 7.1.5)" in fault
    assert f"{tmp_path}/kilted (rclpy 9.1.2): open a new terminal" in fault


def test_an_installation_that_is_sourced_by_half(site: Path, tmp_path: Path) -> None:
    add_rclpy(tmp_path, "7.1.5")
    fault = find_package_fault({"ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": str(tmp_path)}) or ""
    assert f"run `source {tmp_path}/setup.bash`" in fault


@pytest.mark.parametrize(
    ("distribution", "command"), [("", "pip install 'ros-jazzy-rclpy[fastrtps]'"), ("kilted", "ros-kilted-rclpy`")]
)
def test_no_rclpy(site: Path, distribution: str, command: str) -> None:
    fault = find_package_fault({"ROS_DISTRO": distribution}) or ""
    assert "there is no rclpy" in fault
    assert command in fault


def test_a_package_of_another_python(site: Path) -> None:
    add_package(site, "rclpy", "_rclpy_pybind11", ".cpython-27-x86_64-linux-gnu.so")
    fault = find_package_fault({"PYTHONPATH": f":{site}"}) or ""
    assert f"rclpy in {site} is not for Python 3." in fault
    assert "`unset PYTHONPATH AMENT_PREFIX_PATH LD_LIBRARY_PATH`" in fault


def test_messages_that_are_missing_or_of_another_python(site: Path) -> None:
    add_package(site, "rclpy", "_rclpy_pybind11")
    assert "sensor_msgs is not installed" in (find_package_fault({}, ["sensor_msgs"]) or "")
    assert "colcon build" in (find_package_fault({}, ["action_tutorials_interfaces"]) or "")
    add_package(site, "sensor_msgs", "no_extension")
    assert "sensor_msgs in" in (find_package_fault({}, ["sensor_msgs"]) or "")
