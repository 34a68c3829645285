"""The ROS package action_tutorials_py: its setup, wheel, manifest, launch files and parameter files agree.

`make colcon-workspace` builds and runs it.
"""

import ast
import re
import sys
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
import yaml

import dock_gateway
import robot_io
from docking.core.parameter import NodeSettings, from_values, parameters_of
from docking.parameters import DockSettings, UndockSettings
from docking.programs import MODULES as MODULES_OF_PROGRAMS
from docking.simulation.parameters import SimulatorSettings
from tests.docking.imports import MODULES, ROS_PARTS, imported

# Imported where they are needed, and done without: the simulator has no camera then, and recordings are not replayed.
# What mcap decompresses with comes with it.
OPTIONAL = {"mcap", "lz4", "zstandard", "simplejpeg"}
PROJECT = Path(__file__).parents[2]
PACKAGE = PROJECT / "backend" / "action_tutorials_py"
SETTINGS: dict[str, type[NodeSettings]] = {
    "connect_to_charging_dock_action_server": DockSettings,
    "disconnect_from_charging_dock_action_server": UndockSettings,
    "dock_simulator": SimulatorSettings,
}
LAUNCH_FILES = sorted((PACKAGE / "launch").iterdir())
PARAMETER_FILES = sorted((PACKAGE / "config").iterdir())


def setup_arguments() -> dict[str, Any]:
    """The arguments of `setup(…)` that are literals."""
    calls = [node for node in ast.walk(ast.parse((PACKAGE / "setup.py").read_text())) if isinstance(node, ast.Call)]
    setup = next(call for call in calls if isinstance(call.func, ast.Name) and call.func.id == "setup")
    literals = {}
    for keyword in setup.keywords:
        try:
            literals[str(keyword.arg)] = ast.literal_eval(keyword.value)
        except ValueError:
            continue
    return literals


def project() -> dict[str, Any]:
    return tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]  # type: ignore[no-any-return]


def manifest() -> ET.Element:
    return ET.parse(PACKAGE / "package.xml").getroot()


def scripts() -> dict[str, str]:
    return {name: target for name, target in project()["scripts"].items() if target.startswith("docking.")}


def test_the_workspace_and_the_wheel_have_the_same_programs() -> None:
    entry_points = setup_arguments()["entry_points"]["console_scripts"]
    assert dict(re.split(" = ", entry) for entry in entry_points) == scripts()
    assert {file.name for file in (PACKAGE / "wheel").iterdir()} == set(scripts()) == set(MODULES_OF_PROGRAMS)


def test_there_is_one_version() -> None:
    arguments = setup_arguments()
    assert {arguments["version"], manifest().findtext("version")} == {dock_gateway.__version__}
    assert arguments["description"] + "." == manifest().findtext("description")


def test_the_manifest_names_every_package_that_is_imported() -> None:
    dependencies = {str(dependency.text).removeprefix("python3-") for dependency in manifest().iter("exec_depend")}
    own = {"docking", "robot_io", "__future__"} | ROS_PARTS | OPTIONAL | sys.stdlib_module_names
    modules = [*MODULES, *Path(robot_io.__file__).parent.rglob("*.py")]
    assert dependencies == set().union(*map(imported, modules)) - own | {"ros2launch"}


@pytest.mark.parametrize("name", ["docking", "robot_io"])
def test_the_code_is_a_link_and_no_copy(name: str) -> None:
    assert (PACKAGE / name).readlink() == Path("..") / name


@pytest.mark.parametrize("path", PARAMETER_FILES, ids=lambda path: path.name)
def test_the_example_parameters_exist_and_are_valid(path: Path) -> None:
    for pattern, node in yaml.safe_load(path.read_text()).items():
        kind = SETTINGS[pattern.removeprefix("/**/")]
        parameters = {parameter.name: parameter for parameter in parameters_of(kind)}
        values = {name: parameter.default for name, parameter in parameters.items()} | node["ros__parameters"]
        assert values.keys() == parameters.keys()
        for name, parameter in parameters.items():
            assert isinstance(parameter.default, type(values[name])), name
            assert parameter.find_fault(values[name]) is None
            if parameter.minimum is not None and parameter.maximum is not None:
                assert parameter.minimum <= values[name] <= parameter.maximum, name
        assert from_values(kind, values).find_conflict() is None


@pytest.mark.parametrize("path", LAUNCH_FILES, ids=lambda path: path.name)
def test_what_the_launch_files_name_exists(path: Path) -> None:
    text = path.read_text()
    files = re.findall(r"\$\(find-pkg-share action_tutorials_py\)/([\w./]+)", text)
    assert files
    assert all((PACKAGE / file).is_file() for file in files)
    actions = yaml.safe_load(text)["launch"]
    arguments = {action["arg"]["name"] for action in actions if "arg" in action}
    assert set(re.findall(r"\$\(var (\w+)\)", text)) == arguments
    nodes = [action["node"] for action in actions if "node" in action]
    assert all(node["pkg"] == PACKAGE.name and node["exec"] in scripts() for node in nodes)
    # A program with several nodes refuses a name.
    assert all("name" not in node for node in nodes)
