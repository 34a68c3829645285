"""Text as a PNG image, the compression of rosbridge that needs no binary messages."""

import math
import struct
import zlib
from itertools import chain

from dock_gateway.core.png import SIGNATURE, chunk

_PIXEL = 3  # bytes, of 8 bits for each of red, green and blue
_FAST = 1


def encode(text: bytes) -> bytes:
    """Return an image whose pixels are the bytes of a text, filled up with line feeds."""
    width = max(1, math.isqrt(len(text) // _PIXEL))
    row = width * _PIXEL
    height = max(1, -(-len(text) // row))
    filled = text.ljust(row * height, b"\n")
    rows = chain.from_iterable((b"\0", filled[start : start + row]) for start in range(0, len(filled), row))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(b"".join(rows), _FAST)), (b"IEND", b""))
    return SIGNATURE + b"".join(chunk(kind, data) for kind, data in chunks)
