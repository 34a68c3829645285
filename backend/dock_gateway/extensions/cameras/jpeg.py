"""The JPEG in some bytes, as decoders find it: what is before its start and behind its end does not matter."""

import re
from dataclasses import dataclass

from dock_gateway.extensions.cameras.pixels import Unreadable

# Bytes before the start of a JPEG that are looked through.
MAX_JUNK = 1024
_START, _END = b"\xff\xd8\xff", b"\xff\xd9"
# Codes of markers: start, end, a part of the picture, one without a length, and those with the size of the picture.
_SOI, _EOI, _SOS, _TEM = 0xD8, 0xD9, 0xDA, 0x01
_SIZES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
# Within a picture, a stuffed byte, a restart and a fill byte are no end of it.
_MARKER = re.compile(rb"\xff([^\x00\xd0-\xd7\xff])")


@dataclass(frozen=True)
class Jpeg:
    """A JPEG.

    Attributes:
        data: The file from its start to its end.
        width: In pixels.
        height: In pixels.
        is_gray: Whether it has no colours.
    """

    data: bytes
    width: int
    height: int
    is_gray: bool


def find_jpeg(data: bytes) -> int:
    """Return where a JPEG starts; -1 if there is none."""
    return data.find(_START, 0, MAX_JUNK + len(_START))


def read_jpeg(data: bytes) -> Jpeg:
    """Return the JPEG that some bytes begin with. One that is cut off gets an end: decoders show what there is of it.

    Raises:
        Unreadable: It is cut off before its picture.
    """
    at, size, has_picture = len(_START) - 1, b"", False
    while marker := _MARKER.search(data, at):
        code, at = marker[1][0], marker.end()
        if code == _EOI and has_picture:
            return _jpeg(data[:at], size)
        if code in (_TEM, _EOI):
            continue
        start, at = at, at + max(2, int.from_bytes(data[at : at + 2]))
        if code == _SOI or at > len(data):  # another JPEG begins, or a part is cut off
            data = data[: marker.start()]
        elif code in _SIZES:
            size = size or data[start + 3 : start + 8]
        elif code == _SOS:
            has_picture = has_picture or at < len(data)
    if not has_picture or not size:
        raise Unreadable("a JPEG is cut off before its picture")
    return _jpeg(data + _END, size)


def _jpeg(data: bytes, size: bytes) -> Jpeg:
    return Jpeg(data, int.from_bytes(size[2:4]), int.from_bytes(size[:2]), is_gray=size[4:] == b"\1")
