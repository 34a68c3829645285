"""Pictures as they come: passed on, scaled down, or refused with a reason."""

from contextlib import suppress
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import simplejpeg

from dock_gateway.cameras.camera import COMPRESSED, IMAGE
from dock_gateway.cameras.picture import JPEG, MOST_BYTES, PNG, Picture, Unreadable, read_picture
from dock_gateway.graph.received import Received

GRADIENT = np.tile(np.arange(160, dtype=np.uint8), (90, 1))
JPEG_FILE = simplejpeg.encode_jpeg(np.ascontiguousarray(np.dstack([GRADIENT] * 3)))
GRAY_FILE = simplejpeg.encode_jpeg(np.ascontiguousarray(GRADIENT[:, :, None]), 80, "GRAY", "Gray")
PNG_FILE = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\xa0\0\0\0Z\x08\0\0\0\0....IDAT....\0\0\0\0IEND\xaeB`\x82"


def received(decoded: Any, kind: str = COMPRESSED, size: int = 100) -> Received:
    def decode(_: bytes) -> Any:
        if decoded is None:
            raise ValueError("no such bytes")
        return decoded

    message = SimpleNamespace(
        kind=SimpleNamespace(name=kind, decode=decode), data=b"", size=size, received_ns=1_700_000_000_250_000_000
    )
    return cast("Received", message)


def compressed(data: bytes, name: str = "jpeg") -> Received:
    return received(SimpleNamespace(data=data, format=name))


@pytest.mark.parametrize(("data", "kind"), [(JPEG_FILE, JPEG), (PNG_FILE, PNG), (JPEG_FILE + bytes(64), JPEG)])
def test_what_browsers_show_is_passed_on(data: bytes, kind: str) -> None:
    picture = read_picture(compressed(data), 75)
    assert picture == Picture(data, kind, 160, 90, 1_700_000_000_250_000_000)
    head, _, rest = picture.part.partition(b"\r\n\r\n")
    assert f"Content-Length: {len(data)}".encode() in head
    assert b"X-Timestamp: 1700000000.250000" in head
    assert rest == data + b"\r\n--picture\r\n"


@pytest.mark.parametrize("data", [JPEG_FILE, GRAY_FILE])
@pytest.mark.parametrize(("most", "size"), [(160, (160, 90)), (159, (140, 79)), (80, (80, 45)), (1, (20, 12))])
def test_a_jpeg_is_scaled_by_eighths(data: bytes, most: int, size: tuple[int, int]) -> None:
    whole = read_picture(compressed(data), 75)
    small = whole if (eighths := whole.eighths(most)) == 8 else whole.scaled(eighths, 75)
    assert (small.width, small.height) == size
    assert simplejpeg.decode_jpeg_header(small.data)[:2] == size[::-1]


def test_a_png_keeps_its_size() -> None:
    assert read_picture(compressed(PNG_FILE, "png"), 75).eighths(16) == 8


def test_an_image_is_encoded() -> None:
    decoded = SimpleNamespace(encoding="mono8", width=160, height=90, step=160, is_bigendian=0, data=GRADIENT.tobytes())
    picture = read_picture(received(decoded, IMAGE), 75)
    assert simplejpeg.decode_jpeg_header(picture.data)[:2] == (90, 160)
    assert (picture.media_type, picture.width) == (JPEG, 160)


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (compressed(b"\0\0\0\1abc", "h264"), "the format 'h264' is neither jpeg nor png"),
        (compressed(b""), "the format 'jpeg' is neither"),
        (compressed(JPEG_FILE[:-400]), "a JPEG is cut off"),
        (compressed(JPEG_FILE[:20]), "a JPEG is damaged"),
        (compressed(PNG_FILE[:-12]), "a PNG is cut off"),
        (compressed(PNG_FILE.replace(b"\0\0\0\xa0", b"\x7f\0\0\0")), "million are shown"),
        (received(None), "cannot be read as sensor_msgs/msg/CompressedImage: no such bytes"),
        (received(None, "std_msgs/msg/String"), "its type is std_msgs/msg/String"),
        (received(None, IMAGE, size=MOST_BYTES + 1), "a picture has 32 MB; at most 32 MB are read"),
        (received(SimpleNamespace(width=0, height=9), IMAGE), "0 x 9 pixels"),
        (received(SimpleNamespace(width=2**32 - 1, height=2**32 - 1), IMAGE), "million are shown"),
    ],
)
def test_what_cannot_be_shown_is_refused(message: Received, words: str) -> None:
    with pytest.raises(Unreadable, match=words):
        read_picture(message, 75)


def test_a_jpeg_that_is_damaged_within_is_refused_or_shown() -> None:
    damaged = JPEG_FILE[:300] + bytes(200) + JPEG_FILE[500:]
    with suppress(Unreadable):
        assert read_picture(compressed(damaged), 75).scaled(4, 75).width == 80
