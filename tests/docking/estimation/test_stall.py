"""Wheels that press against the dock, by their joints."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.errors import Stage
from docking.core.geometry import Pose
from docking.core.observation import Joint, Observation
from docking.estimation.stall import stalls
from docking.goal.dock_memory import DockMemory
from docking.goal.outcome import Outcome
from docking.nodes.dock_server import DockAction
from docking.parameters import ControllerName, DockSettings, StallSettings
from docking.simulation.faults import Fault
from docking.simulation.settings import Settings
from docking.simulation.simulation import LEFT_WHEEL, RIGHT_WHEEL, Simulation

WHEELS = StallSettings(True, ("left", "right"))


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [
        (Joint(0.1, 2.0, 10.0), Joint(-0.1, -2.0, 10.0), True),
        (Joint(1.8, 2.0, 10.0), Joint(0.0, 2.0, 10.0), True),
        (Joint(1.8, 2.0, 10.0), Joint(0.4, 2.0, 10.0), False),
        (Joint(0.1, 1.8, 10.0), Joint(0.1, 0.0, 10.0), False),
        (Joint(0.1, 2.0, 9.4), Joint(0.1, 2.0, 10.0), False),
        (Joint(math.nan, 2.0, 10.0), Joint(0.1, 2.0, 10.0), False),
        (None, Joint(0.1, 2.0, 10.0), False),
    ],
)
def test_they_hardly_turn_and_are_driven_hard(left: Joint | None, right: Joint, expected: bool) -> None:
    joints = {"right": right, "arm": Joint(0.0, 9.0, 10.0)} | ({} if left is None else {"left": left})
    assert stalls(Observation(10.0, joints=joints), WHEELS) is expected
    assert not stalls(Observation(10.0, joints=joints), replace(WHEELS, use_stall_detection=False))


@given(st.dictionaries(st.sampled_from(["left", "right"]), st.builds(Joint, st.floats(), st.floats(), st.floats())))
def test_whatever_they_tell_it_is_no_error(joints: dict[str, Joint]) -> None:
    assert stalls(Observation(10.0, joints=joints), WHEELS) in {True, False}


def waited(settings: DockSettings) -> float:
    """Seconds from the end of the wheels' turning to the end of the approach, at a dock without current."""
    simulation = Simulation(Settings(start=Pose(-1.0, 0.1, -0.1)), 3)
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    goal, stalled_at = DockAction().make_goal(settings, DockMemory(), 0.0), math.inf
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        if step.stage is Stage.WAIT_FOR_CHARGE:
            assert simulation.contact
            return simulation.time - stalled_at
        if simulation.robot.stalled:
            stalled_at = min(stalled_at, simulation.time)
        simulation.run(settings.control_period, step.velocity)
    raise AssertionError(step)


def test_the_joints_tell_of_the_dock_sooner_than_odometry() -> None:
    settings = DockSettings(controller=ControllerName.DOCK_POSE)
    watched = replace(settings, stall=StallSettings(True, (LEFT_WHEEL, RIGHT_WHEEL)))
    assert waited(watched) < waited(settings) - 0.2
    deaf = replace(settings, stall=StallSettings(True, ("another",)))
    assert waited(deaf) == waited(settings)
