"""What parameters of nav2 mean here: each line of the table, and what is special."""

from typing import Any

import pytest

from docking.core.parameter import Value, named_parameters_of, parameters_of
from docking.parameters import DockSettings, UndockSettings
from docking.parameters.nav2 import read_nav2, read_nav2_for_undocking
from docking.parameters.nav2_table import NAV2, NON_CHARGING_DOCK, Meaning, Nav2Parameter

KINDS: dict[str, Value] = {"dock_plugins": ("kind",), "docks": ("home",)}
VALUES = {parameter.name: parameter.default for parameter in parameters_of(DockSettings)} | KINDS
DECLARED = {*VALUES, *(parameter.name for parameter in named_parameters_of(DockSettings, VALUES))}
OTHER = "something else"


def named(name: str) -> str:
    """The name that a parameter of the table has for a type and a dock."""
    return name.replace("<type>", "kind").replace("<dock>", "home")


def of(*meanings: Meaning) -> list[Nav2Parameter]:
    """Lines of the table."""
    return [parameter for parameter in NAV2 if parameter.meaning in meanings]


def test_the_table_has_each_parameter_once() -> None:
    assert len({parameter.name for parameter in NAV2}) == len(NAV2)


@pytest.mark.parametrize("parameter", of(Meaning.SAME), ids=lambda one: one.name)
def test_what_is_the_same_is_a_parameter_here(parameter: Nav2Parameter) -> None:
    assert named(parameter.name) in DECLARED


@pytest.mark.parametrize("parameter", of(Meaning.MAPPED), ids=lambda one: one.name)
def test_what_is_mapped_sets_a_parameter(parameter: Nav2Parameter) -> None:
    name, ours = named(parameter.name), named(parameter.ours)
    value: Any = 0.5 if parameter.name.endswith("angular_vel") else parameter.default
    meanings = read_nav2({**KINDS, name: value})
    assert ours in DECLARED
    assert meanings.values[ours][1] == name
    assert meanings.notes[name] == ""


@pytest.mark.parametrize("parameter", of(Meaning.REFUSED), ids=lambda one: one.name)
def test_what_is_refused_says_what_to_write_instead(parameter: Nav2Parameter) -> None:
    name = named(parameter.name)
    with pytest.raises(ValueError, match="which is not possible here") as raised:
        read_nav2({**KINDS, name: OTHER})
    assert str(raised.value) == f"{name} is {OTHER!r}, which is not possible here. {parameter.text}"
    for value in parameter.accepted:
        assert read_nav2({**KINDS, name: value}).notes[name] == ""


@pytest.mark.parametrize("parameter", of(Meaning.IGNORED), ids=lambda one: one.name)
def test_what_is_ignored_is_told(parameter: Nav2Parameter) -> None:
    name = named(parameter.name)
    assert read_nav2({**KINDS, name: OTHER}).notes[name] == f"{name} has no effect here. {parameter.text}"
    assert name not in DECLARED
    for value in parameter.accepted:
        assert read_nav2({**KINDS, name: value}).notes[name] == ""


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"dock_backwards": True}, {"dock_direction": "backward"}),
        ({"dock_backwards": False}, {"dock_direction": "forward"}),
        ({"kind.use_battery_status": True}, {"kind.charging_source": "current"}),
        ({"kind.use_battery_status": False}, {"kind.charging_source": "pose"}),
        ({"kind.use_battery_status": False, "kind.charging_threshold": 1.0}, {"kind.charging_source": "pose"}),
        ({"kind.charging_threshold": 1.0}, {"kind.charging_source": "current"}),
        ({"kind.charging_threshold": 1.0, "charging_source": "status"}, {}),
        ({"kind.charging_threshold": 1.0, "kind.charging_source": "status"}, {}),
        ({"kind.plugin": NON_CHARGING_DOCK}, {"kind.charging_source": "none"}),
        ({"controller.rotate_to_heading_angular_vel": 0.4}, {"v_angular_max": 0.4}),
        ({"controller.rotate_to_heading_angular_vel": 1.5}, {}),
        (
            {"controller.v_angular_max": 0.3, "controller.rotate_to_heading_angular_vel": 0.4},
            {"v_angular_max": 0.3},
        ),
        (
            {"controller.v_angular_max": 0.5, "controller.rotate_to_heading_angular_vel": 0.4},
            {"v_angular_max": 0.4},
        ),
        ({"base_frame": "robot1/base_link", "fixed_frame": "robot1/odom"}, {"frame_prefix": "robot1/"}),
        ({"controller.k_phi": 2.0, "k_phi": 2.0}, {"k_phi": 2.0}),
        ({"controller.k_phi": 2.0, "k_phi": 3.0}, {}),
    ],
)
def test_what_is_special(given: dict[str, Value], expected: dict[str, Value]) -> None:
    values = {name: value for name, (value, _) in read_nav2({**KINDS, **given}).values.items() if name != "controller"}
    assert values == expected


@pytest.mark.parametrize(
    ("given", "controller"),
    [
        ({"controller.k_phi": 2.0}, "dock_pose"),
        ({"dock_backwards": True}, "dock_pose"),
        ({"kind.plugin": NON_CHARGING_DOCK}, "dock_pose"),
        ({"controller.k_phi": 2.0, "controller": "infrared"}, None),
        ({"max_retries": 2, "kind.staging_x_offset": -0.5}, None),
    ],
)
def test_nav2s_own_parameters_choose_the_controller(given: dict[str, Value], controller: str | None) -> None:
    meanings = read_nav2({**KINDS, **given})
    assert meanings.values.get("controller", (None, ""))[0] == controller
    assert any("it is dock_pose" in remark for remark in meanings.remarks) is (controller is not None)


def test_a_direction_that_contradicts_itself_is_refused() -> None:
    for other in ("dock_direction", "kind.dock_direction"):
        with pytest.raises(ValueError, match=f"dock_backwards is true, but {other} is 'forward'"):
            read_nav2({**KINDS, "dock_backwards": True, other: "forward"})
        read_nav2({**KINDS, "dock_backwards": True, other: "backward"})


def test_a_topic_is_the_one_that_it_is_remapped_to() -> None:
    names = {"odom": "/odometry/filtered"}
    read_nav2({"odom_topic": "/odometry/filtered"}, lambda name: names.get(name, name))
    with pytest.raises(ValueError, match="odom_topic is '/odom'"):
        read_nav2({"odom_topic": "/odom"}, lambda name: names.get(name, name))


def test_other_defaults_are_told_for_types_with_a_plugin() -> None:
    given = {**KINDS, "kind.plugin": NON_CHARGING_DOCK, "kind.external_detection_rotation_roll": -1.57}
    told = " ".join(read_nav2(given).remarks)
    assert "kind.external_detection_rotation_pitch is not given. With nav2 its default is 1.57, here 0: set it" in told
    assert "controller.use_collision_detection is not given. With nav2 its default is true, here false" in told
    assert "rotation_roll" not in told
    assert read_nav2({**KINDS, "kind.docking_threshold": 0.1}).remarks == []


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"kind.staging_yaw_offset": 0.5}, "kind.staging_yaw_offset"),
        ({"navigator_bt_xml": "tree.xml"}, "navigator_bt_xml"),
        ({"max_staging_time": 5.0}, "max_staging_time"),
        ({"charging_threshold": 5.0}, "charging_threshold"),
    ],
)
def test_what_has_no_effect_without_another_parameter_is_told(given: dict[str, Value], name: str) -> None:
    assert "has no effect unless" in read_nav2({**KINDS, **given}).notes[name]
    more: dict[str, Value] = {"navigate_to_staging_pose": True, "charging_source": "current"}
    assert name not in read_nav2({**KINDS, **given, **more}).notes


def test_undocking_goes_by_what_the_types_agree_in() -> None:
    names = {parameter.name for parameter in parameters_of(UndockSettings)}
    two: dict[str, Value] = {"dock_plugins": ("near", "far")}
    same: dict[str, Value] = {"near.dock_direction": "backward", "far.dock_direction": "backward"}
    differ: dict[str, Value] = {"near.staging_x_offset": -0.5, "far.staging_x_offset": -1.0}
    meanings = read_nav2_for_undocking({**two, **same, **differ})
    assert {name: value for name, (value, _) in meanings.values.items() if name in names} == {
        "dock_direction": "backward"
    }
    (remark,) = meanings.remarks
    assert remark == (
        "near.staging_x_offset, far.staging_x_offset differ: undocking goes by staging_x_offset until a goal has docked"
        " the robot"
    )
    assert read_nav2_for_undocking({**two, **differ, "staging_x_offset": -0.7}).remarks == []
