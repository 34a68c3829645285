"""What is known of where the camera is, from goal to goal."""

import math
from collections.abc import Callable
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, MarkerDetection, Observation, Odometry
from docking.goal.plan import NothingLeftToTry
from docking.plans.camera_correction import LEAST, MOST, CameraCorrection

MARKER = Pose(0.7, 0.02, 0.05)
ENOUGH = 0.002
"""In m; detections are exact here."""
ways = st.floats(-0.1, 0.1)
places = st.builds(Pose, ways, ways)


def look_around(correction: CameraCorrection, camera: Pose, noise: Callable[[], float] = lambda: 0.0) -> bool:
    """Turn to the left and to the right in front of the marker, with a camera that is elsewhere; whether it learns."""
    for number in range(130):
        now, robot = 0.05 * number, Pose(theta=0.44 * math.sin(number / 130.0 * 4.0 * math.pi))
        seen = camera.inverse().compose(MARKER.relative_to(robot)).compose(Pose(noise(), noise()))
        observation = Observation(
            now, None, Odometry(robot, STANDSTILL, now), MarkerDetection(robot.compose(seen), now)
        )
        marker = correction.correct(observation).marker
        assert marker is not None
        correction.add(marker.pose, now, robot)
    return correction.conclude()


@settings(max_examples=60, deadline=None)
@given(believed=places, camera=places)
def test_what_earlier_goals_have_learned_and_what_is_left_make_the_whole(believed: Pose, camera: Pose) -> None:
    correction = CameraCorrection(believed)
    left = max(abs(camera.x - believed.x), abs(camera.y - believed.y))
    whole = max(abs(camera.x), abs(camera.y))
    try:
        corrects = look_around(correction, camera)
    except NothingLeftToTry:
        assert whole > MOST - ENOUGH
        return
    if not corrects:
        assert left <= LEAST + ENOUGH
        assert correction.applied == believed
        return
    assert left >= LEAST - ENOUGH
    assert whole <= MOST + ENOUGH
    off = correction.applied.distance_to(camera)
    assert correction.kept == correction.applied
    assert off <= 2.0 * ENOUGH or (correction.applied == Pose() and whole <= LEAST + ENOUGH)


def test_the_next_goal_says_what_to_correct_until_it_is() -> None:
    first = CameraCorrection()
    assert not first.reason
    assert look_around(first, Pose(y=0.03))
    assert first.reason.startswith("the camera seems to be 30 mm to the left of where tf has it: correct")
    second = CameraCorrection(first.applied)
    assert second.reason.startswith("the camera seems to be 30 mm to the left of where tf has it: correct")
    assert second.reason.endswith("An earlier goal measured it")
    assert not look_around(second, Pose(y=0.03))
    third = CameraCorrection(second.applied)
    assert look_around(third, Pose())  # its mounting pose in tf was corrected
    assert third.reason == "the camera is where tf has it now, not where an earlier goal measured it"
    assert CameraCorrection(third.applied).reason == ""


def test_what_was_measured_badly_is_for_this_goal_alone() -> None:
    correction, random = CameraCorrection(), Random(1)
    assert look_around(correction, Pose(y=0.04), noise=lambda: random.gauss(0.0, 0.04))
    assert correction.applied != correction.kept == Pose()


def test_what_is_left_is_measured_once_in_a_goal() -> None:
    correction = CameraCorrection()
    assert look_around(correction, Pose(y=0.03))
    assert not look_around(correction, Pose(y=-0.03))
    assert correction.applied.y == pytest.approx(0.03, abs=ENOUGH)
