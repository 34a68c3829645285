"""No goal takes longer than all its limits together, whatever comes and goes."""

from random import Random

import pytest

from docking.core.battery import BatteryReading
from docking.core.errors import ErrorCode, FailedToDetectDock, Stage
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.time_limits import TimeLimits
from docking.parameters import ControllerName, DockSettings, DockTimeouts
from docking.plans.registry import make_plan
from tests.support.random_goals import RandomPlan, docking_goal, real_plan, run, undocking_goal


@pytest.mark.parametrize("seed", range(240))
def test_whatever_comes_and_goes_a_goal_ends_within_all_its_limits(seed: int) -> None:
    random = Random(seed)
    goal = undocking_goal(random) if seed % 12 == 0 else docking_goal(random)
    _, outcome = run(goal, random)
    assert outcome is not None


@pytest.mark.parametrize("seed", range(60))
def test_so_does_a_goal_with_a_plan_of_ours(seed: int) -> None:
    random = Random(seed)
    _, outcome = run(docking_goal(random, real_plan(random)), random)
    assert outcome is not None


def test_a_plan_without_odometry_has_no_limit_but_that_of_the_goal() -> None:
    rotate = make_plan(DockSettings())
    assert TimeLimits(rotate, Docking(DockTimeouts())).longest() == float("inf")
    assert TimeLimits(rotate, Docking(DockTimeouts(goal_timeout=30.0))).longest() == 30.0


def test_neither_has_its_waiting_for_a_battery_that_speaks_rarely() -> None:
    goal = Goal(make_plan(DockSettings()), Docking(DockTimeouts()), 0.0)
    for tenth in range(20_000):
        now = 0.1 * tenth
        goal.step(Observation(now, BatteryReading(3, 10.0 * (now // 10.0))))
    assert goal.outcome is None


def test_all_limits_count_and_those_of_waits_twice() -> None:
    plan = make_plan(DockSettings(controller=ControllerName.DOCK_POSE))
    timeouts = DockTimeouts(max_retries=0, charge_stable_for=0.0)
    driven = 20.0 + 60.0 + 30.0 + 5.0 + 300.0
    assert TimeLimits(plan, Docking(timeouts), 30.0).longest() == 2.0 * driven + 2.0 * (60.0 + 5.0 + 30.0)
    assert TimeLimits(plan, Docking(timeouts)).longest(before=1000.0) == 2.0 * (1000.0 + driven) + 2.0 * (60.0 + 5.0)


def test_the_time_of_the_search_is_not_that_of_the_stage_and_neither_begins_again() -> None:
    limits = TimeLimits(RandomPlan(Random(0)), Docking(DockTimeouts()))
    for _ in range(3):
        limits.count(90.0, searches=True)
        limits.count(6.0)
        assert limits.exceeded(Stage.INITIAL_PERCEPTION, finished=False) is None
    limits.count(31.0, searches=True)
    error = limits.exceeded(Stage.INITIAL_PERCEPTION, finished=False)
    assert isinstance(error, FailedToDetectDock)
    assert str(error) == "the dock was not found within 300 s (search_timeout)"
    limits.enter()
    limits.count(21.0)
    assert "initial_perception_timeout" in str(limits.exceeded(Stage.INITIAL_PERCEPTION, finished=False))


@pytest.mark.parametrize(("age", "code"), [(2.5, ErrorCode.BATTERY_LOST), (0.0, ErrorCode.ODOMETRY_LOST)])
def test_what_comes_but_always_too_late_is_not_waited_for_forever(age: float, code: ErrorCode) -> None:
    plan = make_plan(DockSettings(controller=ControllerName.DOCK_POSE))
    goal, now = Goal(plan, Docking(DockTimeouts()), 0.0), 0.0
    while (outcome := goal.step(observed(now, age))) is not goal.outcome:
        now += 0.1
        assert now < goal.longest
    assert outcome.error_code is code
    assert "what it waits for comes and goes" in outcome.error_msg


def observed(now: float, age: float) -> Observation:
    """A battery of an age, and odometry that is 1 s old."""
    return Observation(now, BatteryReading(3, now - age), Odometry(Pose(), STANDSTILL, now - 1.0))
