"""What a laser sees and where a robot is to drive, reduced to what can be seen on a map."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from hypothesis import example, given
from hypothesis import strategies as st
from nav_msgs.msg import Path
from sensor_msgs.msg import LaserScan

from dock_gateway.core.laser import MAX_POINTS, path_points, scan_points, spread
from robot_io.transform import Transform, turn

UPSIDE_DOWN = Transform((1.0, 2.0, 0.3), turn((1.0, 0.0, 0.0), math.pi))
LEAST, FARTHEST = 0.1, 5.0
BAD = (0.0, math.nan, -1.0, 9.0, math.inf)
# Patterns of readings that repeat themselves, as those of lasers in dust, in rain and behind a fence.
PATTERNS = st.lists(st.sampled_from((1.0, 2.5, *BAD)), min_size=1, max_size=12)
PLACES = st.floats(-1e6, 1e6) | st.sampled_from((math.nan, math.inf, -math.inf, 1e300))


def scan_of(ranges: list[float], **fields: float) -> LaserScan:
    limits = {"angle_increment": 0.001, "range_min": LEAST, "range_max": FARTHEST}
    return LaserScan(ranges=ranges, **{**limits, **fields})


def path_of(places: list[tuple[float, float]]) -> Path:
    path = Path(poses=[PoseStamped() for _ in places])
    for pose, (x, y) in zip(path.poses, places, strict=True):
        pose.pose.position.x, pose.pose.position.y = x, y
    return path


def test_a_scan_is_thinned_and_what_is_out_of_range_left_out() -> None:
    points = scan_points(scan_of([1.0] * 1000 + [math.inf, math.nan, 9.0] * 100), Transform())
    assert 300 < len(points) <= MAX_POINTS
    assert all(math.hypot(x, y) == pytest.approx(1.0, abs=0.002) for x, y in points)
    assert points[0] == [1.0, 0.0]


@pytest.mark.parametrize("first", [0, 1])
def test_each_second_reading_is_enough(first: int) -> None:
    ranges = [1.0 if index % 2 == first else 0.0 for index in range(720)]
    assert len(scan_points(scan_of(ranges), Transform())) == MAX_POINTS


@given(PATTERNS, st.integers(1, 3000), st.lists(st.tuples(st.integers(0, 2999), st.sampled_from((0.5, *BAD)))))
def test_a_scan_shows_its_ends_and_whatever_is_nearest(
    pattern: list[float], length: int, others: list[tuple[int, float]]
) -> None:
    ranges = [pattern[index % len(pattern)] for index in range(length)]
    for index, reading in others:
        ranges[index % length] = reading
    good = [index for index, reading in enumerate(ranges) if LEAST <= reading <= FARTHEST]
    if not good and math.inf not in ranges:
        with pytest.raises(ValueError, match=r"no reading within its limits of 0\.1 to 5 m"):
            scan_points(scan_of(ranges), Transform())
        return
    points = np.array(scan_points(scan_of(ranges), Transform())).reshape(-1, 2)
    assert min(len(good), MAX_POINTS // 2) <= len(points) <= MAX_POINTS
    for index in good[:1] + good[-1:]:
        assert math.hypot(*points[0 if index == good[0] else -1]) == pytest.approx(ranges[index], abs=0.002)
    if good:
        assert min(math.hypot(x, y) for x, y in points) == pytest.approx(
            min(ranges[index] for index in good), abs=0.002
        )


def test_a_scanner_may_hang_upside_down() -> None:
    scan = scan_of([2.0], angle_min=0.5, angle_increment=0.1)
    (point,) = scan_points(scan, UPSIDE_DOWN)
    assert point == pytest.approx([1.0 + 2 * math.cos(0.5), 2.0 - 2 * math.sin(0.5)], abs=0.001)


def test_a_scan_that_makes_no_sense() -> None:
    with pytest.raises(ValueError, match="not valid"):
        scan_points(LaserScan(angle_min=math.nan, range_max=5.0, ranges=[1.0]), Transform())
    with pytest.raises(ValueError, match="readings"):
        scan_points(LaserScan(range_max=5.0, ranges=[1.0] * 100_001), Transform())
    far = Transform((1.7e308, 1.7e308, 0.0))
    for nowhere in (Transform((math.nan, 0.0, 0.0)), far, far.compose(far)):
        with pytest.raises(ValueError, match="not finite"):
            scan_points(LaserScan(range_max=5.0, ranges=[1.0]), nowhere)
    assert scan_points(LaserScan(range_max=5.0), Transform()) == []


@given(st.lists(st.tuples(PLACES, PLACES), max_size=12), st.integers(1, 300))
@example([(0.0, 0.0025)], 1)
def test_a_path_shows_its_ends_and_how_far_it_goes(pattern: list[tuple[float, float]], times: int) -> None:
    places = pattern * times
    good = [(x, y) for x, y in places if abs(x) <= 1e6 and abs(y) <= 1e6]
    if places and not good:
        with pytest.raises(ValueError, match="only points that are not finite"):
            path_points(path_of(places), Transform())
        return
    points = path_points(path_of(places), Transform())
    assert min(len(good), MAX_POINTS - 4) <= len(points) <= MAX_POINTS
    if good:
        for shown, place in ((points[0], good[0]), (points[-1], good[-1])):
            assert shown == pytest.approx(place, abs=0.000501)  # to a millimetre, however a half is rounded
        for axis in (0, 1):
            shown, all_of_it = ([place[axis] for place in some] for some in (points, good))
            assert (min(shown), max(shown)) == pytest.approx((min(all_of_it), max(all_of_it)), abs=0.001)


def test_a_path_keeps_its_ends() -> None:
    points = path_points(path_of([(float(index), 0.0) for index in range(1000)]), Transform())
    assert (len(points), points[0], points[-1]) == (MAX_POINTS, [0.0, 0.0], [999.0, 0.0])


@given(st.integers(0, 3000), st.integers(2, 500))
def test_indices_are_spread_from_the_first_to_the_last(count: int, most: int) -> None:
    chosen = spread(count, most).tolist()
    assert len(chosen) == min(count, most)
    if count > 1:
        assert np.ptp(np.diff(chosen)) <= 1
    if count:
        assert (chosen[0], chosen[-1]) == (0, count - 1)
