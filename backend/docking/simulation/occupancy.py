"""The map of the room: which cells of a grid are occupied."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from docking.simulation.box import Box
from docking.simulation.dock import Dock
from docking.simulation.room import Room

Cells = npt.NDArray[np.bool_]

CELL = 0.05
"""Size of a cell, in m."""
MARGIN = 0.02
"""How far into a cell something must reach to count, as a fraction of the cell: less is a rounding error."""


@dataclass(frozen=True, slots=True, eq=False)
class Occupancy:
    """The cells of a room, with its walls.

    Attributes:
        x: Of the lower left corner of cell (0, 0), in world, in m.
        y: The same.
        occupied: By row and column: rows along y, columns along x.
    """

    x: float
    y: float
    occupied: Cells

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """The middle of a cell, in world, in m."""
        return self.x + (column + 0.5) * CELL, self.y + (row + 0.5) * CELL

    def within(self, x: float, y: float, distance: float) -> Cells:
        """Return which cells have their middle within a distance of a point in world, in m."""
        rows, columns = self.occupied.shape
        across, up = self.x + (np.arange(columns) + 0.5) * CELL, self.y + (np.arange(rows) + 0.5) * CELL
        return np.asarray((across - x) ** 2 + (up[:, None] - y) ** 2 <= distance**2)

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Row and column of the cell of a point in world; it may be outside of the grid."""
        return math.floor((y - self.y) / CELL), math.floor((x - self.x) / CELL)


def map_of(room: Room, dock: Dock) -> Occupancy:
    """The map of a room with its furniture and the dock, but without obstacles."""
    floor, wall = room.floor, room.thickness
    left, bottom = _below((floor.x_min - wall) / CELL), _below((floor.y_min - wall) / CELL)
    right, top = _above((floor.x_max + wall) / CELL), _above((floor.y_max + wall) / CELL)
    occupied = np.ones((top - bottom, right - left), dtype=bool)
    # A cell that a wall reaches into is the wall's.
    inside = (
        _above(floor.x_min / CELL),
        _above(floor.y_min / CELL),
        _below(floor.x_max / CELL),
        _below(floor.y_max / CELL),
    )
    occupied[inside[1] - bottom : inside[3] - bottom, inside[0] - left : inside[2] - left] = False
    _fill(occupied, (*room.furniture, *dock.boxes), left, bottom)
    return Occupancy(left * CELL, bottom * CELL, occupied)


def _fill(occupied: Cells, boxes: Iterable[Box], left: int, bottom: int) -> None:
    for box in boxes:
        rows = slice(max(0, _below(box.y_min / CELL) - bottom), max(0, _above(box.y_max / CELL) - bottom))
        columns = slice(max(0, _below(box.x_min / CELL) - left), max(0, _above(box.x_max / CELL) - left))
        occupied[rows, columns] = True


def _below(cells: float) -> int:
    return math.floor(cells + MARGIN)


def _above(cells: float) -> int:
    return math.ceil(cells - MARGIN)
