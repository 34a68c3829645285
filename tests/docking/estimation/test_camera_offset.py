"""Where the camera is, measured as the robot turns on the spot."""

import math
from random import Random

import pytest

from docking.core.geometry import Pose
from docking.estimation.camera_offset import CameraOffset, Offset


def measure(
    offset: Pose, seed: int, *, turned: float = 0.0, wrong: float = 0.0, side: float = 25.0, slip: float = 0.05
) -> Offset | None:
    """Turn to the left and to the right in front of a marker that is turned, with detections that may be wrong."""
    random, camera = Random(seed), CameraOffset()
    for number in range(130):
        heading = math.radians(side) * math.sin(number / 130 * 4.0 * math.pi)
        robot = Pose(-0.7 + random.uniform(-0.003, 0.003), 0.02, (1.0 + slip) * heading)
        seen = offset.inverse().compose(Pose(-0.7, 0.02, heading).inverse().compose(Pose(theta=turned)))
        seen = Pose(seen.x + random.gauss(0, 0.01), seen.y + random.gauss(0, 0.01), seen.theta + random.gauss(0, 0.017))
        if random.random() < wrong:
            seen = Pose(seen.x + random.uniform(-0.3, 0.3), seen.y, seen.theta + random.uniform(-1.0, 1.0))
        camera.add(robot.compose(seen), robot)
    return camera.measure()


@pytest.mark.parametrize("x", [0.0, -0.05])
@pytest.mark.parametrize("y", [0.0, 0.03, -0.03])
@pytest.mark.parametrize("wrong", [0.0, 0.2])
def test_it_is_found_as_well_as_it_says(x: float, y: float, wrong: float) -> None:
    for seed in range(15):
        found = measure(Pose(x, y), seed, wrong=wrong)
        assert found is not None
        assert found.deviation < 0.01
        assert abs(found.x - x) < 4.0 * found.deviation
        assert abs(found.y - y) < 4.0 * found.deviation


@pytest.mark.parametrize("turned", [0.1, -0.1])
def test_a_marker_or_a_camera_that_is_turned_is_no_offset(turned: float) -> None:
    for found in (measure(Pose(), 1, turned=turned), measure(Pose(theta=turned), 1)):
        assert found is not None
        assert abs(found.y) < 4.0 * found.deviation


def test_nothing_is_said_where_the_robot_hardly_turned_or_odometry_misjudges_its_turns() -> None:
    assert measure(Pose(), 1, side=8.0) is None
    assert measure(Pose(), 1, slip=0.5) is None


def test_detections_from_elsewhere_begin_again() -> None:
    camera = CameraOffset()
    for number in range(100):
        robot = Pose(-2.0 + 0.01 * number, 0.0, 0.3 * math.sin(0.2 * number))
        camera.add(Pose(), robot)
    assert camera.measure() is None
