import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.footprint import ROBOT_RADIUS, read_footprint, round_footprint
from docking.simulation.robot import RobotSettings


def test_a_round_robot_has_sixteen_points_as_in_nav2() -> None:
    points = round_footprint(0.3)
    assert len(points) == 16
    assert points[0] == (0.3, 0.0)
    assert {round(math.hypot(*point), 9) for point in points} == {0.3}


def test_the_simulated_robot_has_the_default_radius() -> None:
    assert RobotSettings().radius == ROBOT_RADIUS


@pytest.mark.parametrize("text", ["", " ", "[]"])
def test_none_is_given(text: str) -> None:
    assert read_footprint(text) == ()


@pytest.mark.parametrize("text", ["[[0.2, .15], [0.2, -.15], [-0.2, 0]]", " [ [ 0.2,0.15 ],[2e-1,-0.15],\n[-.2,0.]] "])
def test_points_are_written_as_for_nav2(text: str) -> None:
    assert read_footprint(text) == ((0.2, 0.15), (0.2, -0.15), (-0.2, 0.0))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("0.3", "must be a list of points"),
        ("[0.2, 0.15, 0.2]", "must be a list of points"),
        ("[[0.2, 0.15], [0.2]]", "must be a list of points"),
        ("[[0.2, 0.15], [0.2, -0.15], [-0.2, 0.0]", "must be a list of points"),
        ("[[0.2, 0.15], [0.2, 'a'], [-0.2, 0.0]]", "must be a list of points"),
        ("[[0.2, 0.15], [0.2, True], [-0.2, 0.0]]", "must be a list of points"),
        ("[[0.2, 0.15], [0.2, nan], [-0.2, 0.0]]", "must be a list of points"),
        ("[[0.2, 0.15], [0.2, 1e999 - 1e999], [-0.2, 0.0]]", "must be a list of points"),
        ("{'ab': 1}", "must be a list of points"),
        ("__import__('os')", "must be a list of points"),
        ("[" * 5000, "must be a list of points"),
        ("[[0.2, 0.15], [-0.2, 0.15]]", "has 2 points"),
        (str([[1, 1]] * 101), "has 101 points"),
        ("[[200, 150], [200, -150], [-200, 0]]", "has the point [200, 150], but no coordinate may be beyond 10 m"),
        ("[[0.2, 0.15], [1e999, -0.15], [-0.2, 0]]", "beyond 10 m"),
        (f"[[0.2, 0.15], [0.2, {10**400}], [-0.2, 0]]", "beyond 10 m"),
        ("[[0.2, 0.15], [-0.2, -0.15], [0.2, -0.15], [-0.2, 0.15]]", "has edges that cross"),
        ("[[0.2, 0.2], [0.1, 0.1], [-0.2, -0.2]]", "encloses less than 1 cm²"),
        ("[[0.2, 0.2], [0.2, 0.2], [0.2, 0.2]]", "encloses less than 1 cm²"),
    ],
)
def test_what_is_no_footprint_is_refused_with_a_reason(text: str, complaint: str) -> None:
    with pytest.raises(ValueError) as refusal:  # noqa: PT011 - the text is compared below
        read_footprint(text)
    assert complaint in str(refusal.value)


@given(st.text())
def test_any_other_text_is_refused_and_nothing_else_happens(text: str) -> None:
    with contextlib.suppress(ValueError):
        read_footprint(text)


@given(st.floats(0.01, 5.0))
def test_what_is_written_can_be_read(radius: float) -> None:
    points = round_footprint(radius)
    assert read_footprint(str([list(point) for point in points])) == points
