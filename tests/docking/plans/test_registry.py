"""Controllers by name, also one that another package brings along."""

from pathlib import Path

import pytest

from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.core.parameter import Parameter, parameters_of
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.outcome import Command
from docking.parameters import ControllerName, DockSettings
from docking.plans.registry import make_plan, sensors_of
from docking.simulation.dock import DOCKED
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

MODULE = """
from docking.core.observation import Velocity
from docking.goal.plan import SingleStage


class StraightOn:
    def __init__(self, speed):
        self.speed = speed

    def step(self, observation, dt):
        return Velocity(self.speed)


class LinePlan(SingleStage):
    sensors = frozenset({"odometry"})

    def __init__(self, settings):
        super().__init__(StraightOn(settings.motion.v_linear_min))
        self.motion = settings.motion


class Curious(LinePlan):
    sensors = frozenset({"crystal ball"})
"""
ENTRY_POINTS = """[docking.plans]
line = my_plans:LinePlan
curious = my_plans:Curious
missing = my_plans:Nothing
broken = no_such_module:Plan
"""


@pytest.fixture(autouse=True)
def other_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package as pip leaves it behind."""
    (tmp_path / "my_plans.py").write_text(MODULE)
    information = tmp_path / "my_plans-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: my-plans\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text(ENTRY_POINTS)
    monkeypatch.syspath_prepend(tmp_path)


def parameter() -> Parameter:
    return next(one for one in parameters_of(DockSettings) if one.name == "controller")


def test_it_docks_in_simulation() -> None:
    assert parameter().find_fault("line") is None
    assert sensors_of(DockSettings(controller="line")) == {"odometry"}
    settings = DockSettings(controller="line")
    assert settings.find_conflict() is None
    simulation = Simulation(Settings(start=DOCKED.compose(Pose(-0.3))), seed=1)
    goal = Goal(make_plan(settings), Docking(settings.goal_timeouts), 0.0)
    while isinstance(step := goal.step(simulation.observe()), Command) and simulation.time < 30.0:
        assert 0.0 <= step.velocity.linear_x <= settings.motion.v_linear_min
        simulation.run(0.05, step.velocity)
    assert simulation.contact
    assert not isinstance(step, Command)


@pytest.mark.parametrize("controller", list(ControllerName))
def test_ours_are_known_and_make_a_new_plan_for_each_goal(controller: str) -> None:
    settings = DockSettings(controller=controller)
    assert parameter().find_fault(controller) is None
    assert make_plan(settings) is not make_plan(settings)
    make_plan(settings).observe(Observation(0.0))


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("magic", "is 'magic', but must be one of: rotate, dock_pose, infrared, broken, curious, line, missing"),
        ("broken", "is 'broken', which cannot be loaded from no_such_module:Plan: No module named 'no_such_module'"),
        ("missing", "has no attribute 'Nothing'"),
        ("curious", "the sensors of my_plans:Curious must be among: infrared, marker, odometry, scan"),
    ],
)
def test_what_is_no_controller_is_refused_with_the_reason(name: str, fault: str) -> None:
    assert fault in str(parameter().find_fault(name))
