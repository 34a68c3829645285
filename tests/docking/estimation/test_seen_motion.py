"""What is seen must move as the robot drives: repeated images, wrong odometry, detections that are late."""

import math
from collections.abc import Callable
from random import Random

import pytest

from docking.core.geometry import Pose
from docking.estimation.seen_motion import SeenMotion

MARKER = Pose(2.0, 0.3, 0.1)
RATE = 15.0


def drive(at: float) -> Pose:
    """A robot that stands for 1 s, turns a little, speeds up to 0.2 m/s, and stops after 5 s."""
    turned = 0.3 * min(1.0, max(0.0, at - 1.0))
    way = 0.2 * min(3.0, max(0.0, at - 2.0))
    return Pose(way * math.cos(turned), way * math.sin(turned), turned)


def watch(
    seen_from: Callable[[float], Pose], odometry: Callable[[float], Pose] = drive, noise: float = 0.01, seed: int = 1
) -> tuple[SeenMotion, str]:
    """Follow a marker that is seen from the poses of one function, with odometry of another one."""
    motion, random = SeenMotion(), Random(seed)
    for step in range(int(6.0 * RATE)):
        now = step / RATE
        robot, seen = odometry(now), MARKER.relative_to(seen_from(now))
        noisy = Pose(
            seen.x + random.gauss(0, noise), seen.y + random.gauss(0, noise), seen.theta + random.gauss(0, noise)
        )
        motion.drive(now, robot)
        if not motion.believes(robot.compose(noisy), now):
            break
    return motion, motion.doubt


@pytest.mark.parametrize("noise", [0.001, 0.01, 0.05])
@pytest.mark.parametrize("seed", range(4))
def test_a_marker_that_stands_still_is_believed(noise: float, seed: int) -> None:
    motion, doubt = watch(drive, noise=noise, seed=seed)
    assert doubt == ""
    assert (motion.proven, motion.lag) == (True, 0.0)


@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize("frozen_at", [0.0, 1.3, 3.0, 4.0])
def test_a_marker_that_moves_with_the_robot_is_not(noise: float, frozen_at: float) -> None:
    _, doubt = watch(lambda at: drive(min(at, frozen_at)), noise=noise)
    assert "at one place while odometry measured" in doubt


def test_a_robot_that_stands_proves_nothing() -> None:
    motion, doubt = watch(lambda at: Pose(), lambda at: Pose())
    assert (motion.proven, doubt) == (False, "")


@pytest.mark.parametrize("late", [0.2, 0.5, 0.8])
def test_how_late_detections_are_is_found_out(late: float) -> None:
    motion, doubt = watch(lambda at: drive(at - late))
    assert doubt == ""
    assert motion.lag == pytest.approx(late, abs=0.11)
    assert motion.latest <= late + 0.21
    at = 5.9
    seen = drive(at).compose(MARKER.relative_to(drive(at - late)))
    assert motion.place(seen, at).distance_to(MARKER) < 0.06


def test_until_motion_tells_detections_may_be_late() -> None:
    motion = SeenMotion()
    assert motion.latest >= 0.8
    assert watch(drive)[0].latest <= 0.2


def test_a_marker_that_is_seen_rarely_is_believed() -> None:
    motion, random = SeenMotion(), Random(1)
    for step in range(2000):
        now = 0.05 * step
        robot = Pose(0.3 * math.sin(0.2 * now), 0.0, math.sin(0.1 * now))
        motion.drive(now, robot)
        if step % 60 == 0:
            seen = MARKER.relative_to(robot)
            noisy = Pose(seen.x + random.gauss(0.0, 0.01), seen.y + random.gauss(0.0, 0.01), seen.theta)
            assert motion.believes(robot.compose(noisy), now), motion.doubt


def watch_recovery(noise: float, *, recovers: bool) -> SeenMotion:
    """Follow an image that freezes at 3 s; the robot stops at 4 s, and another image comes 1 s later, or never."""
    motion, random = SeenMotion(), Random(2)
    for step in range(int(8.0 * RATE)):
        now = step / RATE
        robot = drive(min(now, 4.0))
        seen = MARKER.relative_to(robot if now < 3.0 or (recovers and now > 5.0) else drive(3.0))
        noisy = Pose(
            seen.x + random.gauss(0.0, noise), seen.y + random.gauss(0.0, noise), seen.theta + random.gauss(0.0, noise)
        )
        motion.drive(now, robot)
        motion.believes(robot.compose(noisy), now)
    return motion


@pytest.mark.parametrize("noise", [0.0, 0.0002, 0.01])
def test_another_image_is_believed_again_also_where_the_robot_stands(noise: float) -> None:
    motion = watch_recovery(noise, recovers=True)
    assert (motion.doubt, motion.doubts) == ("", 1)


@pytest.mark.parametrize("noise", [0.0, 0.0002, 0.01, 0.02])
def test_an_image_that_is_repeated_with_noise_is_no_other(noise: float) -> None:
    motion = watch_recovery(noise, recovers=False)
    assert (motion.doubt != "", motion.doubts) == (True, 1)
