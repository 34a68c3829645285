import math
from pathlib import Path
from typing import Any

import pytest

from docking.core.errors import DockNotInDb
from docking.core.geometry import Pose
from docking.core.parameter import from_values, named_parameters_of, parameters_of
from docking.parameters import ControllerName, Dock, DockDatabase, DockDirection, DockEntry, DockSettings
from docking.parameters.dock_database import read_file

NEAR, FAR = Dock(-0.5), Dock(-1.0)
SETTINGS = DockSettings(
    database=DockDatabase(
        docks=("home", "lab"),
        dock_plugins=("near", "far"),
        entries={"home": DockEntry("near"), "lab": DockEntry("far")},
        types={"near": NEAR, "far": FAR},
    )
)


def settings_from(**values: Any) -> DockSettings:
    """As a node makes them: what is not given has its default."""
    known = {parameter.name: parameter.default for parameter in parameters_of(DockSettings)} | values
    known = {parameter.name: parameter.default for parameter in named_parameters_of(DockSettings, known)} | known
    return from_values(DockSettings, known)


def test_a_goal_gets_the_type_of_its_dock_and_the_first_dock_if_it_names_none() -> None:
    assert SETTINGS.find_conflict() is None
    assert (SETTINGS.at_dock("lab").dock, SETTINGS.at_dock("lab").dock_type) == (FAR, "far")
    assert SETTINGS.at_dock("home").dock == SETTINGS.at_dock("").dock == NEAR


@pytest.mark.parametrize("name", ["nope", "Home", "home ", "near"])
def test_a_dock_that_is_not_there_is_refused(name: str) -> None:
    with pytest.raises(DockNotInDb, match=r"^there is no dock '.*', but: home, lab$"):
        SETTINGS.at_dock(name)


def test_without_docks_every_name_is_accepted_and_changes_nothing() -> None:
    assert DockSettings().at_dock("anything") == DockSettings()


def test_the_only_type_is_that_of_all_docks() -> None:
    assert settings_from(dock_plugins=("far",), staging_x_offset=-1.0).at_dock("anything").dock == FAR
    one = settings_from(docks=("home",), dock_plugins=("far",), **{"far.staging_x_offset": -1.0})
    assert one.find_conflict() is None
    assert one.at_dock("home").dock == FAR


def test_a_type_has_what_it_does_not_set_from_the_parameter_without_prefix() -> None:
    settings = settings_from(staging_x_offset=-0.5, dock_plugins=("near", "far"), **{"far.staging_x_offset": -1.0})
    assert settings.database.types == {"near": NEAR, "far": FAR}


NAVIGATES: dict[str, Any] = {
    "controller": ControllerName.DOCK_POSE,
    "navigate_to_staging_pose": True,
    "docks": ("home", "lab"),
    "home.frame": "hall",
    "home.pose": (1.0, 2.0, math.pi / 2),
}


@pytest.mark.parametrize(
    ("values", "heading"),
    [
        ({}, math.pi / 2),
        ({"dock_direction": DockDirection.BACKWARD}, -math.pi / 2),
        ({"dock_direction": DockDirection.BACKWARD, "rotate_to_dock": True}, math.pi / 2),
    ],
)
def test_the_staging_pose_lies_in_front_of_the_docked_pose(values: dict[str, Any], heading: float) -> None:
    settings = settings_from(**NAVIGATES, **values)
    assert settings.find_conflict() is None
    staging = settings.at_dock("").staging_goal
    assert staging is not None
    assert (staging.dock, staging.frame) == ("home", "hall")
    assert staging.pose.distance_to(Pose(1.0, 1.3)) < 1e-9
    assert staging.pose.theta == pytest.approx(heading)


@pytest.mark.parametrize(
    "values",
    [
        {"navigate_to_staging_pose": False},
        {"controller": ControllerName.ROTATE},
        {"home.pose": ()},
        {"docks": ()},
    ],
)
def test_nobody_navigates_unless_it_is_allowed_and_the_dock_has_a_pose(values: dict[str, Any]) -> None:
    assert settings_from(**{**NAVIGATES, **values}).at_dock("").staging_goal is None


@pytest.mark.parametrize(
    ("values", "conflict"),
    [
        (
            {"docks": ("home",), "dock_plugins": ("near",), "home.type": "far"},
            "home.type is 'far', but must be one of dock_plugins (there: near)",
        ),
        ({"docks": ("home",), "home.type": "far"}, "home.type is 'far', but must be one of dock_plugins (there: none)"),
        (
            {"docks": ("home",), "dock_plugins": ("near", "far")},
            "home.type is '', but must be one of dock_plugins (there: near, far)",
        ),
        (
            {
                "controller": ControllerName.DOCK_POSE,
                "dock_plugins": ("far",),
                "far.staging_x_offset": -1.0,
                "retry_timeout": 5.0,
            },
            (
                "retry_timeout (5 s) is too short: 1 m (staging_x_offset) backwards at 0.156 m/s (0.6 of v_linear_max)"
                " takes 6.4 s"
            ),
        ),
    ],
)
def test_a_database_that_cannot_work_is_told(values: dict[str, Any], conflict: str) -> None:
    assert settings_from(**values).find_conflict() == conflict


@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [
        ("docks", ("home", "home"), "docks has the name 'home' twice"),
        ("docks", ("a.b",), "docks has the name 'a.b', but a name consists of letters, digits, - and _"),
        ("docks", ("",), "docks has the name '', but a name consists of letters, digits, - and _"),
        ("home.pose", (1.0, 2.0), "home.pose is [1.0, 2.0], but must be [x, y, theta] in m and rad"),
        ("home.pose", (1.0, 2.0, float("nan")), "home.pose is [1.0, 2.0, nan], but must be [x, y, theta] in m and rad"),
        ("home.pose", (1.0, 2.0, 3.0), None),
    ],
)
def test_a_value_that_is_no_name_or_pose_is_a_fault(name: str, value: Any, fault: str | None) -> None:
    values = {parameter.name: parameter.default for parameter in parameters_of(DockSettings)} | {"docks": ("home",)}
    parameters = [*parameters_of(DockSettings), *named_parameters_of(DockSettings, values)]
    (parameter,) = [parameter for parameter in parameters if parameter.name == name]
    assert parameter.find_fault(value) == fault


def test_a_file_gives_the_parameters_of_its_docks(tmp_path: Path) -> None:
    path = tmp_path / "docks.yaml"
    path.write_text("docks:\n  home: {type: near, frame: map, pose: [1, 2.5, 0], id: 7}\n  lab: {}\n")
    assert read_file(str(path)) == {
        "docks": ("home", "lab"),
        "home.type": "near",
        "home.frame": "map",
        "home.pose": (1.0, 2.5, 0.0),
        "home.id": "7",
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[", "is not YAML"),
        ("home: {}", "must have docks by name"),
        ("docks: []", "must have docks by name"),
        ("docks: {home: }", "must have no other keys than type, frame, pose, id"),
        ("docks: {home: {typ: near}}", "must have no other keys than type, frame, pose, id"),
        ("docks: {home.x: {}}", "has the dock 'home.x', but a name consists of"),
        ("docks: {home: {pose: here}}", r"whose pose must be \[x, y, theta\]"),
        ("docks: {home: {pose: [true, 1, 2]}}", r"whose pose must be \[x, y, theta\]"),
    ],
)
def test_a_file_of_something_else_is_refused_by_name(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "docks.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as raised:
        read_file(str(path))
    assert str(raised.value).startswith(f"dock_database: {path} ")


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^dock_database: .*No such file"):
        read_file(str(tmp_path / "docks.yaml"))
