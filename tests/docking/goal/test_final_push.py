"""Contacts on springs, or behind a lip: the robot pushes on, slowly and not for long."""

from dataclasses import replace

import pytest
from benchmarks.docking.cases import CASES, Case
from benchmarks.docking.trial import run_trial, settings_of

from docking.behaviors.push import LONGER, Push
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.goal.behavior import Done
from docking.parameters import ControllerName, MotionLimits
from docking.parameters import DockSettings as Parameters
from docking.simulation.dock import DOCKED, DockSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

MOTION = MotionLimits()
DOCK_POSE = ControllerName.DOCK_POSE
ROWS = [case for case in CASES if case.final_push > 0.0]


@pytest.mark.parametrize("case", ROWS, ids=lambda case: case.name)
@pytest.mark.parametrize("controller", [DOCK_POSE, ControllerName.INFRARED])
def test_the_robot_docks_only_because_it_pushes_and_never_faster_than_slowly(
    case: Case, controller: ControllerName
) -> None:
    pushed = run_trial(controller, 1, case)
    assert pushed.docked
    assert pushed.retries == 0
    assert max(pushed.contacts) <= MOTION.v_linear_min + 1e-9
    if controller is DOCK_POSE:
        without = run_trial(controller, 1, replace(case, final_push=0.0, parameters=_ends_at_the_docked_pose))
        assert not without.docked or without.retries > 0


def _ends_at_the_docked_pose(parameters: Parameters) -> Parameters:
    """With a docking_overshoot that is as long as contacts on springs need, the approach pushes them in by itself."""
    return replace(parameters, approach=replace(parameters.approach, docking_overshoot=0.015))


def _push(steps: int, speed: float, period: float = 0.05) -> list[Velocity | Done]:
    """The steps of a push whose wheels turn at a speed."""
    push, found = Push(0.06, MOTION), []
    for number in range(steps):
        odometry = Odometry(Pose(number * period * speed), STANDSTILL, number * period)
        step = push.step(Observation(number * period, odometry=odometry), period)
        found.append(step)
        if isinstance(step, Done):
            break
    return found


def test_a_push_ends_after_its_way() -> None:
    steps = _push(1000, MOTION.v_linear_min)
    assert len(steps) * 0.05 == pytest.approx(0.06 / MOTION.v_linear_min, abs=0.15)
    assert set(steps[:-1]) == {Velocity(MOTION.v_linear_min)}


def test_a_push_against_what_does_not_give_way_ends_in_time() -> None:
    steps = _push(1000, 0.0)
    assert isinstance(steps[-1], Done)
    assert len(steps) * 0.05 == pytest.approx(0.06 / MOTION.v_linear_min + LONGER, abs=0.15)


def test_a_push_without_odometry_stands_still() -> None:
    assert Push(0.06, MOTION).step(Observation(0.0), 0.05) == STANDSTILL


def test_a_robot_that_pushes_is_not_blocked_though_its_wheels_stand_longer_than_blocked_after() -> None:
    case = replace(ROWS[0], change=lambda settings, random: replace(settings, dock=DockSettings(lip=2.5)))
    trial = run_trial(DOCK_POSE, 3, replace(case, final_push=0.1))
    assert trial.docked
    assert trial.retries == 0
    assert settings_of(DOCK_POSE).timeouts.blocked_after < 2.5


def test_current_flows_once_the_contacts_are_pushed_in() -> None:
    simulation = Simulation(Settings(start=Pose(-0.4), dock=DockSettings(travel=0.04)))
    while not simulation.contact:
        simulation.run(0.1, Velocity(0.04))
        assert simulation.time < 20.0
    assert simulation.robot.x == pytest.approx(DOCKED.x + 0.04, abs=0.005)


def test_a_lip_holds_the_robot_until_it_has_pushed_and_only_in_front_of_it() -> None:
    simulation = Simulation(Settings(start=Pose(-0.3), dock=DockSettings(lip=1.5)))
    simulation.run(2.0, Velocity(0.04))
    for _ in range(10):
        simulation.run(0.1, Velocity(0.04))
    held = simulation.robot.x
    assert held == pytest.approx(DOCKED.x - 0.04, abs=0.002)
    simulation.run(0.3, STANDSTILL)  # what it has pushed before does not count
    for _ in range(12):
        simulation.run(0.1, Velocity(0.04))
    assert simulation.robot.x == pytest.approx(held, abs=0.002)
    for _ in range(20):
        simulation.run(0.1, Velocity(0.04))
    assert simulation.contact
    assert simulation.bumps == 0
