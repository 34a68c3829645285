"""The robot's outline from above, in base_link, as nav2's costmaps take it."""

import ast
import math
from itertools import combinations

Footprint = tuple[tuple[float, float], ...]
Edge = tuple[tuple[float, float], tuple[float, float]]

ROBOT_RADIUS = 0.15
"""Of a robot that nothing else is said about, in m; the simulated one has it."""
ROUND_POINTS = 16
MAX_POINTS = 100
MAX_DISTANCE = 10.0
"""From base_link to a point, for each coordinate, in m."""
MIN_AREA = 1e-4
"""In m²."""


def round_footprint(radius: float = ROBOT_RADIUS) -> Footprint:
    """The footprint of a round robot: a regular polygon, as nav2 makes it."""
    angles = [math.tau * corner / ROUND_POINTS for corner in range(ROUND_POINTS)]
    return tuple((radius * math.cos(angle), radius * math.sin(angle)) for angle in angles)


def read_footprint(text: str) -> Footprint:
    """The points in a text such as `[[0.2, 0.15], [0.2, -0.15], [-0.2, 0.0]]`; none if it is empty or `[]`.

    Raises:
        ValueError: It is no footprint; the caller adds the subject to the message.
    """
    if not text.strip():
        return ()
    try:
        points = tuple((x, y) for x, y in ast.literal_eval(text.strip()))
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        points = (("", ""),)
    if not all(type(value) in (int, float) for point in points for value in point):
        raise ValueError("must be a list of points in m, such as [[0.2, 0.15], [0.2, -0.15], [-0.2, 0.0]]")
    if points and not 3 <= len(points) <= MAX_POINTS:
        raise ValueError(f"has {len(points)} points, but must have 3 to {MAX_POINTS}")
    for point in points:
        if max(map(abs, point)) > MAX_DISTANCE:
            raise ValueError(f"has the point {list(point)}, but no coordinate may be beyond {MAX_DISTANCE:g} m")
    if points:
        _check_shape(points)
    return tuple((float(x), float(y)) for x, y in points)


def _check_shape(points: Footprint) -> None:
    edges = list(zip(points, points[1:] + points[:1], strict=True))
    if any(_cross(one, other) for one, other in combinations(edges, 2)):
        raise ValueError("has edges that cross: list its points in their order around the robot")
    if abs(sum(ax * by - ay * bx for (ax, ay), (bx, by) in edges)) < 2.0 * MIN_AREA:
        raise ValueError(f"encloses less than {MIN_AREA * 1e4:g} cm²")


def _cross(one: Edge, other: Edge) -> bool:
    """Whether two edges cross between their ends."""
    return all(
        _side(start, end, first) * _side(start, end, second) < 0.0
        for (start, end), (first, second) in ((one, other), (other, one))
    )


def _side(start: tuple[float, float], end: tuple[float, float], point: tuple[float, float]) -> float:
    """Above 0 if a point is to the left of the way from start to end, below 0 if it is to the right."""
    return (end[0] - start[0]) * (point[1] - start[1]) - (end[1] - start[1]) * (point[0] - start[0])
