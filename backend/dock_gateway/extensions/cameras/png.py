"""PNG files: where they end, and the numbers in those with 16 bits of grey."""

import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dock_gateway.core.png import SIGNATURE
from dock_gateway.extensions.cameras.pixels import Unreadable

_HEADER_SIZE = 33
# The largest PNG whose numbers are read: it takes about a microsecond a pixel, and 50 a row and column.
MAX_NUMBERS, MAX_SIDE = 4_200_000, 8_192
_LAST_FILTER = 4


@dataclass(frozen=True)
class Png:
    """A PNG.

    Attributes:
        data: The file from its start to its end. One that is cut off has what there is of it.
        width: In pixels.
        height: In pixels.
        is_gray16: Whether its pixels are numbers of 16 bits.
    """

    data: bytes
    width: int
    height: int
    is_gray16: bool

    def rows(self) -> npt.NDArray[np.uint8]:
        """Return the rows of a PNG with 16 bits of grey: two bytes for each number, the greater one first.

        Rows that are cut off are 0.

        Raises:
            Unreadable: It is damaged, interlaced or too large.
        """
        if not 0 < self.width * self.height <= MAX_NUMBERS or max(self.width, self.height) > MAX_SIDE:
            most = f"at most {MAX_NUMBERS / 1e6:g} million, and {MAX_SIDE} in a row or column, are read"
            raise Unreadable(f"a PNG of 16 bits has {self.width} x {self.height} pixels; {most}")
        if self.data[28]:
            raise Unreadable("an interlaced PNG of 16 bits is not shown")
        packed = b"".join(content for kind, content in _chunks(self.data) if kind == b"IDAT")
        size = self.height * (2 * self.width + 1)
        try:
            raw = zlib.decompressobj().decompress(packed, size)
        except zlib.error as error:
            raise Unreadable(f"a PNG is damaged: {error}") from None
        table = np.frombuffer(raw.ljust(size, b"\0"), np.uint8).reshape(self.height, -1)
        return _unfiltered(table[:, 0], table[:, 1:].reshape(self.height, self.width, 2))


def read_png(data: bytes) -> Png:
    """Return the PNG that some bytes begin with.

    Raises:
        Unreadable: It is cut off before its picture.
    """
    at, has_picture = len(SIGNATURE), False
    for kind, content in _chunks(data):
        at += 12 + len(content)
        has_picture = has_picture or (kind == b"IDAT" and bool(content))
        if kind == b"IEND":
            break
    if not has_picture or len(data) < _HEADER_SIZE:
        raise Unreadable("a PNG is cut off before its picture")
    width, height = (int.from_bytes(data[at : at + 4]) for at in (16, 20))
    return Png(data[:at], width, height, data[24:26] == b"\x10\0")


def _chunks(data: bytes) -> Any:
    """Yield the kind and the content of each chunk; the last one may be cut off."""
    at = len(SIGNATURE)
    while at + 8 <= len(data):
        size = int.from_bytes(data[at : at + 4])
        yield data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        at += 12 + size


def _unfiltered(filters: npt.NDArray[np.uint8], rows: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return rows without their filters.

    A pixel depends on its left, its upper and its upper left neighbour. So all pixels of a diagonal are known at once.
    """
    if filters.max(initial=0) > _LAST_FILTER:
        raise Unreadable("a PNG is damaged: it has a filter that does not exist")
    height, width, size = rows.shape
    # What is above the first row and left of the first column is 0.
    padded = np.zeros((height + 1, width + 1, size), np.int16)
    padded[1:, 1:] = rows
    pixels, stride = padded.reshape(-1, size), width + 1
    kinds = np.broadcast_to(filters[:, None], (height, size))
    for diagonal in range(width + height - 1):
        first, end = max(0, diagonal - width + 1), min(height, diagonal + 1)
        # From row to row of a diagonal it is one stride less one pixel.
        start = stride + 1 + diagonal + first * width
        left, above, corner, values = (
            pixels[start - back : start - back + (end - first) * width : width] for back in (1, stride, stride + 1, 0)
        )
        to_left, to_above, to_corner = np.abs(above - corner), np.abs(left - corner), np.abs(left + above - 2 * corner)
        closer = np.where(to_above <= to_corner, above, corner)
        paeth = np.where(to_left <= np.minimum(to_above, to_corner), left, closer)
        predicted = np.choose(kinds[first:end], (np.zeros_like(left), left, above, (left + above) >> 1, paeth))
        values[:] = (values + predicted) & 0xFF
    return padded[1:, 1:].astype(np.uint8).reshape(height, -1)
