"""Maps as they come from ROS, good and bad."""

import math
import struct
import zlib
from typing import Any

import numpy as np
import pytest
from nav_msgs.msg import OccupancyGrid

from dock_gateway.extensions.maps.grid import read_grid
from dock_gateway.extensions.maps.image import COLORS, encode, image

WIDTH, HEIGHT = 3, 2


def message(**changes: Any) -> OccupancyGrid:
    """A map of six cells; `changes` are attributes of its info."""
    grid = OccupancyGrid()
    grid.header.frame_id = "/map"
    grid.info.resolution, grid.info.width, grid.info.height = 0.05, WIDTH, HEIGHT
    grid.info.origin.orientation.w = 1.0
    grid.data = [0, 100, -1, 50, 127, 0]
    for name, value in changes.items():
        setattr(grid.info, name, value)
    return grid


def test_a_map_is_the_same_wherever_it_comes_from() -> None:
    grid = read_grid(message()).signed()
    assert grid.document() == {
        "revision": grid.revision,
        "stamped_at": None,
        "frame": "map",
        "resolution": 0.05,
        "width": WIDTH,
        "height": HEIGHT,
        "origin": {"x": 0.0, "y": 0.0, "theta": 0.0},
    }
    again = message()
    again.header.stamp.sec = 5
    assert read_grid(again).signed().revision == grid.revision
    again.info.origin.position.x = 1.0
    assert read_grid(again).signed().revision != grid.revision


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"width": 0}, "0 by 2 cells"),
        ({"width": 200_000, "height": 200_000}, "200000 by 200000 cells"),
        ({"width": 4}, "6 values for 4 by 2 cells"),
        ({"resolution": 0.0}, "cells are 0 m wide"),
        ({"resolution": math.nan}, "cells are nan m wide"),
        ({"resolution": -0.05}, "cells are -0.05 m wide"),
    ],
)
def test_what_cannot_be_a_map(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        read_grid(message(**changes))


@pytest.mark.parametrize(("part", "words"), [("position", "position is"), ("orientation", "no rotation")])
def test_an_origin_that_is_none(part: str, words: str) -> None:
    grid = message()
    if part == "position":
        grid.info.origin.position.y = math.nan
    else:
        grid.info.origin.orientation.w = 0.0
    with pytest.raises(ValueError, match=f"of its origin, .*{words}"):
        read_grid(grid)


class Update:
    """A `map_msgs/OccupancyGridUpdate`, which is not installed everywhere."""

    def __init__(self, x: int, y: int, width: int, height: int, data: bytes) -> None:
        self.header = OccupancyGrid().header
        self.x, self.y, self.width, self.height, self.data = x, y, width, height, data


def test_a_part_of_a_map_is_replaced() -> None:
    grid = read_grid(message())
    after = grid.updated(Update(1, 0, 2, 2, bytes([1, 2, 3, 4])))
    assert after.cells.tolist() == [[0, 1, 2], [50, 3, 4]]
    assert grid.cells.tolist() == [[0, 100, -1], [50, 127, 0]]
    for wrong in (Update(2, 0, 2, 2, bytes(4)), Update(-1, 0, 1, 1, bytes(1)), Update(0, 0, 2, 2, bytes(3))):
        with pytest.raises(ValueError, match=r"beyond|values"):
            grid.updated(wrong)


def decode(png: bytes) -> Any:
    """The colours of an image with a palette, by row."""
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    chunks, at = {}, 8
    while at < len(png):
        (size,), kind = struct.unpack_from(">I", png, at), png[at + 4 : at + 8]
        chunks[kind] = png[at + 8 : at + 8 + size]
        assert zlib.crc32(kind + chunks[kind]) == struct.unpack_from(">I", png, at + 8 + size)[0]
        at += size + 12
    width, height, *rest = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert rest == [8, 3, 0, 0, 0]
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, width + 1)
    assert not rows[:, 0].any()
    palette = np.frombuffer(chunks[b"PLTE"], np.uint8).reshape(-1, 3)
    opacity = np.frombuffer(chunks[b"tRNS"], np.uint8)
    return np.dstack((palette[rows[:, 1:]], opacity[rows[:, 1:]])).tolist()


def test_the_image_has_the_top_row_first_and_the_colours_that_were_asked_for() -> None:
    grid = read_grid(message())
    white, black, none = [list(color) for color in COLORS]
    upper, lower = decode(b"".join(image(encode(grid.cells), WIDTH, HEIGHT, COLORS)))
    assert lower == [white, black, none]
    assert upper == [[127, 127, 127, 255], none, white]
    red, blue, green = (255, 0, 0, 255), (0, 0, 255, 255), (0, 255, 0, 128)
    assert decode(b"".join(image(encode(grid.cells), WIDTH, HEIGHT, (red, blue, green))))[1] == [
        list(red),
        list(blue),
        list(green),
    ]
