"""A map as a PNG image with a palette: encoded once, in the colours of each request."""

import struct
import zlib

import numpy as np

from dock_gateway.core.png import SIGNATURE, chunk
from dock_gateway.extensions.maps.grid import Cells

# The indices of the palette: 0 to 100 as in the map, and one for all that is unknown.
OCCUPIED, UNKNOWN = 100, 101
_FAST = 1
_DEPTH, _PALETTE = 8, 3

# Red, green, blue and opacity, from 0 to 255.
Color = tuple[int, int, int, int]
# The colours of free, occupied and unknown cells.
COLORS: tuple[Color, Color, Color] = (254, 254, 254, 255), (0, 0, 0, 255), (205, 205, 205, 0)


def encode(cells: Cells) -> bytes:
    """Return the chunk with the pixels of a map, the top row first. A large map takes a while: not on the loop."""
    height, width = cells.shape
    rows = np.empty((height, width + 1), dtype=np.uint8)
    rows[:, 0] = 0  # no filter
    np.minimum(cells.view(np.uint8)[::-1], np.uint8(UNKNOWN), out=rows[:, 1:])
    return chunk(b"IDAT", zlib.compress(rows.data, _FAST))


def image(pixels: bytes, width: int, height: int, colors: tuple[Color, Color, Color]) -> tuple[bytes, bytes, bytes]:
    """Return the image of a map in these colours, in three pieces; what is between free and occupied is between them.

    The second piece is `pixels` itself: many images need no copy of it for each.

    Args:
        pixels: As `encode` returned them.
        width: Number of columns.
        height: Number of rows.
        colors: Those of 0, which is free, of 100, which is occupied, and of what is unknown.
    """
    free, occupied, unknown = colors
    steps = np.linspace(free, occupied, OCCUPIED + 1).round().astype(np.uint8)
    table = np.vstack((steps, np.array([unknown], dtype=np.uint8)))
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, _DEPTH, _PALETTE, 0, 0, 0))
    palette = chunk(b"PLTE", table[:, :3].tobytes()) + chunk(b"tRNS", table[:, 3].tobytes())
    return SIGNATURE + header + palette, pixels, chunk(b"IEND", b"")
