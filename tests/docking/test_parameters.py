import pytest

from docking.core.footprint import round_footprint
from docking.goal.admission import GoalPolicy
from docking.goal.engine import Limits
from docking.parameters import (
    DOCK_SERVER,
    FIBONACCI_SERVER,
    UNDOCK_SERVER,
    ChoiceParameter,
    ControllerName,
    DockSettings,
    TextParameter,
    UndockSettings,
    dock_settings,
    find_fault,
    undock_settings,
)

DEFAULTS = {parameter.name: parameter.default for parameter in DOCK_SERVER}


def test_the_defaults_are_the_documented_ones() -> None:
    settings = dock_settings(DEFAULTS)
    assert settings == DockSettings(GoalPolicy.REJECT, Limits(2.0, 60.0, 0.0), 0.15)
    assert settings.controller is ControllerName.ROTATE
    undocking = {parameter.name: parameter.default for parameter in UNDOCK_SERVER}
    assert undock_settings(undocking) == UndockSettings(GoalPolicy.REJECT)


def test_the_defaults_have_no_fault_and_are_in_range() -> None:
    assert find_fault(DOCK_SERVER, DEFAULTS) is None
    for parameter in DOCK_SERVER + UNDOCK_SERVER + FIBONACCI_SERVER:
        if isinstance(parameter, ChoiceParameter):
            assert parameter.default in parameter.choices
        elif isinstance(parameter, TextParameter):
            parameter.read(parameter.default)
        else:
            assert parameter.minimum <= parameter.default <= parameter.maximum


def test_an_unknown_choice_is_a_fault_that_names_the_known_ones() -> None:
    fault = find_fault(DOCK_SERVER, {"goal_policy": "queue"})
    assert fault == "goal_policy is 'queue', but must be one of: reject, preempt"


@pytest.mark.parametrize(("stale", "lost", "faulty"), [(2.0, 2.0, False), (5.0, 3.0, True), (2.0, None, False)])
def test_lost_is_not_below_stale(stale: float, lost: float | None, faulty: bool) -> None:
    fault = find_fault(DOCK_SERVER, {"battery_stale_after": stale, "battery_lost_after": lost})
    assert (fault is not None) is faulty


@pytest.mark.parametrize(
    ("greater", "smaller"), [("v_linear_max", "v_linear_min"), ("infrared_field_of_view", "infrared_receiver_angle")]
)
def test_what_must_not_be_below_something_else(greater: str, smaller: str) -> None:
    fault = find_fault(DOCK_SERVER, {greater: 0.1, smaller: 0.2})
    assert fault is not None
    assert greater in fault
    assert smaller in fault
    assert find_fault(DOCK_SERVER, {greater: 0.2, smaller: 0.2}) is None


def test_a_footprint_counts_more_than_a_radius() -> None:
    assert dock_settings(DEFAULTS).footprint == round_footprint(0.15)
    assert dock_settings({**DEFAULTS, "robot_radius": 0.3}).footprint == round_footprint(0.3)
    outline = {"robot_radius": 0.3, "footprint": "[[0.2, 0.1], [0.2, -0.1], [-0.2, 0]]"}
    assert dock_settings({**DEFAULTS, **outline}).footprint == ((0.2, 0.1), (0.2, -0.1), (-0.2, 0.0))


def test_a_footprint_that_is_none_is_a_fault() -> None:
    fault = find_fault(DOCK_SERVER, {"footprint": "[[0.2, 0.1], [0.2, -0.1]]"})
    assert fault == "footprint has 2 points, but must have 3 to 100"
