"""What a laser sees and where a robot is to drive, reduced to what can be seen on a map."""

import math

import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import LaserScan

from dock_gateway.maps.scan import MAX_POINTS, path_points, scan_points
from robot_io.transform import Transform, turn

UPSIDE_DOWN = Transform((1.0, 2.0, 0.3), turn((1.0, 0.0, 0.0), math.pi))


def test_a_scan_is_thinned_and_what_is_out_of_range_left_out() -> None:
    scan = LaserScan(angle_min=0.0, angle_increment=0.001, range_min=0.1, range_max=5.0)
    scan.ranges = [1.0] * 1000 + [math.inf, math.nan, 9.0] * 100
    points = scan_points(scan, Transform())
    assert 150 < len(points) <= MAX_POINTS
    assert all(math.hypot(x, y) == pytest.approx(1.0, abs=0.002) for x, y in points)
    assert points[0] == [1.0, 0.0]


def test_a_scanner_may_hang_upside_down() -> None:
    scan = LaserScan(angle_min=0.5, angle_increment=0.1, range_min=0.1, range_max=5.0)
    scan.ranges = [2.0]
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


def test_a_path_keeps_its_ends() -> None:
    path = Path(poses=[PoseStamped() for _ in range(1000)])
    for index, pose in enumerate(path.poses):
        pose.pose.position.x = float(index)
    points = path_points(path, Transform())
    assert (len(points), points[0], points[-1]) == (MAX_POINTS, [0.0, 0.0], [999.0, 0.0])
    assert path_points(Path(), Transform()) == []
    path.poses[0].pose.position.y = math.inf
    with pytest.raises(ValueError, match="not finite"):
        path_points(path, Transform())
