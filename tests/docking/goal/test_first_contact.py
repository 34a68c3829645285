"""The first contact is slow, also where it comes earlier than expected, with a base that brakes badly and late."""

from collections import deque
from random import Random

import pytest
from benchmarks.docking.cases import CASES
from benchmarks.docking.trial import run_trial

from docking.core.geometry import Pose
from docking.core.observation import Velocity
from docking.estimation.motion_model import MotionModel
from docking.goal.pace import Pace
from docking.goal.plan import KnownPoses
from docking.parameters import ApproachSettings, ControllerName, MotionLimits
from docking.parameters.limits import braked

LIMITS, RADIUS = MotionLimits(), ApproachSettings().slowdown_radius
PERIOD = 0.05
CONTACT = 0.02
"""How far before the docked pose the contacts are, in m."""
SLOWEST = LIMITS.v_linear_min + 0.005
ROWS = {case.name: case for case in CASES}


def drive_on(braking: float, latency: float, early: float, *, start: float, stop_first: bool, jitter: Random) -> float:
    """Drive straight at a dock; return the speed of the base, in m/s, when it touches.

    Args:
        braking: Of the base, in m/s².
        latency: From a command to the wheels, in s.
        early: How far before the docked pose the dock is, in m.
        start: The same of the robot.
        stop_first: Whether it stops on the way once, so that its brakes are known.
        jitter: Of the control period.
    """
    model, pace, docked = MotionModel(), Pace(LIMITS, RADIUS), Pose()
    poses = KnownPoses(docked, docked, Pose(-0.7))
    x, speed, now, coming = -start, 0.0, 0.0, deque([(0.0, 0.0)])
    while x < -early and now < 60.0:
        model.update(now, Pose(x))
        stops = stop_first and 1.5 < now < 6.0
        wished = 0.0 if stops else LIMITS.v_linear_min + braked(max(0.0, -x - RADIUS), LIMITS.a_linear_max)
        dt = PERIOD * jitter.uniform(0.5, 1.5)
        model.commanded = pace.next(Velocity(min(0.26, wished)), dt, Pose(x), poses, model)
        coming.append((now + latency, model.commanded.linear_x))
        for _ in range(5):
            while len(coming) > 1 and coming[1][0] <= now:
                coming.popleft()
            wanted = coming[0][1]
            change = 0.2 * dt
            speed = max(wanted, speed - braking * change) if wanted < speed else min(wanted, speed + change)
            x, now = x + speed * change, now + change
            if x >= -early:
                break
    assert x >= -early, "it gets there"
    return speed


@pytest.mark.parametrize("seed", range(300))
def test_no_base_touches_a_dock_fast_that_is_nearer_than_expected(seed: int) -> None:
    """A camera that is up to 5 cm off, or a bumper that is up to 8 cm longer."""
    random = Random(seed)
    early = CONTACT + random.choice((random.uniform(-0.05, 0.05), random.uniform(0.0, 0.08)))
    speed = drive_on(
        random.uniform(0.1, 1.0),
        random.uniform(0.0, 0.4),
        early,
        start=random.choice((2.5, 1.5, 0.7)),
        stop_first=random.random() < 0.5,
        jitter=random,
    )
    assert speed <= SLOWEST


@pytest.mark.parametrize(
    ("controller", "name"),
    [
        (ControllerName.DOCK_POSE, "base brakes at 0.1 m/s²"),
        (ControllerName.DOCK_POSE, "base accelerates and brakes at 0.1 m/s²"),
        (ControllerName.INFRARED, "base brakes at 0.1 m/s²"),
        (ControllerName.DOCK_POSE, "camera 5 cm farther back than said"),
        (ControllerName.DOCK_POSE, "camera 5 cm farther ahead than said"),
        (ControllerName.DOCK_POSE, "bumper 8 cm longer than said"),
    ],
)
def test_it_docks_and_touches_slowly(controller: ControllerName, name: str) -> None:
    for seed in (1, 2):
        trial = run_trial(controller, seed, ROWS[name])
        assert trial.docked
        assert max(trial.contacts) <= SLOWEST
