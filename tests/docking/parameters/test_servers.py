from dataclasses import replace

import pytest

from docking.core.footprint import round_footprint
from docking.core.parameter import NodeSettings, from_values, parameters_of
from docking.parameters import (
    ControllerName,
    Dock,
    DockSettings,
    DockTimeouts,
    MotionLimits,
    Outline,
    Receivers,
    ServerSettings,
    Staging,
    UndockSettings,
    UndockTimeouts,
)
from docking.tutorial.fibonacci import FibonacciSettings


@pytest.mark.parametrize("kind", [DockSettings, UndockSettings, FibonacciSettings])
def test_the_defaults_have_no_fault_and_are_in_range(kind: type[NodeSettings]) -> None:
    parameters = list(parameters_of(kind))
    assert len({parameter.name for parameter in parameters}) == len(parameters)
    for parameter in parameters:
        assert parameter.find_fault(parameter.default) is None
        if parameter.minimum is not None and parameter.maximum is not None:
            assert parameter.minimum <= float(parameter.default) <= parameter.maximum
    assert from_values(kind, {parameter.name: parameter.default for parameter in parameters}) == kind()
    assert kind().find_conflict() is None


@pytest.mark.parametrize("controller", list(ControllerName))
def test_the_defaults_work_with_each_controller(controller: ControllerName) -> None:
    assert DockSettings(controller=controller).find_conflict() is None


@pytest.mark.parametrize(
    ("settings", "conflict"),
    [
        (
            UndockSettings(timeouts=UndockTimeouts(battery_stale_after=5.0, battery_lost_after=3.0)),
            "battery_lost_after (3) must not be below battery_stale_after (5)",
        ),
        (
            DockSettings(motion=MotionLimits(v_linear_max=0.03)),
            "v_linear_max (0.03) must not be below v_linear_min (0.04)",
        ),
        (
            DockSettings(motion=MotionLimits(v_angular_max=0.05, v_angular_min=0.1)),
            "v_angular_max (0.05) must not be below v_angular_min (0.1)",
        ),
        (
            DockSettings(receivers=Receivers(infrared_field_of_view=0.1)),
            "infrared_field_of_view (0.1) must not be below infrared_receiver_angle (0.349)",
        ),
        (
            DockSettings(controller=ControllerName.DOCK_POSE, search_speed=0.1, motion=MotionLimits(v_angular_min=0.2)),
            "search_speed (0.1) must not be below v_angular_min (0.2)",
        ),
        (
            UndockSettings(motion=MotionLimits(v_linear_max=0.05, v_linear_min=0.01)),
            (
                "undocking_timeout (20 s) is too short: 0.7 m (staging_x_offset) backwards at 0.03 m/s"
                " (0.6 of v_linear_max) takes 23.3 s"
            ),
        ),
        (
            DockSettings(controller=ControllerName.DOCK_POSE, timeouts=DockTimeouts(dock_approach_timeout=3.0)),
            (
                "dock_approach_timeout (3 s) is too short: 0.6 m at 0.26 m/s (v_linear_max) and 0.1 m at 0.04 m/s"
                " (v_linear_min) takes 4.8 s"
            ),
        ),
        (
            DockSettings(controller=ControllerName.INFRARED, timeouts=DockTimeouts(retry_timeout=2.0)),
            (
                "retry_timeout (2 s) is too short: 0.7 m (staging_x_offset) backwards at 0.156 m/s"
                " (0.6 of v_linear_max) takes 4.5 s"
            ),
        ),
    ],
)
def test_values_that_cannot_work_together_are_told_with_the_arithmetic(settings: ServerSettings, conflict: str) -> None:
    assert settings.find_conflict() == conflict


def test_what_is_just_enough_is_no_conflict() -> None:
    slow = UndockSettings(motion=MotionLimits(v_linear_max=0.05, v_linear_min=0.05), staging=Staging(-1.0))
    assert slow.find_conflict() is None  # 20 s at the minimum velocity
    assert replace(slow, staging=Staging(-1.01)).find_conflict() is not None
    assert DockSettings(motion=MotionLimits(v_linear_max=0.04)).find_conflict() is None


def test_rotate_does_not_care_about_the_time_limits_of_the_others() -> None:
    settings = DockSettings(timeouts=DockTimeouts(retry_timeout=0.1), dock=Dock(-3.0))
    assert settings.find_conflict() is None
    assert replace(settings, controller=ControllerName.DOCK_POSE).find_conflict() is not None


def test_a_footprint_counts_more_than_a_radius() -> None:
    assert DockSettings().outline.points == round_footprint(0.15)
    assert Outline(robot_radius=0.3).points == round_footprint(0.3)
    settings = Outline(robot_radius=0.3, footprint="[[0.2, 0.1], [0.2, -0.1], [-0.2, 0]]")
    assert settings.points == ((0.2, 0.1), (0.2, -0.1), (-0.2, 0.0))


def test_a_footprint_that_is_none_is_a_fault() -> None:
    (parameter,) = [parameter for parameter in parameters_of(DockSettings) if parameter.name == "footprint"]
    assert parameter.find_fault("[[0.2, 0.1], [0.2, -0.1]]") == "footprint has 2 points, but must have 3 to 100"
