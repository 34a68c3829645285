import math
from collections import deque
from random import Random

import pytest

from docking.failures import Blocked, OdometryLost
from docking.geometry import Pose
from docking.limiter import Limiter, MotionLimits
from docking.motion import MotionWatch
from docking.observation import STANDSTILL, Observation, Odometry, Velocity

PERIOD = 0.05


def watch() -> MotionWatch:
    return MotionWatch(odometry_timeout=1.0, blocked_after=2.0, started_at=0.0)


def drive(
    motion: MotionWatch, told: Velocity, done: Velocity, seconds: float, *, start: float = 0.0, pose: Pose | None = None
) -> Pose:
    pose = pose or Pose()
    for number in range(round(seconds / PERIOD)):
        now = start + number * PERIOD
        assert motion.sees(Observation(now, odometry=Odometry(pose, done, now)))
        motion.commanded = told
        pose = pose.compose(Pose(done.linear_x * PERIOD, 0.0, done.angular_z * PERIOD))
    return pose


@pytest.mark.parametrize("told", [STANDSTILL, Velocity(0.26, 0.0), Velocity(-0.1, 0.5), Velocity(0.0, -1.0)])
@pytest.mark.parametrize("slip", [0.0, 0.1, -0.1])
def test_a_robot_that_does_as_it_is_told_is_not_blocked(told: Velocity, slip: float) -> None:
    drive(watch(), told, Velocity(told.linear_x * (1 - slip), told.angular_z * (1 - slip)), 20.0)


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.1])
def test_odometry_that_comes_late_does_not_make_it_blocked(delay: float) -> None:
    """Forwards, backwards, to and fro, as fast as the robot may, each for a random while."""
    motion, random, pose, told = watch(), Random(5), Pose(), STANDSTILL
    late = deque([pose] * (1 + round(delay / 0.01)))
    limiter, wish = Limiter(MotionLimits()), STANDSTILL
    for tick in range(30000):
        now = 0.01 * tick
        if random.random() < 0.007:
            wish = Velocity(random.choice([-0.26, -0.1, 0.0, 0.1, 0.26]), random.choice([-1.0, -0.35, 0.0, 0.35, 1.0]))
        if tick % 5 == 0:
            assert motion.sees(Observation(now, odometry=Odometry(late[0], told, now)))
            told = motion.commanded = limiter.limit(wish, PERIOD)
        pose = pose.compose(Pose(told.linear_x * 0.01, 0.0, told.angular_z * 0.01))
        late.append(pose)
        late.popleft()


@pytest.mark.parametrize(
    ("told", "done"),
    [
        (Velocity(0.26, 0.0), STANDSTILL),
        (Velocity(0.04, 0.0), STANDSTILL),
        (Velocity(-0.2, 0.0), STANDSTILL),
        (Velocity(0.0, 0.3), STANDSTILL),
        (Velocity(0.2, 0.0), Velocity(-0.2, 0.0)),
        (Velocity(0.2, 0.0), Velocity(0.1, 0.43)),  # the left wheel is stuck
    ],
)
def test_a_robot_that_does_not_is_blocked_after_a_while(told: Velocity, done: Velocity) -> None:
    motion = watch()
    pose = drive(motion, told, done, 1.95)
    with pytest.raises(Blocked):
        drive(motion, told, done, 0.2, start=1.95, pose=pose)


def test_what_was_before_a_rest_does_not_count() -> None:
    motion = watch()
    pose = drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.9)
    motion.rest()
    drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.9, start=1.9, pose=pose)


def test_what_was_before_a_pause_does_not_count() -> None:
    motion = watch()
    pose = drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.5)
    drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.9, start=6.0, pose=pose)


def test_without_odometry_it_sees_nothing_and_then_gives_up() -> None:
    motion = watch()
    assert not motion.sees(Observation(0.9))
    with pytest.raises(OdometryLost):
        motion.sees(Observation(1.1))


def test_odometry_that_stops_blinds_it_and_then_is_lost() -> None:
    motion, odometry = watch(), Odometry(Pose(), STANDSTILL, 10.0)
    assert motion.sees(Observation(10.2, odometry=odometry))
    assert not motion.sees(Observation(10.5, odometry=odometry))
    with pytest.raises(OdometryLost):
        motion.sees(Observation(11.1, odometry=odometry))


@pytest.mark.parametrize("nonsense", [math.nan, math.inf, 1e200, 5.4e6])
def test_odometry_that_makes_no_sense_is_none_and_then_lost(nonsense: float) -> None:
    motion = watch()
    assert not motion.sees(Observation(0.1, odometry=Odometry(Pose(nonsense), STANDSTILL, 0.1)))
    assert motion.sees(Observation(0.5, odometry=Odometry(Pose(), STANDSTILL, 0.5)))
    assert not motion.sees(Observation(1.4, odometry=Odometry(Pose(nonsense), STANDSTILL, 1.4)))
    with pytest.raises(OdometryLost, match="implausible pose"):
        motion.sees(Observation(1.6, odometry=Odometry(Pose(nonsense), STANDSTILL, 1.6)))
