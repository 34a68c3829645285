"""Computes how long the robot can go on until it touches something."""

import math

import numpy as np

from docking.core.footprint import Footprint
from docking.core.observation import STANDSTILL, Velocity
from robot_io.laser import Points

STEP = 0.05
"""Seconds between the moments that are looked at: robots move less than their own size within it."""


class Clearance:
    """Moves the robot's outline along the way of a velocity, and sees when it touches points.

    The outline is made convex. A point inside of it belongs to the robot itself. A point within the margin does not
    keep the robot from moving away: it counts only where the outline itself would touch it.
    """

    def __init__(self, outline: Footprint, margin: float) -> None:
        """Take the measures.

        Args:
            outline: Of the robot, in base_link.
            margin: Clearance around it, in m.
        """
        corners = np.array(_convex(outline))
        edges = np.roll(corners, -1, axis=0) - corners
        self._normals = np.column_stack((edges[:, 1], -edges[:, 0])) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
        self._sides = np.sum(self._normals * corners, axis=1)  # a point is inside where no product exceeds these
        self._margin = margin
        self._reach = float(np.hypot(corners[:, 0], corners[:, 1]).max()) + margin

    def contact(self, points: Points, velocity: Velocity, horizon: float) -> float:
        """Seconds until the robot touches one of the points; infinite where that is beyond the horizon.

        Args:
            points: In base_link.
            velocity: Of the robot, as it goes on.
            horizon: How far to look ahead, in s.
        """
        near = self._reach + math.hypot(velocity.linear_x, velocity.linear_y) * horizon
        points = points[np.abs(points).max(axis=1) <= near] if len(points) else points
        if velocity == STANDSTILL or not len(points):
            return math.inf
        now = self._depth(points)
        points, now = points[now > 0.0], now[now > 0.0]
        limits = np.where(now <= self._margin, 0.0, self._margin)
        for seconds in np.arange(STEP, horizon + 0.5 * STEP, STEP):
            if np.any(self._depth(_seen_from(points, velocity, float(seconds))) <= limits):
                return float(seconds)
        return math.inf

    def outside(self, points: Points) -> Points:
        """The points, in base_link, that do not belong to the robot itself."""
        return points[self._depth(points) > 0.0]

    def _depth(self, points: Points) -> Points:
        """Return how far each point is outside of the outline, in m; below 0 inside."""
        return np.asarray((points @ self._normals.T - self._sides).max(axis=1, initial=-math.inf))


def _seen_from(points: Points, velocity: Velocity, seconds: float) -> Points:
    """Points of now in base_link of later."""
    turn, way, side = velocity.angular_z * seconds, velocity.linear_x * seconds, velocity.linear_y * seconds
    # Where an arc leads: sin(turn) / turn and (1 - cos(turn)) / turn of its length.
    along, across = np.sinc(turn / math.pi), np.sinc(0.5 * turn / math.pi) * math.sin(0.5 * turn)
    x, y = way * along - side * across, way * across + side * along
    cos, sin = math.cos(turn), math.sin(turn)
    return np.asarray((points - (x, y)) @ np.array(((cos, -sin), (sin, cos))))


def _convex(points: Footprint) -> Footprint:
    """The convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))

    def chain(line: list[tuple[float, float]]) -> list[tuple[float, float]]:
        hull: list[tuple[float, float]] = []
        for point in line:
            while len(hull) > 1 and _turns_right(hull[-2], hull[-1], point):
                hull.pop()
            hull.append(point)
        return hull[:-1]

    return tuple(chain(ordered) + chain(ordered[::-1]))


def _turns_right(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 0.0
