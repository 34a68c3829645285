"""Pictures as they come: passed on, scaled down, or refused with a reason."""

from contextlib import suppress
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import simplejpeg
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.extensions.cameras.camera import IMAGE
from dock_gateway.extensions.cameras.picture import JPEG, MOST_BYTES, PNG, Picture, Unreadable, read_picture
from dock_gateway.graph.received import Received
from tests.extensions.cameras.messages import received
from tests.support.pictures import BASELINE, GRAY, PROGRESSIVE, RESTARTING, encode_png, with_fill_bytes, with_thumbnail

NUMBERS = np.tile(np.arange(160, dtype=np.uint8), (90, 1))
PNG_FILE = encode_png(NUMBERS)


def compressed(data: bytes, name: str = "jpeg") -> Received:
    return received(SimpleNamespace(data=data, format=name))


@pytest.mark.parametrize(("data", "kind"), [(BASELINE, JPEG), (PNG_FILE, PNG)])
def test_what_browsers_show_is_passed_on(data: bytes, kind: str) -> None:
    picture = read_picture(compressed(data), 75)
    assert picture == Picture(data, kind, 160, 90, 1_700_000_000_250_000_000)
    head, _, rest = picture.part.partition(b"\r\n\r\n")
    assert f"Content-Length: {len(data)}".encode() in head
    assert b"X-Timestamp: 1700000000.250000" in head
    assert rest == data + b"\r\n--picture\r\n"


@pytest.mark.parametrize("data", [BASELINE, GRAY])
@pytest.mark.parametrize(("most", "size"), [(160, (160, 90)), (159, (140, 79)), (80, (80, 45)), (1, (20, 12))])
def test_a_jpeg_is_scaled_by_eighths(data: bytes, most: int, size: tuple[int, int]) -> None:
    whole = read_picture(compressed(data), 75)
    small = whole if (eighths := whole.eighths(most)) == 8 else whole.scaled(eighths, 75)
    assert (small.width, small.height) == size
    assert simplejpeg.decode_jpeg_header(small.data)[:2] == size[::-1]


def test_a_png_keeps_its_size() -> None:
    assert read_picture(compressed(PNG_FILE, "png"), 75).eighths(16) == 8


def test_an_image_is_encoded() -> None:
    decoded = SimpleNamespace(encoding="mono8", width=160, height=90, step=160, is_bigendian=0, data=NUMBERS.tobytes())
    picture = read_picture(received(decoded, IMAGE), 75)
    assert simplejpeg.decode_jpeg_header(picture.data)[:2] == (90, 160)
    assert (picture.media_type, picture.width) == (JPEG, 160)


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (compressed(b"\0\0\0\1abc", "h264"), "the format 'h264' is neither jpeg nor png"),
        (compressed(b""), "the format 'jpeg' is neither"),
        (compressed(BASELINE[:20]), "a JPEG is cut off before its picture"),
        (compressed(with_thumbnail(BASELINE[:20])), "a JPEG is cut off before its picture"),
        (compressed(BASELINE[:20] + b"\xff\xd9"), "a JPEG is cut off before its picture"),
        (compressed(b"\xff\xd8\xff\xda\0\x08" + bytes(99)), "a JPEG is cut off before its picture"),
        (compressed(bytes(2000) + BASELINE), "the format 'jpeg' is neither jpeg nor png"),
        (compressed(PNG_FILE[:40]), "a PNG is cut off before its picture"),
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


KINDS = {
    "baseline": BASELINE,
    "odd": BASELINE[:20] + bytes(183) + BASELINE[20:],  # bytes between two parts
    "grey": GRAY,
    "progressive": PROGRESSIVE,
    "restarting": RESTARTING,
    "filled": with_fill_bytes(BASELINE),
    "thumbnail": with_thumbnail(PROGRESSIVE),
}
JUNK = st.binary(max_size=200) | st.just(b"\xff\xd9") | st.just(BASELINE) | st.just(bytes(144))
# No start of a picture, also with what follows.
BEFORE = st.binary(max_size=200).map(lambda junk: junk.replace(b"\xff", b"\0").replace(b"PNG", b""))


@pytest.mark.parametrize("kind", KINDS)
@given(before=BEFORE, behind=JUNK)
def test_what_is_before_and_behind_a_jpeg_is_left_out(kind: str, before: bytes, behind: bytes) -> None:
    """As the decoder does, whatever it is: memory of a camera, the head of a part of a stream, another JPEG."""
    data = KINDS[kind]
    picture = read_picture(compressed(before + data + behind), 75)
    assert picture.data == data
    height, width = simplejpeg.decode_jpeg_header(data, strict=False)[:2]
    assert (picture.width, picture.height) == (width, height)


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
def test_a_jpeg_that_is_cut_off_is_shown_as_far_as_it_goes(kind: str, data: st.DataObject) -> None:
    """Wherever it is cut off: what is passed on has an end, and a decoder that shows it."""
    whole = KINDS[kind]
    part = whole[: data.draw(st.integers(3, len(whole) - 1))]
    start = whole.index(b"\xff\xda\0", len(whole) - len(PROGRESSIVE) if kind == "thumbnail" else 0)
    if len(part) <= start + 2 + int.from_bytes(whole[start + 2 : start + 4]):
        with pytest.raises(Unreadable, match="cut off before its picture"):
            read_picture(compressed(part), 75)
        return
    shown = read_picture(compressed(part), 75)
    assert shown.data.endswith(b"\xff\xd9")
    assert shown.data[:-2] == part[: len(shown.data) - 2]
    if kind == "odd":  # which this decoder does not read
        return
    if kind not in ("progressive", "thumbnail"):  # whose first scan may be too short to show anything
        black, white = (decoded_into(shown.data, value) for value in (0, 255))
        assert np.array_equal(black, white)
    assert shown.scaled(4, 75).width == -(-shown.width // 2)


def decoded_into(jpeg: bytes, value: int) -> Any:
    """The pixels of a JPEG; those that the decoder does not write are this value."""
    height, width = simplejpeg.decode_jpeg_header(jpeg, strict=False)[:2]
    return simplejpeg.decode_jpeg(jpeg, buffer=np.full((height, width, 3), value, np.uint8), strict=False)


@given(st.lists(st.tuples(st.integers(100, 690), st.integers(0, 255)), min_size=1, max_size=6), st.integers(1, 7))
def test_a_damaged_jpeg_shows_nothing_of_the_memory(changes: list[tuple[int, int]], eighths: int) -> None:
    damaged = bytearray(RESTARTING)
    for at, value in changes:
        damaged[at] = value
    with suppress(Unreadable):
        whole = read_picture(compressed(bytes(damaged)), 75)
        first = whole.scaled(eighths, 75).data
        np.full((4096, 4096), 255, np.uint8).sum()  # memory that is given back, and taken by the next picture
        [np.full(whole.width * whole.height * 3, value, np.uint8) for value in range(20)]
        assert whole.scaled(eighths, 75).data == first


@given(behind=JUNK, cut=st.integers(1, 30))
def test_what_is_behind_a_png_is_left_out_and_one_that_is_cut_off_is_shown_as_far_as_it_goes(
    behind: bytes, cut: int
) -> None:
    assert read_picture(compressed(PNG_FILE + behind, "png"), 75).data == PNG_FILE
    part = PNG_FILE[:-cut]
    assert part.startswith(shown := read_picture(compressed(part, "png"), 75).data)
    assert len(shown) > 60


@given(st.binary(max_size=300), st.sampled_from([BASELINE, PROGRESSIVE, PNG_FILE, encode_png(NUMBERS * np.uint16(99))]))
def test_whatever_comes_is_shown_or_refused_with_a_reason(noise: bytes, start: bytes) -> None:
    for data in (noise, start[: len(noise)] + noise, start[:100] + noise + start[100 + len(noise) :]):
        with suppress(Unreadable):
            assert read_picture(compressed(data, "16UC1; png compressed"), 75).width


def test_a_jpeg_that_is_damaged_within_is_refused_or_shown() -> None:
    damaged = BASELINE[:300] + bytes(200) + BASELINE[500:]
    with suppress(Unreadable):
        assert read_picture(compressed(damaged), 75).scaled(4, 75).width == 80
