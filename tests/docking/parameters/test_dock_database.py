import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from docking.core.errors import DockNotInDb, DockNotValid
from docking.core.geometry import Pose
from docking.core.parameter import from_values, named_parameters_of, parameters_of
from docking.parameters import (
    ChargingSettings,
    ChargingSource,
    ControllerName,
    DockDatabase,
    DockDirection,
    DockEntry,
    DockPlace,
    DockSettings,
    DockType,
)
from docking.parameters.dock_database import read_file

NEAR, FAR = DockType(-0.5), DockType(-1.0)
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


def test_a_goal_may_describe_its_dock_by_a_pose() -> None:
    settings = SETTINGS.at_dock(' {"frame": "hall", "pose": [4, -1.5, 1], "type": "far"}')
    assert (settings.dock, settings.dock_type, settings.dock_name) == (FAR, "far", "(4, -1.5) in hall")
    assert settings.place == DockPlace("(4, -1.5) in hall", "hall", Pose(4.0, -1.5, 1.0))
    assert DockSettings().at_dock('{"pose": [1, 2, 3]}').place == DockPlace("(1, 2) in map", "map", Pose(1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("location", "sentence"),
    [
        ("{", "is no JSON such as"),
        ("{" * 5000, "is no JSON such as"),
        ('{"a":' * 5000, "is no JSON such as"),
        ("{}", "has no pose"),
        ('{"pose": [true, 1, 2], "type": "far"}', "has no pose"),
        ('{"pose": [1, 2], "type": "far"}', "must be .x, y, theta."),
        ('{"pose": [1, NaN, 2], "type": "far"}', "must be .x, y, theta."),
        ('{"pose": [1, 2, 90], "type": "far"}', "looks like degrees"),
        ('{"pose": [1e8, 2, 0], "type": "far"}', "x and y must be in m"),
        ('{"pose": [1' + "0" * 400 + ', 2, 0], "type": "far"}', "is too far away"),
        ('{"pose": [1, 2, 3], "kind": "far"}', "has 'kind'"),
        ('{"pose": [1, 2, 3], "type": 7}', "has 'type'"),
        ('{"pose": [1, 2, 3]}', "the type of the dock is '', but must be one of dock_plugins"),
        ('{"pose": [1, 2, 3], "type": "high"}', "the type of the dock is 'high', but must be one of dock_plugins"),
    ],
)
def test_a_description_that_can_be_no_dock_is_refused(location: str, sentence: str) -> None:
    with pytest.raises(DockNotValid, match=sentence) as refused:
        SETTINGS.at_dock(location)
    assert len(str(refused.value)) < 250


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


def test_a_goal_has_all_that_depends_on_the_type_of_its_dock() -> None:
    values: dict[str, Any] = {
        "far.docking_threshold": 0.1,
        "far.external_detection_timeout": 5.0,
        "far.charging_source": ChargingSource.CURRENT,
        "far.charging_threshold": 1.5,
    }
    settings = settings_from(docks=("home", "lab"), dock_plugins=("near", "far"), **values, **{"lab.type": "far"})
    lab = settings.at_dock("lab")
    assert lab.approach.docking_threshold == 0.1
    assert lab.external_detection_timeout == 5.0
    assert lab.charging == ChargingSettings(ChargingSource.CURRENT, 1.5)
    home = replace(settings, database=replace(settings.database, docks=())).at_dock("")
    assert (home.approach, home.external_detection_timeout, home.charging) == (
        settings.approach,
        settings.external_detection_timeout,
        settings.charging,
    )


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
        ({"staging_yaw_offset": 0.5}, math.pi / 2 + 0.5),
        ({"dock_direction": DockDirection.BACKWARD, "staging_yaw_offset": math.pi}, -math.pi / 2),
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
        (
            "home.pose",
            (1.0, 2.0, 90.0),
            "home.pose is [1.0, 2.0, 90.0], but theta must be in rad, from -2π to 2π: 90 looks like degrees",
        ),
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
    assert read_file(str(path)).values == {
        "docks": ("home", "lab"),
        "home.type": "near",
        "home.frame": "map",
        "home.pose": (1.0, 2.5, 0.0),
        "home.id": "7",
    }


NUMBERS = st.floats(-6.28, 6.28)
WAYS = [repr, "{:.17e}".format, "{:+.17E}".format, "'{!r}'".format]


@given(numbers=st.tuples(NUMBERS, NUMBERS, NUMBERS), way=st.sampled_from(WAYS))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_numbers_may_be_written_in_any_way(
    tmp_path: Path, numbers: tuple[float, float, float], way: Callable[[float], str]
) -> None:
    assert pose_in(tmp_path, ", ".join(map(way, numbers))) == numbers


@pytest.mark.parametrize(
    ("pose", "numbers"),
    [
        ("2.5, 1e-05, 0.0", (2.5, 1e-05, 0.0)),
        ("1e3, .5, -1E+0", (1000.0, 0.5, -1.0)),
        ("1_000, 5., +0", (1000.0, 5.0, 0.0)),
        ("010, -.5, 1.5e0", (10.0, -0.5, 1.5)),
    ],
)
def test_numbers_that_yaml_takes_for_text_are_numbers(tmp_path: Path, pose: str, numbers: tuple[float, ...]) -> None:
    assert pose_in(tmp_path, pose) == numbers


def pose_in(folder: Path, numbers: str) -> object:
    """The pose of a dock, from a file."""
    path = folder / "docks.yaml"
    path.write_text(f"docks: {{home: {{pose: [{numbers}]}}}}\n")
    return read_file(str(path)).values["home.pose"]


@given(text=st.text(alphabet=st.sampled_from("docks:{}[]&*<-?|>'\"\n\t #!~,ab1.")))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_text_is_read_or_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "docks.yaml"
    path.write_text(text)
    with suppress(ValueError):
        read_file(str(path))


def test_names_and_texts_are_what_stands_there(tmp_path: Path) -> None:
    path = tmp_path / "docks.yaml"
    path.write_text("docks: {1: {id: 007, type: no}, on: {id: 1e-05, frame: ~}, null: {type: 'null', id: }}")
    assert read_file(str(path)).values == {
        "docks": ("1", "on", "null"),
        "1.id": "007",
        "1.type": "no",
        "on.id": "1e-05",
        "on.frame": "",
        "null.type": "null",
        "null.id": "",
    }


def test_further_keys_are_named_and_ignored(tmp_path: Path) -> None:
    path = tmp_path / "docks.yaml"
    path.write_text(
        "version: 2\ndocks:\n  home: {type: near, apriltag_id: 7, dock_frame: {a: [1]}, approach_yaw: .nan}\n"
        "  lab: &lab {typ: far}\n  attic: {<<: *lab, id: 1}\n"
    )
    contents = read_file(str(path))
    assert contents.values == {"docks": ("home", "lab", "attic"), "home.type": "near", "attic.id": "1"}
    assert contents.unknown == (
        "version",
        "home.apriltag_id",
        "home.dock_frame",
        "home.approach_yaw",
        "lab.typ",
        "attic.typ",
    )
    assert {"docks", "lab.type"} <= {*contents.known}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"docks: {home: {id: \xff}}", "is not UTF-8"),
        (b"docks: {home: {id: \x00}}", "is not YAML"),
        (b"docks:\n\thome: {}", "is not YAML"),
        (b"docks: {home: {}}\n---\ndocks: {lab: {}}", "is not YAML"),
        (b"docks: " + b"[" * 5000, "nested too deeply"),
        (b"#" * 1_000_001, "has more than 1000000 bytes"),
        (b"docks: {" + b",".join(b"d%d: {}" % n for n in range(1001)) + b"}", "has 1001 docks, but at most 1000"),
    ],
)
def test_a_file_that_is_no_text_or_too_large_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "docks.yaml"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=message):
        read_file(str(path))


@pytest.mark.parametrize("path", ["/tmp", "/dev/null", "~no-such-user/docks.yaml", "a\0b"])
def test_what_is_no_file_is_refused(path: str) -> None:
    with pytest.raises(ValueError, match=r"^dock_database: "):
        read_file(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("docks: {home: {pose: [.inf, 0, 0]}}", r"whose pose is \[inf, 0.0, 0.0\], but must be \[x, y, theta\]"),
        ("docks: {home: {pose: [0, .NaN, 0]}}", r"whose pose is \[0.0, nan, 0.0\], but must be"),
        ("docks: {home: {pose: [1e400, 0, 0]}}", r"whose pose is \[inf, 0.0, 0.0\], but must be"),
        ("docks: {home: {pose: [1e9, 0, 0]}}", "x and y must be in m"),
        ("docks: {home: {pose: [0, 0, 90]}}", "90 looks like degrees"),
        ("docks: {home: {pose: [0, 0, 0, 0, 0, 0, 1]}}", r"but must be \[x, y, theta\] in m and rad"),
        ("docks: {home: {pose: {x: 1, y: 2, theta: 0}}}", r"whose pose must be \[x, y, theta\]"),
        ("docks: {home: {pose: [[1], 2, 3]}}", r"whose pose must be \[x, y, theta\]"),
        ("docks: {home: {pose: [1:30, 0, 0]}}", r"whose pose must be \[x, y, theta\]"),
        ("docks: {home: {pose: []}}", r"whose pose must be \[x, y, theta\]"),
        ("docks: {home: {id: [1, 2]}}", "has the dock 'home', whose id must be a text"),
        ("docks: {home: {}, home: {}}", "has the key 'home' twice"),
        ("docks: {home: {id: 1, id: 2}}", "has the dock 'home', which has the key 'id' twice"),
        ("docks: {home: {}}\ndocks: {}", "has the key 'docks' twice"),
        ("docks: {'': {}}", "has the dock '', but a name consists of"),
        ("docks: {? [a] : {}}", "has a key that is no text"),
        ("", "must have docks by name"),
        ("[", "is not YAML"),
        ("home: {}", "must have docks by name"),
        ("docks: []", "must have docks by name"),
        ("docks: {home: }", "has the dock 'home', which must have keys such as type, frame, pose and id"),
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


def test_the_nearest_dock_is_one_of_those_that_have_a_pose() -> None:
    given = {"docks": ("home", "lab", "yard"), "lab.pose": (1.0, 2.0, 0.0), "yard.pose": (3.0, 4.0, 0.0)}
    settings = settings_from(**given).at_dock("nearest")
    assert settings.choices == (DockPlace("lab", "map", Pose(1.0, 2.0)), DockPlace("yard", "map", Pose(3.0, 4.0)))
    assert settings.place in settings.choices
    assert settings_from(**given).at_dock("lab").choices == ()
    with pytest.raises(DockNotInDb, match="none of them has a pose"):
        settings_from(docks=("home",)).at_dock("nearest")
    assert settings_from().at_dock("nearest").choices == (), "without docks, every name is taken and ignored"


def test_a_dock_that_is_called_nearest_is_meant_by_its_name() -> None:
    given = {"docks": ("home", "nearest"), "home.pose": (1.0, 2.0, 0.0)}
    settings = settings_from(**given).at_dock("nearest")
    assert (settings.choices, settings.dock_name) == ((), "nearest")
