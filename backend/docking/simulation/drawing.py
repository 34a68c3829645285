"""Draws the picture of the simulated camera: floor, room, dock and marker in perspective."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from docking.core.geometry import Pose
from docking.simulation.box import Box
from docking.simulation.dock import Dock
from docking.simulation.marker import CAMERA_X
from docking.simulation.obstacle import Obstacle
from docking.simulation.room import Room

Picture = npt.NDArray[np.uint8]
Numbers = npt.NDArray[np.floating[Any]]
Color = tuple[int, int, int]

WIDTH, HEIGHT = 640, 480
EYE = 0.25
"""Height of the camera and of the marker's centre above the floor, in m."""
WALLS, FURNITURE, PILLAR, ROBOT, DOCK, BOARD = 2.4, 0.9, 0.7, 0.2, 0.12, 0.37
"""Heights, in m."""
TILE = 0.5
"""Size of a tile of the floor, in m."""
FADE = 0.06
"""How much darker what is a metre further away is."""
MARKER = 0.16
"""Size of the marker with its black border, in m."""
CELLS = np.pad(np.array([[1, 0, 1, 1], [0, 1, 0, 1], [0, 0, 1, 1], [0, 0, 1, 0]], np.uint8), 1)
"""The marker: 1 is white."""
SKY, TILES, WALL = (196, 206, 214), (158, 177), (214, 208, 196)
WOODS: Sequence[Color] = ((142, 108, 74), (94, 112, 128), (120, 124, 112), (150, 120, 96))
STEEL, WHITE, CARDBOARD, ORANGE = (52, 58, 66), (238, 238, 236), (150, 118, 80), (214, 120, 40)
BLUE = (64, 104, 168)


@dataclass(frozen=True)
class Scene:
    """The things that the camera sees.

    Attributes:
        dock: The dock.
        room: The room; None on an endless floor.
        obstacles: Pillars, and robots where they are low.
        covered: Whether something hides the marker.
    """

    dock: Dock
    room: Room | None = None
    obstacles: Sequence[Obstacle] = ()
    covered: bool = False


class Drawing:
    """One picture. What is nearer hides what is behind it.

    Args:
        robot: base_link in world.
        camera_yaw: The direction in which the camera looks, from the robot's front, in rad.
        field_of_view: From the left edge to the right one, in rad.

    Attributes:
        pixels: Rows of RGB.
    """

    def __init__(self, robot: Pose, camera_yaw: float, field_of_view: float) -> None:
        eye = robot.compose(Pose(theta=camera_yaw)).compose(Pose(x=CAMERA_X))
        self._x, self._y = eye.x, eye.y
        self._focal = focal_length(field_of_view)
        right = (np.arange(WIDTH, dtype=np.float32) + 0.5 - WIDTH / 2) / self._focal
        # Of each column, the way over the floor for each metre ahead.
        self._dx = np.float32(math.cos(eye.theta)) + right * np.float32(math.sin(eye.theta))
        self._dy = np.float32(math.sin(eye.theta)) - right * np.float32(math.cos(eye.theta))
        self._down = ((np.arange(HEIGHT, dtype=np.float32) + 0.5 - HEIGHT / 2) / self._focal)[:, None]
        self._depth = np.full((HEIGHT, WIDTH), np.inf, np.float32)
        self.pixels: Picture = np.full((HEIGHT, WIDTH, 3), SKY, np.uint8)

    def floor(self) -> None:
        """Draw an endless floor of tiles."""
        rows, depth, x, y = self._level(0.0)
        odd = (np.floor(x / TILE).astype(np.int32) + np.floor(y / TILE).astype(np.int32)) & 1
        light = _faded(depth)
        shades = ((light * tile).astype(np.uint8) for tile in TILES)
        self.pixels[rows] = np.where(odd, *shades)[:, :, None]

    def walls(self, floor: Box) -> None:
        """Draw the walls around a floor."""
        _, leaves, across = self._cross(floor)
        self._stand(leaves, WALLS, WALL, np.where(across, 1.0, 0.88))
        self._stand(leaves - 0.001, 0.08, STEEL, np.ones(WIDTH))

    def box(self, box: Box, height: float, color: Color) -> None:
        """Draw a box that stands on the floor."""
        enters, leaves, across = self._cross(box)
        seen = (enters <= leaves) & (enters > 0.0)
        self._stand(np.where(seen, enters, np.inf), height, color, np.where(across, 1.0, 0.82))
        if height < EYE:
            rows, depth, x, y = self._level(height)
            top = (x >= box.x_min) & (x <= box.x_max) & (y >= box.y_min) & (y <= box.y_max)
            self._paint(rows.start, 0, top & (depth < self._depth[rows]), depth, np.array(color) * 1.15)

    def pillar(self, circle: Obstacle, height: float, color: Color) -> None:
        """Draw something round that stands on the floor."""
        x, y = circle.x - self._x, circle.y - self._y
        length = self._dx**2 + self._dy**2
        within = circle.radius**2 * length - (x * self._dy - y * self._dx) ** 2
        root = np.sqrt(np.maximum(within, 0.0))
        depth = (x * self._dx + y * self._dy - root) / length
        round_ = 0.55 + 0.45 * root / (circle.radius * np.sqrt(length))
        self._stand(np.where((within > 0.0) & (depth > 0.0), depth, np.inf), height, color, round_)
        if height < EYE:
            rows, level, over_x, over_y = self._level(height)
            top = (over_x - circle.x) ** 2 + (over_y - circle.y) ** 2 <= circle.radius**2
            self._paint(rows.start, 0, top & (level < self._depth[rows]), level, np.array(color) * 1.15)

    def marker(self, y: float) -> None:
        """Draw the marker on its board, which looks along -x.

        Args:
            y: Of its centre, in world.
        """
        with np.errstate(divide="ignore"):
            depth = -self._x / self._dx
        left = (y + MARKER / 2 - self._y - depth * self._dy) / MARKER
        (columns,) = np.nonzero((depth > 0.0) & (left >= 0.0) & (left < 1.0))
        if self._x >= 0.0 or not len(columns):
            return
        first, last = int(columns[0]), int(columns[-1]) + 1
        depth, left = depth[first:last], left[first:last]
        below = (depth * self._down + MARKER / 2) / MARKER
        seen = (below >= 0.0) & (below < 1.0) & (depth <= self._depth[:, first:last] + 0.001)
        count = len(CELLS)
        rows = np.clip(below * count, 0, count - 1).astype(np.intp)
        bits = CELLS[rows, np.clip(left * count, 0, count - 1).astype(np.intp)[None, :]]
        self.pixels[:, first:last][seen] = np.where(bits[seen], 238, 18)[:, None]

    def _cross(self, box: Box) -> tuple[Numbers, Numbers, npt.NDArray[np.bool_]]:
        """Return where each column enters and leaves a box, and whether it meets a side across x where it matters."""
        with np.errstate(divide="ignore"):
            by_x = np.sort(np.array((box.x_min - self._x, box.x_max - self._x), np.float32)[:, None] / self._dx, axis=0)
            by_y = np.sort(np.array((box.y_min - self._y, box.y_max - self._y), np.float32)[:, None] / self._dy, axis=0)
        inside = box.x_min < self._x < box.x_max and box.y_min < self._y < box.y_max
        across = by_x[1] < by_y[1] if inside else by_x[0] > by_y[0]
        return np.maximum(by_x[0], by_y[0]), np.minimum(by_x[1], by_y[1]), across

    def _level(self, height: float) -> tuple[slice, Numbers, Numbers, Numbers]:
        """Return the rows in which a level below the camera is seen; their depth, and x and y in world."""
        rows = slice(HEIGHT // 2, HEIGHT)
        depth = np.float32(EYE - height) / self._down[rows]
        return rows, depth, self._x + depth * self._dx, self._y + depth * self._dy

    def _stand(self, depth: Numbers, height: float, color: Color, light: npt.NDArray[np.float64]) -> None:
        """Draw what stands on the floor, at a depth in each column."""
        (columns,) = np.nonzero(np.isfinite(depth))
        if not len(columns):
            return
        first, last = int(columns[0]), int(columns[-1]) + 1
        depth = np.maximum(depth[first:last], np.float32(0.02))
        bottom, top = np.float32(EYE) / depth, np.float32(EYE - height) / depth
        start, end = (
            int(np.clip(self._focal * edge + HEIGHT / 2, 0, HEIGHT)) for edge in (top.min(), bottom.max() + 1)
        )
        down = self._down[start:end]
        seen = (down >= top) & (down < bottom) & (depth < self._depth[start:end, first:last])
        self._paint(start, first, seen, depth, np.multiply.outer(light[first:last] * _faded(depth), color))

    def _paint(
        self, row: int, column: int, seen: npt.NDArray[np.bool_], depth: Numbers, color: npt.NDArray[np.float64]
    ) -> None:
        place = (slice(row, row + seen.shape[0]), slice(column, column + seen.shape[1]))
        np.copyto(self._depth[place], depth, where=seen)
        np.copyto(self.pixels[place], color.astype(np.uint8), where=seen[:, :, None])


def _faded(depth: Numbers) -> Numbers:
    """Return how light things are at a depth."""
    faded: Numbers = 1.0 / (1.0 + FADE * np.minimum(depth, np.float32(12.0)))
    return faded


def focal_length(field_of_view: float) -> float:
    """Return the focal length in pixels."""
    return 0.5 * WIDTH / math.tan(0.5 * min(field_of_view, math.radians(150.0)))


def draw(scene: Scene, robot: Pose, camera_yaw: float, field_of_view: float, second_y: float = 0.0) -> Picture:
    """Return what the camera sees, as rows of RGB.

    Args:
        scene: What there is to see.
        robot: base_link in world.
        camera_yaw: The direction in which the camera looks, from the robot's front, in rad.
        field_of_view: From the left edge to the right one, in rad.
        second_y: Where a second marker is; 0: there is none.
    """
    drawing = Drawing(robot, camera_yaw, field_of_view)
    drawing.floor()
    if scene.room is not None:
        drawing.walls(scene.room.floor)
        for number, box in enumerate(scene.room.furniture):
            drawing.box(box, FURNITURE, WOODS[number % len(WOODS)])
    for obstacle in scene.obstacles:
        height, color = (ROBOT, BLUE) if obstacle.low else (PILLAR, ORANGE)
        drawing.pillar(obstacle, height, color)
    for box in scene.dock.boxes:
        drawing.box(box, DOCK, STEEL)
    for y in {*scene.dock.places, second_y or 0.0}:
        drawing.box(Box(0.0, y - 0.6 * MARKER, 0.02, y + 0.6 * MARKER), BOARD, CARDBOARD if scene.covered else WHITE)
        if not scene.covered:
            drawing.marker(y)
    return drawing.pixels
