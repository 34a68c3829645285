"""What the simulated camera sees is where it would be in truth."""

import math
from typing import Any

import numpy as np
import pytest

from docking.core.geometry import Pose
from docking.simulation.box import Box
from docking.simulation.dock import Dock, DockSettings
from docking.simulation.drawing import CELLS, EYE, HEIGHT, MARKER, ORANGE, WIDTH, Picture, Scene, draw, focal_length
from docking.simulation.marker import CAMERA_X
from docking.simulation.obstacle import Obstacle
from docking.simulation.room import WORKSHOP, Room

VIEW = math.radians(70.0)
DOCK = Dock(DockSettings())


def picture(robot: Pose, yaw: float = 0.0, room: Room | None = WORKSHOP, **more: Any) -> Picture:
    return draw(Scene(DOCK, room, **more), robot, yaw, VIEW)


def place(robot: Pose, x: float, y: float, z: float) -> tuple[int, int]:
    """The row and column of a point in world, by the pinhole model."""
    eye = robot.compose(Pose(x=CAMERA_X)).inverse().compose(Pose(x, y))
    focal = focal_length(VIEW)
    return round(HEIGHT / 2 + focal * (EYE - z) / eye.x - 0.5), round(WIDTH / 2 - focal * eye.y / eye.x - 0.5)


@pytest.mark.parametrize("robot", [Pose(-1.0), Pose(-0.8, 0.3, -0.4), Pose(-1.2, -0.4, 0.2)])
def test_each_cell_of_the_marker_is_where_it_would_be(robot: Pose) -> None:
    pixels, cell = picture(robot), MARKER / len(CELLS)
    for (row, column), white in np.ndenumerate(CELLS):
        middle = [MARKER / 2 - cell * (index + 0.5) for index in (column, row)]
        assert (pixels[place(robot, 0.0, middle[0], EYE + middle[1])].min() > 128) == bool(white)


def test_a_pillar_hides_the_marker_and_so_does_a_cover() -> None:
    robot = Pose(-1.0)
    hidden = picture(robot, obstacles=(Obstacle(-0.5, 0.0, 0.1),))
    red, _, blue = hidden[place(robot, 0.0, 0.0, EYE)].astype(float)
    assert red / blue == pytest.approx(ORANGE[0] / ORANGE[2], rel=0.1)
    assert (hidden != picture(robot)).any()
    assert picture(robot, covered=True)[place(robot, 0.0, 0.0, EYE)].min() > 40


def test_from_behind_there_is_no_marker_but_a_board() -> None:
    assert picture(Pose(1.0, 0.0, math.pi), room=None)[HEIGHT // 2, WIDTH // 2].min() > 128


def test_a_camera_that_looks_back_sees_what_the_turned_robot_sees_from_there() -> None:
    turned = picture(Pose(-1.0), math.pi)
    assert (turned == picture(Pose(-1.0, 0.0, math.pi))).all()
    assert (turned != picture(Pose(-1.0))).any()


def test_the_floor_ends_where_the_wall_begins() -> None:
    room, robot = Room(Box(-4.0, -2.0, 0.5, 2.0)), Pose(-2.0, 0.0, math.pi)
    pixels = picture(robot, room=room)
    row, column = place(robot, -4.0, 0.0, 0.0)
    assert pixels[row + 3, column].std() < 1  # the floor is grey
    assert (pixels[row - 2, column] != pixels[row + 3, column]).any()


@pytest.mark.parametrize(
    "robot", [Pose(-0.2), Pose(-0.15), Pose(0.1, 0.0), Pose(-9.8, -3.4, 3.0), Pose(0.0, 0.0, 1.57)]
)
@pytest.mark.filterwarnings("error")
def test_no_place_is_too_near(robot: Pose) -> None:
    assert picture(robot).shape == (HEIGHT, WIDTH, 3)
