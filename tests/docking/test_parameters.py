import pytest

from docking.admission import GoalPolicy
from docking.goal import Limits
from docking.parameters import (
    DOCK_SERVER,
    FIBONACCI_SERVER,
    ChoiceParameter,
    DockSettings,
    dock_settings,
    find_fault,
)

DEFAULTS = {parameter.name: parameter.default for parameter in DOCK_SERVER}


def test_the_defaults_are_the_documented_ones() -> None:
    assert dock_settings(DEFAULTS) == DockSettings(GoalPolicy.REJECT, Limits(2.0, 60.0, 0.0), 0.15)


def test_the_defaults_have_no_fault_and_are_in_range() -> None:
    assert find_fault(DOCK_SERVER, DEFAULTS) is None
    for parameter in DOCK_SERVER + FIBONACCI_SERVER:
        if isinstance(parameter, ChoiceParameter):
            assert parameter.default in parameter.choices
        else:
            assert parameter.minimum <= parameter.default <= parameter.maximum


def test_an_unknown_choice_is_a_fault_that_names_the_known_ones() -> None:
    fault = find_fault(DOCK_SERVER, {"goal_policy": "queue"})
    assert fault == "goal_policy is 'queue', but must be one of: reject, preempt"


@pytest.mark.parametrize(("stale", "lost", "faulty"), [(2.0, 2.0, False), (5.0, 3.0, True), (2.0, None, False)])
def test_lost_is_not_below_stale(stale: float, lost: float | None, faulty: bool) -> None:
    fault = find_fault(DOCK_SERVER, {"battery_stale_after": stale, "battery_lost_after": lost})
    assert (fault is not None) is faulty
