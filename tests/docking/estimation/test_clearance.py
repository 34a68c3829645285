"""Contact times against geometry: straight ways, turns on the spot, arcs; margins; any convex outline."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from docking.core.footprint import round_footprint
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.core.transform import place, spatial
from docking.estimation.clearance import STEP, Clearance
from robot_io.laser import NOWHERE, flatten, points_of
from robot_io.transform import Transform, turn

SQUARE = ((0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1), (0.2, -0.1))
TRIANGLE = ((0.3, 0.0), (-0.1, 0.2), (-0.1, -0.2))
SHARPEST = 2.24  # how many margins are free in front of the triangle's sharpest corner: 1 / sin(53° / 2)
MARGIN = 0.05
HORIZON = 2.0


def contact(x: float, y: float, velocity: Velocity, outline: tuple[tuple[float, float], ...] = SQUARE) -> float:
    return Clearance(outline, MARGIN).contact(np.array(((x, y),)), velocity, HORIZON)


@pytest.mark.parametrize(
    ("x", "y", "velocity", "expected"),
    [
        (0.45, 0.0, Velocity(0.2), 1.0),
        (0.45, 0.14, Velocity(0.2), 1.0),
        (0.45, 0.16, Velocity(0.2), math.inf),
        (0.45, 0.0, Velocity(0.05), math.inf),
        (0.45, 0.0, Velocity(-0.2), math.inf),
        (-0.35, -0.1, Velocity(-0.2), 0.5),
        (0.45, 0.0, STANDSTILL, math.inf),
        # A corner with its margin, 0.29 m from the centre, comes by.
        (0.0, 0.26, Velocity(0.0, 1.0), math.pi / 2 - math.asin(0.15 / 0.26) - math.acos(0.25 / 0.26) + 0.29),
        (0.0, 0.30, Velocity(0.0, 1.0), math.inf),
    ],
)
def test_the_time_to_the_contact(x: float, y: float, velocity: Velocity, expected: float) -> None:
    found = contact(x, y, velocity)
    if expected == math.inf or velocity.angular_z:
        assert (found == math.inf) == (expected == math.inf)
    else:
        assert found == pytest.approx(expected, abs=STEP + 1e-6)


def test_an_arc_leads_around_what_is_straight_ahead_and_into_what_is_not() -> None:
    """A circle of 0.3 m radius around (0, 0.3): after a quarter the robot is at its rightmost point, looking left."""
    outline, arc = round_footprint(0.05), Velocity(0.3 * math.pi / 4.0, math.pi / 4.0)
    assert contact(0.7, 0.0, arc, outline) == math.inf
    assert contact(0.3, 0.6, arc, outline) == math.inf
    assert contact(0.3, 0.35, arc, outline) == pytest.approx(1.78, abs=0.1)


def test_the_robot_itself_is_no_obstacle() -> None:
    assert contact(0.19, 0.0, Velocity(0.2)) == math.inf


def test_what_is_within_the_margin_may_be_left_but_not_touched() -> None:
    assert contact(0.22, 0.0, Velocity(-0.2)) == math.inf
    assert contact(0.0, 0.12, Velocity(0.2)) == math.inf
    assert contact(0.22, 0.0, Velocity(0.2)) == pytest.approx(0.1, abs=STEP + 1e-6)


def test_without_points_the_way_is_clear() -> None:
    assert Clearance(SQUARE, MARGIN).contact(NOWHERE, Velocity(1.0), HORIZON) == math.inf


def distance(point: Pose, outline: tuple[tuple[float, float], ...]) -> float:
    """From a point to a convex outline; 0 inside."""
    edges = list(zip(outline, outline[1:] + outline[:1], strict=True))
    turns = [(bx - ax) * (point.y - ay) - (by - ay) * (point.x - ax) for (ax, ay), (bx, by) in edges]
    if all(turn > 0.0 for turn in turns) or all(turn < 0.0 for turn in turns):
        return 0.0
    distances = []
    for (ax, ay), (bx, by) in edges:
        length = math.hypot(bx - ax, by - ay)
        along = ((point.x - ax) * (bx - ax) + (point.y - ay) * (by - ay)) / length
        nearest = min(1.0, max(0.0, along / length))
        distances.append(math.hypot(ax + nearest * (bx - ax) - point.x, ay + nearest * (by - ay) - point.y))
    return min(distances)


@given(
    st.builds(Pose, st.floats(-0.8, 0.8), st.floats(-0.8, 0.8)),
    st.floats(-0.3, 0.3),
    st.floats(-1.0, 1.0),
    st.sampled_from([SQUARE, SQUARE[::-1], round_footprint(0.15), TRIANGLE]),
)
@example(Pose(0.71875, 0.0), 0.25, 0.0, TRIANGLE)
@example(Pose(0.40625, 0.0), 0.25, 0.0, TRIANGLE)
def test_the_robot_touches_nothing_before_the_contact_and_something_then(
    point: Pose, linear: float, angular: float, outline: tuple[tuple[float, float], ...]
) -> None:
    margins = SHARPEST if outline is TRIANGLE else 1.5  # no farther away, a point may be within the margin
    assume(distance(point, outline) > margins * MARGIN)
    found = contact(point.x, point.y, Velocity(linear, angular), outline)
    blur = STEP * (abs(linear) + abs(angular))  # what the robot moves between two looks
    pose, now = Pose(), 0.0
    while now < min(found - STEP, HORIZON) - 1e-6:
        pose, now = pose.compose(Pose(0.005 * linear, 0.0, 0.005 * angular)), now + 0.005
        assert distance(point.relative_to(pose), outline) > MARGIN - blur - 0.002
    if found < math.inf:
        assert distance(point.relative_to(pose), outline) < margins * MARGIN + blur + 0.002


def test_points_of_a_scan() -> None:
    limits = {"angle_min": -math.pi / 2, "angle_increment": math.pi / 2, "range_min": 0.1, "range_max": 5.0}
    points = points_of([1.0, 2.0, 3.0], **limits)
    assert points == pytest.approx(np.array(((0.0, -1.0), (2.0, 0.0), (0.0, 3.0))))
    assert len(points_of([math.nan, math.inf, 0.05], **limits)) == 0
    moved = place(points, Pose(1.0, 0.0, math.pi / 2))
    assert moved == pytest.approx(np.array(((2.0, 0.0), (1.0, 2.0), (-2.0, 0.0))))


def test_points_of_a_scanner_that_hangs_upside_down() -> None:
    over = Transform((0.1, 0.2, 0.3), turn((1.0, 0.0, 0.0), math.pi))
    assert flatten(np.array(((1.0, 2.0),)), over) == pytest.approx(np.array(((1.1, -1.8),)))
    upright = Pose(0.3, -0.2, 1.0)
    points = np.array(((1.0, 2.0), (-1.0, 0.5)))
    assert flatten(points, spatial(upright)) == pytest.approx(place(points, upright))


@pytest.mark.parametrize(
    "change", [{"angle_min": math.nan}, {"angle_increment": math.inf}, {"range_min": -1.0}, {"range_max": 0.1}]
)
def test_a_scan_that_makes_no_sense(change: dict[str, float]) -> None:
    limits = {"angle_min": 0.0, "angle_increment": 0.1, "range_min": 0.1, "range_max": 5.0, **change}
    with pytest.raises(ValueError, match="not valid"):
        points_of([1.0], **limits)
