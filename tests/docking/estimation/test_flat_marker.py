"""Detections of a flat marker whose heading is mirrored now and then."""

import math
from random import Random

import pytest

from docking.core.geometry import Pose, normalize_angle
from docking.estimation.flat_marker import FlatMarker

START = Pose(-1.5, 0.4, math.atan2(-0.4, 1.5))


def way(random: Random) -> list[Pose]:
    """A second at the start, then to a place in front of the marker, and straight to it; 15 poses a second."""
    front = Pose(-0.7, random.uniform(-0.05, 0.05))
    poses = [START] * 15
    for begin, end, count in ((START, front, 60), (front, Pose(-0.3, 0.0), 40)):
        for number in range(count):
            part = number / count
            x, y = begin.x + part * (end.x - begin.x), begin.y + part * (end.y - begin.y)
            poses.append(Pose(x, y, math.atan2(-y, -x)))
    return poses


def look(robot: Pose, noise: float, random: Random, *, mirrored: bool) -> Pose:
    """The marker at the origin, as detected from `robot`."""
    line_of_sight = math.atan2(-robot.y, -robot.x)
    heading = 2.0 * line_of_sight if mirrored else 0.0
    return Pose(random.gauss(0.0, 0.005), random.gauss(0.0, 0.005), heading + random.gauss(0.0, noise))


@pytest.mark.parametrize("seed", range(40))
def test_the_heading_that_stays_where_it_is_is_found_as_the_robot_moves(seed: int) -> None:
    random, flat, late = Random(seed), FlatMarker(), []
    mirrored = False
    for number, robot in enumerate(way(random)):
        if number % 8 == 0:
            mirrored = random.random() < 0.5 or number == 0
        seen = look(robot, math.radians(1.0), random, mirrored=mirrored)
        corrected, _ = flat.correct(seen, robot, robot, Pose())
        if number > 90:
            late.append(abs(normalize_angle(corrected.theta)))
    assert sum(late) / len(late) < math.radians(3.0)
    assert max(late) < math.radians(8.0)


@pytest.mark.parametrize("noise", [0.5, 1.0, 3.0, 8.0])
@pytest.mark.parametrize(("wrong", "most"), [(0.0, 0), (0.3, 3)])
def test_nothing_is_corrected_where_detections_are_only_noisy_or_wrong(noise: float, wrong: float, most: int) -> None:
    """Among many wrong headings, some look like mirrored ones by chance."""
    mistaken = 0
    for seed in range(30):
        random, flat = Random(f"{seed} {noise}"), FlatMarker()
        for robot in way(random):
            seen = look(robot, math.radians(noise), random, mirrored=False)
            if random.random() < wrong:
                seen = Pose(seen.x, seen.y, seen.theta + random.uniform(-1.0, 1.0))
            corrected = flat.correct(seen, robot, robot, Pose())
            assert flat.mirrors or corrected == (seen, False)
        mistaken += flat.mirrors
    assert mistaken <= most


def test_a_robot_that_is_carried_elsewhere_begins_again() -> None:
    """The heading of the marker in odom has changed by 50 degrees."""
    random, flat, moved = Random(1), FlatMarker(), math.radians(50.0)
    for number in range(400):
        turned = moved if number > 200 else 0.0
        robot = Pose(-1.5, 0.002 * (number % 200) - 0.1)
        seen = look(robot, 0.01, random, mirrored=number // 8 % 2 == 0)
        place = Pose(0.0, 0.0, turned)
        corrected, _ = flat.correct(place.compose(seen), place.compose(robot), place.compose(robot), place)
    assert normalize_angle(corrected.theta - moved) == pytest.approx(0.0, abs=0.05)
