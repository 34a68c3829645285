"""A robot's footprint, its outline from above in the robot's own frame, as clients get it."""

import math
from collections.abc import Sequence
from typing import Any

MIN_POINTS, MAX_POINTS = 3, 100
# Metres from base_link to the farthest point.
MIN_RADIUS, MAX_RADIUS = 0.001, 10.0
# A round robot is published as a regular polygon with this number of points, in single precision.
ROUND_POINTS, ROUND_TOLERANCE = 16, 0.0005


def footprint_document(points: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """Return a footprint for JSON, rounded to 0.1 mm. One of a round robot is only its radius: it is in many events.

    Raises:
        ValueError: It is not a footprint.
    """
    if not MIN_POINTS <= len(points) <= MAX_POINTS:
        raise ValueError(f"it has {len(points)} points, not {MIN_POINTS} to {MAX_POINTS}")
    if not all(math.isfinite(value) for point in points for value in point):
        raise ValueError("it has a coordinate that is not finite")
    radius = max(math.hypot(*point) for point in points)
    if not MIN_RADIUS <= radius <= MAX_RADIUS:
        raise ValueError(f"it reaches {radius:g} m from base_link, not {MIN_RADIUS:g} to {MAX_RADIUS:g} m")
    corners = [{"x": round(x, 4), "y": round(y, 4)} for x, y in points]
    return {"radius": round(radius, 4), "points": None if _is_round(points, radius) else corners}


def _is_round(points: Sequence[tuple[float, float]], radius: float) -> bool:
    """Return whether the points are those that nav2 gives a round robot: regular, and the first straight ahead."""
    angles = [math.tau * corner / ROUND_POINTS for corner in range(ROUND_POINTS)]
    regular = [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]
    return len(points) == ROUND_POINTS and all(map(_is_near, points, regular))


def _is_near(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return math.dist(one, other) <= ROUND_TOLERANCE
