"""Encodes the pixels of `sensor_msgs/msg/Image` as JPEG."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[Any]
# The depth that is shown as black; what is near is bright, what was not measured is black, too.
FARTHEST_M = 10.0


class Unreadable(Exception):
    """A picture cannot be shown; the message says why."""


def encode(message: Any, quality: int) -> tuple[bytes, int, int]:
    """Return a JPEG of an Image, with its width and height.

    Args:
        message: A sensor_msgs/Image.
        quality: Of the JPEG, 1 to 100.

    Raises:
        Unreadable: Its encoding is unknown, or its size does not fit its data.
    """
    try:
        size, kind, convert = ENCODINGS[message.encoding]
    except KeyError:
        text = f"the encoding {message.encoding[:60]!r} is not shown; shown are {', '.join(ENCODINGS)}"
        raise Unreadable(text) from None
    width, height, step = message.width, message.height, message.step
    used = width * size
    if step < used or len(message.data) < step * (height - 1) + used:
        got = f"step {step} and {len(message.data)} bytes"
        raise Unreadable(f"{width} x {height} pixels of {message.encoding} do not fit {got}")
    if height == 1:
        step = used  # nothing follows the only row, whatever its step claims
    flat = np.frombuffer(message.data, np.uint8)
    if len(flat) < step * height:  # the last row may lack what follows its pixels
        flat = np.append(flat, np.zeros(step * height - len(flat), np.uint8))
    rows = np.ascontiguousarray(flat[: step * height].reshape(height, step)[:, :used])
    if (dtype := np.dtype(kind)).itemsize > 1:
        rows = rows.view(dtype.newbyteorder(">" if message.is_bigendian else "<"))
    try:
        return convert(rows, quality)
    except ValueError as error:  # a JPEG has at most 65,500 pixels in a row or column
        raise Unreadable(f"{width} x {height} pixels cannot be encoded: {error}") from None


Convert = Callable[[Pixels, int], tuple[bytes, int, int]]


def _colors(rows: Pixels, quality: int, *, order: str) -> tuple[bytes, int, int]:
    return _jpeg(rows.reshape(len(rows), -1, len(order)), quality, order)


def _gray(rows: Pixels, quality: int) -> tuple[bytes, int, int]:
    return _jpeg(rows[:, :, None], quality, "GRAY")


def _depth(rows: Pixels, quality: int, *, unit: float) -> tuple[bytes, int, int]:
    metres = np.nan_to_num(rows.astype(np.float32) * unit, nan=0.0, posinf=0.0, neginf=0.0).clip(0.0, FARTHEST_M)
    near = np.where(metres > 0.0, 255.0 * (1.0 - metres / FARTHEST_M), 0.0)
    return _gray(near.astype(np.uint8), quality)


def _yuv422(rows: Pixels, quality: int, *, first: str) -> tuple[bytes, int, int]:
    """Encode pairs of pixels that share their colour, U Y V Y or Y U Y V."""
    import simplejpeg  # noqa: PLC0415 - only if someone watches

    if rows.shape[1] % 4:
        raise Unreadable(f"{rows.shape[1] // 2} pixels in a row of YUV 4:2:2 are not pairs")
    y, u, v = (1, 0, 2) if first == "u" else (0, 1, 3)
    planes = (np.ascontiguousarray(rows[:, at::each]) for at, each in ((y, 2), (u, 4), (v, 4)))
    return simplejpeg.encode_jpeg_yuv_planes(*planes, quality=quality), rows.shape[1] // 2, len(rows)


def _bayer(rows: Pixels, quality: int, *, pattern: str) -> tuple[bytes, int, int]:
    """Encode at half the size: each square of four sensors is a pixel."""
    rows = rows[: len(rows) // 2 * 2, : rows.shape[1] // 2 * 2]
    if not rows.size:
        raise Unreadable("a Bayer picture needs two rows and columns")
    sensors = [rows[at // 2 :: 2, at % 2 :: 2] for at in range(4)]
    red, blue = (sensors[pattern.index(color)] for color in "rb")
    greens = [sensors[at] for at in range(4) if pattern[at] == "g"]
    green = greens[0] // 2 + greens[1] // 2
    return _jpeg(np.dstack((red, green, blue)), quality, "RGB")


def _jpeg(pixels: Pixels, quality: int, order: str) -> tuple[bytes, int, int]:
    import simplejpeg  # noqa: PLC0415 - only if someone watches

    if pixels.dtype.itemsize > 1:
        pixels = (pixels >> 8).astype(np.uint8)
    subsampling = "Gray" if order == "GRAY" else "420"
    data = simplejpeg.encode_jpeg(np.ascontiguousarray(pixels), quality, order, subsampling)
    return data, pixels.shape[1], pixels.shape[0]


_BAYER: dict[str, tuple[int, str, Convert]] = {
    f"bayer_{pattern}{8 * size}": (size, f"u{size}", partial(_bayer, pattern=pattern))
    for pattern in ("rggb", "bggr", "gbrg", "grbg")
    for size in (1, 2)
}
# By the name in `encoding`: bytes of a pixel, the type of its numbers, and what encodes rows of them.
ENCODINGS: dict[str, tuple[int, str, Convert]] = {
    "rgb8": (3, "u1", partial(_colors, order="RGB")),
    "bgr8": (3, "u1", partial(_colors, order="BGR")),
    "8UC3": (3, "u1", partial(_colors, order="BGR")),
    "rgba8": (4, "u1", partial(_colors, order="RGBA")),
    "bgra8": (4, "u1", partial(_colors, order="BGRA")),
    "8UC4": (4, "u1", partial(_colors, order="BGRA")),
    "rgb16": (6, "u2", partial(_colors, order="RGB")),
    "bgr16": (6, "u2", partial(_colors, order="BGR")),
    "rgba16": (8, "u2", partial(_colors, order="RGBA")),
    "bgra16": (8, "u2", partial(_colors, order="BGRA")),
    "mono8": (1, "u1", _gray),
    "8UC1": (1, "u1", _gray),
    "mono16": (2, "u2", _gray),
    "16UC1": (2, "u2", partial(_depth, unit=0.001)),
    "32FC1": (4, "f4", partial(_depth, unit=1.0)),
    "yuv422": (2, "u1", partial(_yuv422, first="u")),
    "uyvy": (2, "u1", partial(_yuv422, first="u")),
    "yuv422_yuy2": (2, "u1", partial(_yuv422, first="y")),
    "yuyv": (2, "u1", partial(_yuv422, first="y")),
    **_BAYER,
}
