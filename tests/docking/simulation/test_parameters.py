from docking.core.geometry import Pose
from docking.core.parameter import from_values, parameters_of
from docking.simulation.parameters import SimulatorSettings

DEFAULTS = {parameter.name: parameter.default for parameter in parameters_of(SimulatorSettings)}


def test_every_parameter_changes_something() -> None:
    assert from_values(SimulatorSettings, DEFAULTS) == SimulatorSettings()
    for parameter in parameters_of(SimulatorSettings):
        other = parameter.choices[-1] if parameter.choices else parameter.maximum
        assert from_values(SimulatorSettings, {**DEFAULTS, parameter.name: other}) != SimulatorSettings()


def test_the_start_is_a_pose() -> None:
    settings = from_values(SimulatorSettings, {**DEFAULTS, "start_x": -2.0, "start_y": 0.5, "start_theta": 1.0})
    assert settings.settings.start.compose(Pose()) == Pose(-2.0, 0.5, 1.0)
