import math
from collections import deque
from dataclasses import replace
from random import Random

import pytest

from docking.core.errors import Blocked, OdometryLost
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.goal.motion_watch import MotionWatch
from docking.goal.pace import Limiter
from docking.parameters import MotionLimits

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


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.25, 0.5])
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


@pytest.mark.parametrize("share", [0.4, 0.58, 1.0])
def test_a_base_that_drives_slower_than_it_is_told_is_not_blocked(share: float) -> None:
    drive(watch(), Velocity(0.26, 0.0), Velocity(0.26 * share, 0.0), 10.0)
    drive(watch(), Velocity(0.0, 1.0), Velocity(0.0, share), 10.0)


def reverse(motion: MotionWatch, acceleration: float, slowest: float) -> None:
    """Drive forwards, then be told to drive backwards: the base gets there slowly, or no farther than `slowest`."""
    pose = drive(motion, Velocity(0.26), Velocity(0.26), 3.0)
    for number in range(120):
        speed = max(slowest, 0.26 - acceleration * number * PERIOD)
        pose = drive(motion, Velocity(-0.26), Velocity(speed), PERIOD, start=3.0 + number * PERIOD, pose=pose)


@pytest.mark.parametrize("acceleration", [0.15, 0.2, 0.5])
def test_a_weak_base_that_reverses_is_not_blocked(acceleration: float) -> None:
    reverse(watch(), acceleration, slowest=-0.26)


@pytest.mark.parametrize("slowest", [0.26, 0.0])
def test_a_base_that_does_not_reverse_is_blocked(slowest: float) -> None:
    with pytest.raises(Blocked):
        reverse(watch(), 0.2, slowest)


def test_a_base_that_stops_against_its_command_is_blocked_in_time() -> None:
    motion = watch()
    pose = drive(motion, Velocity(0.26), Velocity(0.26), 3.0)
    with pytest.raises(Blocked):
        drive(motion, Velocity(0.26), STANDSTILL, 1.6, start=3.0, pose=pose)


def test_motion_that_was_not_commanded_does_not_match() -> None:
    with pytest.raises(Blocked, match="motion does not match command"):
        drive(watch(), STANDSTILL, Velocity(0.1, 0.0), 3.0)


def test_a_late_base_that_was_told_to_rest_may_still_move() -> None:
    """It stops 0.4 s after the command: the motion before it counts, too."""
    motion = watch()
    pose = drive(motion, Velocity(0.26, 0.0), STANDSTILL, 0.4)
    pose = drive(motion, Velocity(0.26, 0.0), Velocity(0.26, 0.0), 3.0, start=0.4, pose=pose)
    motion.rest()
    pose = drive(motion, STANDSTILL, Velocity(0.26, 0.0), 0.4, start=3.4, pose=pose)
    drive(motion, STANDSTILL, STANDSTILL, 3.0, start=3.8, pose=pose)


def test_a_rest_does_not_hide_that_it_is_blocked() -> None:
    motion = watch()
    pose = drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.9)
    motion.rest()
    with pytest.raises(Blocked):
        drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.9, start=1.9, pose=pose)


def test_motion_while_odometry_was_silent_counts_as_commanded_until_the_rest() -> None:
    """On a slow machine odometry is late again and again: the robot rests from then on, not since the last pose."""
    motion, pose, now = watch(), Pose(), 0.0
    for _ in range(40):
        assert step(motion, now, pose)
        motion.commanded = Velocity(0.1, 0.0)
        pose, now = pose.compose(Pose(0.1 * 0.35)), now + 0.35
        motion.elapse(now)
        assert not motion.sees(Observation(now))
        motion.rest()
        now += 0.03
        motion.elapse(now)


def test_once_it_was_reported_the_comparison_begins_again() -> None:
    motion = watch()
    with pytest.raises(Blocked):
        drive(motion, Velocity(0.2, 0.0), STANDSTILL, 3.0)
    drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.9, start=2.05)


def test_ahead_the_robot_is_where_it_will_be() -> None:
    motion = watch()
    pose = drive(motion, Velocity(0.2, 0.0), STANDSTILL, 0.3)
    pose = drive(motion, Velocity(0.2, 0.0), Velocity(0.2, 0.0), 3.0, start=0.3, pose=pose)
    seen = Observation(3.3, odometry=Odometry(pose, STANDSTILL, 3.3))
    motion.sees(seen)
    ahead = motion.ahead(seen).odometry
    assert ahead is not None
    assert ahead.pose.x == pytest.approx(pose.x + 0.2 * 0.3, abs=0.005)
    assert ahead.velocity.linear_x == pytest.approx(0.2), "measured from poses"
    assert motion.ahead(Observation(3.3)) == Observation(3.3)


def test_what_was_before_a_pause_does_not_count() -> None:
    motion = watch()
    pose = drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.5)
    drive(motion, Velocity(0.2, 0.0), STANDSTILL, 1.9, start=6.0, pose=pose)


def step(motion: MotionWatch, now: float, pose: Pose | None = None) -> bool:
    return motion.sees(Observation(now, odometry=Odometry(pose or Pose(), STANDSTILL, now)))


def stuck(times: list[float]) -> float | None:
    """When a robot that is commanded to drive, and stands still, is blocked; None if it is not."""
    motion = watch()
    for now in times:
        try:
            step(motion, now)
        except Blocked:
            return now
        motion.commanded = Velocity(0.2, 0.0)
    return None


def every_quarter(first: float, last: float) -> list[float]:
    return [0.25 * number for number in range(int(first * 4), int(last * 4) + 1)]


def test_it_is_blocked_as_soon_as_the_time_is_over() -> None:
    assert stuck(every_quarter(0.0, 3.0)) == 2.0
    assert stuck(sorted([*every_quarter(0.0, 3.0), 1.0])) == 2.0, "one observation may come twice"


def test_a_pause_of_04_s_counts_and_a_longer_one_does_not() -> None:
    assert stuck([0.0, 0.4, *every_quarter(0.5, 3.0)]) == 2.0
    assert stuck([0.0, 0.45, *every_quarter(0.5, 3.0)]) == 2.5


def test_a_few_centimeters_that_are_missing_mean_nothing() -> None:
    motion = watch()
    for now in every_quarter(0.0, 6.0):
        assert step(motion, now)
        motion.commanded = Velocity(0.016, 0.08)


def test_a_long_drive_before_does_not_hide_that_it_is_blocked() -> None:
    motion = watch()
    drive(motion, Velocity(0.25, 0.0), Velocity(0.25, 0.0), 60.0)
    with pytest.raises(Blocked):
        drive(motion, Velocity(0.25, 0.0), STANDSTILL, 2.1, start=60.0, pose=Pose(15.0))


def test_it_starts_and_rests_at_a_standstill() -> None:
    motion = watch()
    assert motion.commanded == STANDSTILL
    motion.commanded = Velocity(0.2, 0.0)
    motion.rest()
    assert motion.commanded == STANDSTILL


def test_odometry_may_be_03_s_old() -> None:
    odometry = Odometry(Pose(), STANDSTILL, 0.0)
    assert watch().sees(Observation(0.3, odometry=odometry))
    assert not watch().sees(Observation(0.31, odometry=odometry))


def test_odometry_is_lost_only_after_its_time_and_the_error_says_so() -> None:
    motion = watch()
    assert not motion.sees(Observation(1.0))
    with pytest.raises(OdometryLost, match=r"^no odometry for 1 s \(odometry_timeout\)$"):
        motion.sees(Observation(1.01))


def test_a_wait_for_odometry_is_reported_after_a_second_until_it_is_back() -> None:
    motion = MotionWatch(odometry_timeout=5.0, blocked_after=2.0, started_at=0.0)
    assert step(motion, 0.0, Pose())
    for now in (0.5, 1.0):
        assert not motion.sees(Observation(now, odometry=Odometry(Pose(), STANDSTILL, 0.0)))
        assert motion.waiting == ""
    for now in (1.01, 5.0):
        assert not motion.sees(Observation(now, odometry=Odometry(Pose(), STANDSTILL, 0.0)))
        assert motion.waiting == "no odometry for over 1 s: the robot waits"
    assert step(motion, 5.01, Pose())
    assert motion.waiting == ""


@pytest.mark.parametrize(("pose", "believed"), [(Pose(0.25), True), (Pose(0.4), False), (Pose(theta=1.0), False)])
def test_after_a_silence_a_pose_elsewhere_is_of_a_base_that_has_restarted(pose: Pose, believed: bool) -> None:
    motion = MotionWatch(odometry_timeout=5.0, blocked_after=2.0, started_at=0.0)
    assert step(motion, 0.0, Pose())
    assert not motion.sees(Observation(4.0, odometry=Odometry(Pose(), STANDSTILL, 0.0)))
    if believed:
        assert step(motion, 4.5, pose)
    else:
        with pytest.raises(Blocked, match="odometry jumped"):
            step(motion, 4.5, pose)
    assert step(motion, 4.55, pose)


@pytest.mark.parametrize("pose", [Pose(1e6), Pose(0.0, -1e6), Pose(0.0, 0.0, 1e6)])
def test_a_pose_too_far_away_is_none(pose: Pose) -> None:
    assert not step(watch(), 0.5, pose)
    with pytest.raises(OdometryLost, match="implausible pose, Pose"):
        step(watch(), 1.5, pose)


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


def freeze(motion: MotionWatch, told: Velocity, last: Odometry, seconds: float) -> float:
    """Odometry repeats its last message with new stamps; after how many seconds the robot does not know where it is."""
    unknown = math.inf
    for number in range(round(seconds / PERIOD)):
        now = last.stamp + number * PERIOD
        if motion.sees(Observation(now, odometry=replace(last, stamp=now))):
            motion.commanded = told
        else:
            motion.rest()
            unknown = min(unknown, now - last.stamp)
    return unknown


@pytest.mark.parametrize("told", [Velocity(0.26), Velocity(-0.15), Velocity(0.0, 0.6)])
def test_odometry_that_repeats_its_pose_while_it_says_that_it_moves_is_silent(told: Velocity) -> None:
    motion = watch()
    pose = drive(motion, told, told, 3.0)
    last = Odometry(pose, told, 3.0)
    assert freeze(motion, told, last, 0.9) < 0.3
    with pytest.raises(OdometryLost, match="one pose, again and again"):
        freeze(motion, told, replace(last, stamp=3.9), 1.0)


def test_odometry_that_goes_on_is_believed_again() -> None:
    motion, told = watch(), Velocity(0.2)
    pose = drive(motion, told, told, 3.0)
    freeze(motion, told, Odometry(pose, told, 3.0), 0.5)
    drive(motion, told, told, 5.0, start=3.5, pose=pose.compose(Pose(0.06)))


def test_odometry_without_velocities_is_doubted_for_a_moment_and_then_the_robot_is_blocked() -> None:
    motion, told, pose = watch(), Velocity(0.2), Pose()
    for number in range(60):
        assert motion.sees(Observation(number * PERIOD, odometry=Odometry(pose, STANDSTILL, number * PERIOD)))
        motion.commanded = told
        pose = pose.compose(Pose(0.2 * PERIOD))
    last = Odometry(pose, STANDSTILL, 3.0)
    assert freeze(motion, told, last, 1.0) < 0.3
    with pytest.raises(Blocked, match="the robot is blocked, or its odometry repeats one pose"):
        freeze(motion, Velocity(0.04), replace(last, stamp=4.0), 5.0)


@pytest.mark.parametrize(
    "jump", [Pose(1.0), Pose(-0.5), Pose(-0.12), Pose(0.0, 0.3), Pose(0.0, 0.0, 1.5), Pose(-100.0, 3.0, -3.0)]
)
def test_odometry_that_jumps_stops_the_robot_at_once_and_is_named(jump: Pose) -> None:
    motion, told = watch(), Velocity(0.2)
    pose = drive(motion, told, told, 3.0).compose(jump)
    with pytest.raises(Blocked, match=r"^odometry jumped: .* from Pose.* to Pose"):
        motion.sees(Observation(3.0, odometry=Odometry(pose, told, 3.0)))
    drive(motion, told, told, 3.0, start=3.05, pose=pose)


def test_a_robot_that_was_carried_during_a_long_pause_did_not_jump() -> None:
    motion = watch()
    pose = drive(motion, Velocity(0.2), Velocity(0.2), 3.0)
    assert motion.sees(Observation(9.0, odometry=Odometry(pose.compose(Pose(1.0, 0.5, 1.0)), STANDSTILL, 9.0)))


@pytest.mark.parametrize("speed", [0.26, 0.15, -0.2])
@pytest.mark.parametrize("braking", [0.08, 0.1, 0.2])
def test_a_base_that_rolls_on_is_not_blocked(speed: float, braking: float) -> None:
    motion = watch()
    pose = drive(motion, Velocity(speed), Velocity(speed), 3.0)
    for step in range(120):
        rolls = math.copysign(max(0.0, abs(speed) - braking * step * PERIOD), speed)
        pose = drive(motion, STANDSTILL, Velocity(rolls), PERIOD, start=3.0 + step * PERIOD, pose=pose)


def test_a_base_that_never_slows_down_is_blocked() -> None:
    motion = watch()
    pose = drive(motion, Velocity(0.2), Velocity(0.2), 3.0)
    with pytest.raises(Blocked):
        drive(motion, STANDSTILL, Velocity(0.2), 3.0, start=3.0, pose=pose)
