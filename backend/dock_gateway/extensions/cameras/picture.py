"""A picture of a camera as browsers show it: JPEG or PNG."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from dock_gateway.core.png import SIGNATURE
from dock_gateway.extensions.cameras.camera import COMPRESSED, IMAGE
from dock_gateway.extensions.cameras.depth import read_depth
from dock_gateway.extensions.cameras.jpeg import find_jpeg, read_jpeg
from dock_gateway.extensions.cameras.pixels import Unreadable, encode
from dock_gateway.extensions.cameras.png import read_png
from dock_gateway.graph.received import Received

# The largest message that is read, in bytes, and the most pixels of a picture: 4K in colour fits.
MOST_BYTES, MOST_PIXELS = 32_000_000, 33_000_000
# A JPEG can be decoded at one to eight eighths of its size, which takes less time than at its whole size.
WHOLE = 8
JPEG, PNG = "image/jpeg", "image/png"
# Between the pictures of a stream.
BOUNDARY = "picture"


@dataclass(frozen=True)
class Picture:
    """An encoded picture.

    Attributes:
        data: The file.
        media_type: JPEG or PNG.
        width: In pixels.
        height: In pixels.
        received_ns: When the gateway received it, in ns since 1970.
    """

    data: bytes
    media_type: str
    width: int
    height: int
    received_ns: int

    @property
    def timestamp(self) -> str:
        """The time when the gateway received it, in seconds since 1970."""
        return f"{self.received_ns / 1e9:.6f}"

    @cached_property
    def part(self) -> bytes:
        """The picture in a stream. The boundary follows at once: browsers show a picture when it has come."""
        head = (
            f"Content-Type: {self.media_type}\r\nContent-Length: {len(self.data)}\r\nX-Timestamp: {self.timestamp}\r\n"
        )
        return b"%b\r\n%b\r\n--%b\r\n" % (head.encode(), self.data, BOUNDARY.encode())

    def eighths(self, max_width: int) -> int:
        """Return at how many eighths of its size it is at most so wide; at least one. A PNG keeps its size."""
        return WHOLE if self.media_type != JPEG else min(WHOLE, max(1, WHOLE * max_width // self.width))

    def scaled(self, eighths: int, quality: int) -> "Picture":
        """Return a JPEG at `eighths` eighths of its size.

        Raises:
            Unreadable: It is damaged.
        """
        import simplejpeg  # noqa: PLC0415 - only if someone watches

        width, height = (-(-size * eighths // WHOLE) for size in (self.width, self.height))
        try:
            gray = read_jpeg(self.data).is_gray
            colors = "GRAY" if gray else "RGB"
            # What the decoder does not reach of a damaged picture is black, and not what the memory held before.
            room = np.zeros(self.width * self.height * (1 if gray else 3), np.uint8)
            pixels = simplejpeg.decode_jpeg(
                self.data, colors, min_width=width, min_height=height, buffer=room, strict=False
            )
        except ValueError as error:
            raise Unreadable(f"the JPEG is damaged: {error}") from None
        data = simplejpeg.encode_jpeg(pixels, quality, colors, "Gray" if gray else "420")
        return replace(self, data=data, width=pixels.shape[1], height=pixels.shape[0])


def read_picture(message: Received, quality: int) -> Picture:
    """Return the picture of a message: as it is if browsers show it, else encoded.

    Args:
        message: Of any type.
        quality: Of a JPEG that is encoded, 1 to 100.

    Raises:
        Unreadable: Browsers do not show it, or it is damaged.
    """
    if message.kind.name not in (IMAGE, COMPRESSED):
        raise Unreadable(f"its type is {message.kind.name}")
    if message.size > MOST_BYTES:
        raise Unreadable(f"a picture has {message.size / 1e6:.0f} MB; at most {MOST_BYTES / 1e6:.0f} MB are read")
    try:
        decoded = message.kind.decode(message.data)
    except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
        raise Unreadable(f"its messages cannot be read as {message.kind.name}: {error}") from None
    if message.kind.name == IMAGE:
        return _encoded(decoded, quality, message.received_ns)
    data = bytes(decoded.data)
    if (depth := read_depth(data, decoded.format)) is not None:
        return _encoded(depth, quality, message.received_ns)
    return _as_it_is(data, decoded.format, message.received_ns)


def _encoded(image: Any, quality: int, received_ns: int) -> Picture:
    _check_size(image.width, image.height)
    data, width, height = encode(image, quality)
    return Picture(data, JPEG, width, height, received_ns)


def _as_it_is(data: bytes, name: str, received_ns: int) -> Picture:
    if data.startswith(SIGNATURE):
        png = read_png(data)
        data, kind, width, height = png.data, PNG, png.width, png.height
    elif (start := find_jpeg(data)) >= 0:
        jpeg = read_jpeg(data[start:])
        data, kind, width, height = jpeg.data, JPEG, jpeg.width, jpeg.height
    else:
        raise Unreadable(f"the format {name[:60]!r} is neither jpeg nor png")
    _check_size(width, height)
    return Picture(data, kind, width, height, received_ns)


def _check_size(width: Any, height: Any) -> None:
    if not 0 < width * height <= MOST_PIXELS:
        raise Unreadable(f"a picture has {width} x {height} pixels; 1 to {MOST_PIXELS / 1e6:.0f} million are shown")
