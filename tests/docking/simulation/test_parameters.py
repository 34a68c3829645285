from docking.core.geometry import Pose
from docking.parameters import ChoiceParameter, find_fault
from docking.simulation.parameters import DOCK_SIMULATOR, simulator_settings
from docking.simulation.simulation import Settings

DEFAULTS = {parameter.name: parameter.default for parameter in DOCK_SIMULATOR}


def test_the_defaults_are_those_of_the_model() -> None:
    settings = simulator_settings(DEFAULTS)
    assert settings.settings == Settings()
    assert (settings.real_time_factor, settings.battery_resume_after, settings.seed) == (1.0, 3.0, 0)


def test_the_defaults_are_in_range() -> None:
    assert find_fault(DOCK_SIMULATOR, DEFAULTS) is None
    for parameter in DOCK_SIMULATOR:
        assert not isinstance(parameter, ChoiceParameter)
        assert parameter.minimum <= parameter.default <= parameter.maximum


def test_every_parameter_changes_something() -> None:
    usual = simulator_settings(DEFAULTS)
    for parameter in DOCK_SIMULATOR:
        assert not isinstance(parameter, ChoiceParameter)
        assert simulator_settings({**DEFAULTS, parameter.name: parameter.maximum}) != usual


def test_the_start_is_a_pose() -> None:
    settings = simulator_settings({**DEFAULTS, "start_x": -2.0, "start_y": 0.5, "start_theta": 1.0})
    assert settings.settings.start == Pose(-2.0, 0.5, 1.0)
