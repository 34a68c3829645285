import math
from random import Random

import pytest

from docking.core.battery import BatteryReading
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, MarkerDetection, Observation, Odometry
from docking.estimation.marker_filter import PATIENCE, MarkerFilter

MARKER = Pose(1.0, 0.2, 0.1)


def observed(now: float, marker: Pose | None, robot: Pose | None = None, stamp: float | None = None) -> Observation:
    return Observation(
        now,
        BatteryReading(3, now),
        Odometry(robot or Pose(), STANDSTILL, now),
        None if marker is None else MarkerDetection(marker, now if stamp is None else stamp),
    )


def noisy(pose: Pose, random: Random, metres: float = 0.01, angle: float = math.radians(1.0)) -> Pose:
    return Pose(pose.x + random.gauss(0, metres), pose.y + random.gauss(0, metres), pose.theta + random.gauss(0, angle))


@pytest.fixture
def settled() -> MarkerFilter:
    marker_filter, random = MarkerFilter(1.0), Random(1)
    for number in range(30):
        marker_filter.update(observed(number / 15, noisy(MARKER, random)))
    return marker_filter


def assert_near(pose: Pose | None, expected: Pose, metres: float = 0.005, angle: float = math.radians(0.6)) -> None:
    assert pose is not None
    assert pose.distance_to(expected) < metres
    assert abs(normalize_angle(pose.theta - expected.theta)) < angle


def test_it_knows_nothing_at_first() -> None:
    marker_filter = MarkerFilter(1.0)
    marker_filter.update(observed(0.0, None))
    assert marker_filter.pose is None
    assert marker_filter.count == 0


def test_noise_is_averaged_out(settled: MarkerFilter) -> None:
    assert_near(settled.pose, MARKER)
    assert settled.count == 30


def test_an_outlier_is_left_out_and_shown_as_the_last_detection(settled: MarkerFilter) -> None:
    before, outlier = settled.pose, Pose(1.5, 0.2, 0.1)
    settled.update(observed(3.0, outlier))
    assert settled.pose == before
    assert settled.raw == outlier
    assert settled.seen_at < 3.0


def test_a_marker_seen_mirrored_is_an_outlier(settled: MarkerFilter) -> None:
    settled.update(observed(3.0, Pose(MARKER.x, MARKER.y, MARKER.theta - math.radians(40))))
    assert_near(settled.pose, MARKER)


def test_several_outliers_in_a_row_prove_it_wrong(settled: MarkerFilter) -> None:
    moved, random = Pose(1.2, -0.3, 0.5), Random(2)
    for number in range(PATIENCE):
        assert_near(settled.pose, MARKER)
        settled.update(observed(3.0 + number / 15, noisy(moved, random)))
    assert_near(settled.pose, moved, metres=0.04, angle=math.radians(4))
    assert settled.count == 1


def test_the_same_detection_counts_once(settled: MarkerFilter) -> None:
    for number in range(10):
        settled.update(observed(3.0 + number / 100, MARKER, stamp=3.0))
    assert settled.count == 31


def test_an_old_detection_does_not_count(settled: MarkerFilter) -> None:
    settled.update(observed(9.0, MARKER, stamp=7.9))
    assert settled.count == 30


@pytest.mark.parametrize("stamp", [math.nan, math.inf, 50.0])
def test_a_detection_from_the_future_does_not_count_nor_hide_the_next_ones(settled: MarkerFilter, stamp: float) -> None:
    settled.update(observed(3.0, MARKER, stamp=stamp))
    assert settled.count == 30
    settled.update(observed(3.1, MARKER))
    assert settled.count == 31


@pytest.mark.parametrize("nonsense", [math.nan, math.inf, 1e300])
def test_nonsense_does_not_count(settled: MarkerFilter, nonsense: float) -> None:
    before = settled.pose
    for number in range(2 * PATIENCE):
        settled.update(observed(3.0 + number / 15, Pose(nonsense, 0.0, 0.0)))
        settled.update(observed(3.01 + number / 15, Pose(0.0, 0.0, nonsense if nonsense < 1e299 else math.nan)))
    assert settled.pose == before


def test_the_marker_stays_while_the_robot_drives_and_new_detections_count_more_then(settled: MarkerFilter) -> None:
    settled.update(observed(3.0, None, Pose()))
    for number in range(20):
        settled.update(observed(3.1 + number / 10, None, Pose(-0.05 * number)))
    assert_near(settled.pose, MARKER)
    drifted = Pose(MARKER.x + 0.05, MARKER.y, MARKER.theta)
    settled.update(observed(6.0, drifted, Pose(-1.0)))
    assert settled.pose is not None
    assert settled.pose.x - MARKER.x > 0.04
