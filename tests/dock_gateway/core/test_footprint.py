import math

import pytest

from dock_gateway.core.footprint import footprint_document

CORNERS = [(0.3, 0.2), (0.3, -0.2), (-0.3, -0.2), (-0.3, 0.2)]


def regular(radius: float, count: int) -> list[tuple[float, float]]:
    angles = [math.tau * corner / count for corner in range(count)]
    return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]


def test_a_footprint_has_its_points_and_the_radius_of_the_circle_around_it() -> None:
    assert footprint_document([(0.4, 0.3), (0.0, -0.12345678), (-0.2, 0.1)]) == {
        "radius": 0.5,
        "points": [{"x": 0.4, "y": 0.3}, {"x": 0.0, "y": -0.1235}, {"x": -0.2, "y": 0.1}],
    }


def test_a_round_one_is_only_a_radius() -> None:
    single_precision = [(x + 1e-8, y - 1e-8) for x, y in regular(0.15, 16)]
    assert footprint_document(single_precision) == {"radius": 0.15, "points": None}


@pytest.mark.parametrize("points", [regular(0.15, 4), regular(0.15, 8), [(0.15, 0.0)] * 3 + regular(0.15, 16)[3:]])
def test_others_with_all_points_on_a_circle_are_not_round(points: list[tuple[float, float]]) -> None:
    assert footprint_document(points)["points"] is not None


@pytest.mark.parametrize(
    ("points", "complaint"),
    [
        ([], "0 points"),
        (CORNERS[:2], "2 points"),
        (regular(0.15, 101), "101 points"),
        ([*CORNERS, (math.nan, 0.0)], "not finite"),
        ([*CORNERS, (0.0, -math.inf)], "not finite"),
        ([*CORNERS, (0.0, 10.1)], "10.1 m"),
        ([(0.0, 0.0)] * 3, "0 m"),
    ],
)
def test_what_is_no_footprint_is_refused_with_a_reason(points: list[tuple[float, float]], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        footprint_document(points)
