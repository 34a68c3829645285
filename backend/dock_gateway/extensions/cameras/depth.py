"""Depths in compressed messages, as images that are shown like those that are not compressed."""

import struct
from dataclasses import dataclass

import numpy as np

from dock_gateway.core.png import SIGNATURE
from dock_gateway.extensions.cameras.png import read_png

# What compressedDepth of image_transport puts before a PNG: a number that says nothing, and two that a depth in metres
# is packed with.
_HEADER = struct.Struct("<i2f")
_MILLIMETRES, _METRES, _GRAY = "16UC1", "32FC1", "mono16"


@dataclass(frozen=True)
class DepthImage:
    """The part of a `sensor_msgs/Image` that is needed to show it."""

    width: int
    height: int
    step: int
    encoding: str
    is_bigendian: int
    data: bytes


def read_depth(data: bytes, name: str) -> DepthImage | None:
    """Return the image in a PNG with 16 bits of grey whose numbers are depths; None if it is something else.

    Args:
        data: The data of a `sensor_msgs/CompressedImage`.
        name: Its format, such as `16UC1; png compressed`. Numbers without an encoding are depths.

    Raises:
        Unreadable: It is damaged or too large.
    """
    encoding = name.partition(";")[0].strip()
    is_packed = data.startswith(SIGNATURE, _HEADER.size)
    if not is_packed and (not data.startswith(SIGNATURE) or encoding == _GRAY):  # which browsers show as it is meant
        return None
    png = read_png(data[_HEADER.size :] if is_packed else data)
    if not png.is_gray16:
        return None
    rows = png.rows()
    if is_packed and encoding == _METRES:
        _, scale, offset = _HEADER.unpack_from(data)
        packed = rows.view(">u2").astype(np.float64)
        with np.errstate(all="ignore"):
            metres = np.where(packed > 0, scale / (packed - offset), np.nan).astype("<f4")
        return DepthImage(png.width, png.height, 4 * png.width, _METRES, 0, metres.tobytes())
    kind = _GRAY if encoding == _GRAY else _MILLIMETRES
    return DepthImage(png.width, png.height, 2 * png.width, kind, 1, rows.tobytes())
