"""Time limits follow the speed: a slow robot docks and undocks, and its goals have an end nevertheless."""

import pytest

from docking.core.geometry import Pose
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.outcome import End, Outcome
from docking.nodes.dock_server import DockAction
from docking.nodes.undock_server import UndockAction
from docking.parameters import ControllerName, Dock, DockSettings, MotionLimits, Staging, UndockSettings, UndockTimeouts
from docking.simulation.dock import DOCKED
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

SLOW = MotionLimits(v_linear_max=0.05, v_linear_min=0.05)
SLOWER = MotionLimits(v_linear_max=0.04, v_linear_min=0.02)


def run(goal: Goal, simulation: Simulation) -> Outcome:
    """Run a goal to its end, which must come."""
    last = simulation.time + goal.longest
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        assert simulation.time <= last
        simulation.run(0.05, step.velocity)
    return step


@pytest.mark.parametrize("motion", [SLOW, SLOWER])
@pytest.mark.parametrize("start", [Pose(-1.3, 0.2, -0.1), Pose(-3.3, 1.2, -0.1)])
def test_a_slow_robot_docks_and_undocks(motion: MotionLimits, start: Pose) -> None:
    docking = DockSettings(controller=ControllerName.DOCK_POSE, motion=motion)
    undocking = UndockSettings(motion=motion, timeouts=UndockTimeouts(undocking_timeout=30.0))
    assert docking.find_conflict() is undocking.find_conflict() is None
    simulation, memory = Simulation(Settings(start=start), 3), DockMemory()
    assert run(DockAction().make_goal(docking, memory, 0.0), simulation).end is End.SUCCEEDED
    assert run(UndockAction().make_goal(undocking, memory, simulation.time), simulation) == Outcome(End.SUCCEEDED)


def test_a_limit_that_is_just_enough_is_enough() -> None:
    settings = UndockSettings(motion=SLOW, staging=Staging(-1.0))
    assert settings.find_conflict() is None
    simulation = Simulation(Settings(start=DOCKED), 3)
    simulation.run(0.5)
    assert run(UndockAction().make_goal(settings, DockMemory(), 0.5), simulation) == Outcome(End.SUCCEEDED)


def test_so_is_that_for_a_dock_whose_staging_pose_is_farther_than_the_usual_one() -> None:
    settings, memory = UndockSettings(motion=MotionLimits(v_linear_max=0.1)), DockMemory(staging=Staging(-1.6))
    simulation = Simulation(Settings(start=DOCKED), 3)
    simulation.run(0.5)
    assert run(UndockAction().make_goal(settings, memory, 0.5), simulation) == Outcome(End.SUCCEEDED)


@pytest.mark.parametrize("controller", [ControllerName.DOCK_POSE, ControllerName.INFRARED])
def test_no_limit_is_shorter_than_its_way(controller: ControllerName) -> None:
    for speed in (0.01, 0.05, 0.1, 0.26, 2.0):
        motion = MotionLimits(v_linear_max=speed, v_linear_min=min(speed, 0.04))
        settings = DockSettings(controller=controller, motion=motion, dock=Dock(staging_x_offset=-3.0))
        limits = settings.goal_timeouts
        assert limits.staging_timeout * speed >= min(speed, 0.26) * 60.0
        assert limits.retry_timeout >= 3.0 / motion.v_linear_back + 2.0
        assert limits.dock_approach_timeout >= 2.94 / speed + 0.06 / motion.v_linear_min + 2.0
