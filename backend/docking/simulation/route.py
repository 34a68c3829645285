"""Finds ways for the simulated robot on the map of its room."""

import math
from collections.abc import Iterator, Sequence
from heapq import heappop, heappush

import numpy as np

from docking.core.geometry import Pose
from docking.simulation.obstacle import Obstacle
from docking.simulation.occupancy import CELL, Cells, Occupancy

MARGIN = 0.05
"""Clearance that a way keeps around the robot, in m."""
SNAP = 0.5
"""How far a robot without that clearance drives straight on or back until it has it, in m, as from its dock."""
STEP = 0.5 * CELL
"""Between two places that are looked at, in m."""
DIAGONAL = math.sqrt(2.0)

Point = tuple[float, float]


class NoWayError(Exception):
    """The robot cannot get there; the text says why, as a sentence."""


class Routes:
    """The ways on a map, found by A* on its cells."""

    def __init__(self, grid: Occupancy, radius: float, bodies: Sequence[Obstacle] = ()) -> None:
        """Find the cells on which the robot may stand.

        Args:
            grid: The map; all its outermost cells are occupied.
            radius: Of the robot, in m.
            bodies: What else stands there, such as other robots.
        """
        self._grid = grid
        self._radius = radius
        self._blocked = _grow(grid.occupied, (radius + MARGIN) / CELL + 0.5)
        for body in bodies:
            self._blocked |= grid.within(body.x, body.y, body.radius + radius + MARGIN + CELL)
        self._width: int = grid.occupied.shape[1]
        self._flat: list[bool] = self._blocked.ravel().tolist()

    def around(self, bodies: Sequence[Obstacle]) -> "Routes":
        """Return the ways on the same map that keep clear of bodies, too.

        Args:
            bodies: Such as other robots.
        """
        return Routes(self._grid, self._radius, bodies)

    def is_free(self, place: Point) -> bool:
        """Whether the robot may stand at a place, in world, with the clearance of a way."""
        row, column = self._grid.cell(*place)
        rows, columns = self._blocked.shape
        return 0 <= row < rows and 0 <= column < columns and not self._blocked[row, column]

    def find(self, start: Pose, goal: Point) -> list[Point]:
        """The corners of a short way, from the start, which is the first, to the goal, which is the last.

        Args:
            start: Where the robot is, in world; its heading matters where it has no room to turn.
            goal: Where it is to be.

        Raises:
            NoWayError: There is none.
        """
        if not self.is_free(goal):
            raise NoWayError(f"there is no room for the robot at ({goal[0]:.2f}, {goal[1]:.2f})")
        here = start.x, start.y
        begin = here if self.is_free(here) else self._nearest(start)
        if begin is None:
            raise NoWayError(f"the robot has no room to turn at ({start.x:.2f}, {start.y:.2f})")
        cells = self._search(self._index(begin), self._index(goal))
        if cells is None:
            raise NoWayError(f"no way leads to ({goal[0]:.2f}, {goal[1]:.2f})")
        points = [begin, *(self._grid.centre(*divmod(cell, self._width)) for cell in cells[1:-1]), goal]
        corners = self._straighten(points)
        return corners if begin == here else [here, *corners]

    def _index(self, place: Point) -> int:
        row, column = self._grid.cell(*place)
        return row * self._width + column

    def _nearest(self, robot: Pose) -> Point | None:
        """The nearest place with room to turn, straight ahead or behind."""
        steps = math.ceil(SNAP / STEP)
        ways = (sign * STEP * step for step in range(1, steps + 1) for sign in (-1, 1))
        places = (robot.compose(Pose(way)) for way in ways)
        return next(((place.x, place.y) for place in places if self.is_free((place.x, place.y))), None)

    def _search(self, start: int, goal: int) -> list[int] | None:
        width, blocked = self._width, self._flat
        goal_row, goal_column = divmod(goal, width)
        sides = [(step, 1.0) for step in (-1, 1, -width, width)]
        corners = [(up + right, DIAGONAL, up, right) for up in (-width, width) for right in (-1, 1)]

        def remaining(cell: int) -> float:
            rows, columns = abs(cell // width - goal_row), abs(cell % width - goal_column)
            return float(max(rows, columns)) + (DIAGONAL - 1.0) * min(rows, columns)

        costs, before = {start: 0.0}, {start: start}
        queue, closed = [(remaining(start), start)], set[int]()
        while queue:
            cell = heappop(queue)[1]
            if cell == goal:
                return list(_trace(before, goal))[::-1]
            if cell in closed:
                continue
            closed.add(cell)
            steps = [(cell + step, length) for step, length in sides]
            steps += [
                (cell + step, length)
                for step, length, up, right in corners
                if not (blocked[cell + up] or blocked[cell + right])
            ]
            for other, length in steps:
                cost = costs[cell] + length
                if not blocked[other] and cost < costs.get(other, math.inf):
                    costs[other], before[other] = cost, cell
                    heappush(queue, (cost + remaining(other), other))
        return None

    def _straighten(self, points: list[Point]) -> list[Point]:
        """Leaves points out between which the robot can drive straight on."""
        corners = [points[0]]
        for point, following in zip(points[1:], [*points[2:], None], strict=True):
            if following is None or not self._sees(corners[-1], following):
                corners.append(point)
        return corners

    def _sees(self, one: Point, other: Point) -> bool:
        count = math.ceil(math.dist(one, other) / STEP) + 1
        x, y = np.linspace(one[0], other[0], count), np.linspace(one[1], other[1], count)
        columns = np.floor((x - self._grid.x) / CELL).astype(int)
        rows = np.floor((y - self._grid.y) / CELL).astype(int)
        return not self._blocked[rows, columns].any()


def _trace(before: dict[int, int], cell: int) -> Iterator[int]:
    yield cell
    while before[cell] != cell:
        cell = before[cell]
        yield cell


def _grow(cells: Cells, by: float) -> Cells:
    """Also those whose middle is at most so many cells away from the middle of one."""
    reach = math.floor(by)
    wide = np.pad(cells, reach)
    rows, columns = cells.shape
    grown = np.zeros_like(cells)
    for up in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            if math.hypot(up, right) <= by:
                grown |= wide[reach + up : reach + up + rows, reach + right : reach + right + columns]
    return grown
