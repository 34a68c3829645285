"""A depth is shown the same, however it comes: raw, in a PNG, or as image_transport packs it."""

import struct
import tracemalloc
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import simplejpeg
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from dock_gateway.extensions.cameras.camera import COMPRESSED, IMAGE
from dock_gateway.extensions.cameras.depth import read_depth
from dock_gateway.extensions.cameras.picture import JPEG, PNG, Picture, read_picture
from dock_gateway.extensions.cameras.pixels import Unreadable
from dock_gateway.extensions.cameras.png import MAX_SIDE, read_png
from tests.extensions.cameras.messages import received
from tests.support.pictures import chunk, encode_png

FILTERS = st.lists(st.integers(0, 4), min_size=1, max_size=5)
SHAPES = st.tuples(st.integers(1, 12), st.integers(1, 12))
# What image_transport writes into the header of 32-bit depths: a depth in metres is a / (number - b).
A, B = 1000.0, -99.0
HEADER = struct.pack("<i2f", 1, A, B)


def raw(numbers: Any, encoding: str) -> Picture:
    height, width = numbers.shape
    size = numbers.dtype.itemsize
    image = SimpleNamespace(
        encoding=encoding, width=width, height=height, step=width * size, is_bigendian=0, data=numbers.tobytes()
    )
    return read_picture(received(image, IMAGE), 90)


def packed(data: bytes, name: str) -> Picture:
    return read_picture(received(SimpleNamespace(data=data, format=name), COMPRESSED), 90)


@given(arrays.arrays(np.uint16, SHAPES), FILTERS)
def test_the_numbers_of_a_png_are_read_whatever_its_filters(numbers: Any, filters: list[int]) -> None:
    rows = read_png(encode_png(numbers, filters)).rows()
    assert np.array_equal(rows.view(">u2"), numbers)


@given(arrays.arrays(np.uint16, SHAPES), FILTERS, st.data())
def test_a_png_that_is_cut_off_has_the_rows_that_there_are(
    numbers: Any, filters: list[int], data: st.DataObject
) -> None:
    whole = encode_png(numbers, filters)
    part = whole[: data.draw(st.integers(0, len(whole)))]
    try:
        rows = read_png(part).rows().view(">u2")
    except Unreadable:
        return
    differs = (rows != numbers).any(axis=1)
    assert not rows[np.maximum.accumulate(differs)][1:].any()


@pytest.mark.parametrize("shape", [(480, 640), (1, MAX_SIDE), (MAX_SIDE, 1), (MAX_SIDE, 2), (400, MAX_SIDE)])
def test_the_memory_that_a_png_takes_depends_on_its_pixels(shape: tuple[int, int]) -> None:
    numbers = np.arange(shape[0] * shape[1], dtype=np.uint32).astype(np.uint16).reshape(shape)
    png = read_png(encode_png(numbers, (4, 3)))
    tracemalloc.start()
    try:
        rows = png.rows()
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert np.array_equal(rows.view(">u2"), numbers)
    assert most < 16 * numbers.size + 2_000_000


@given(arrays.arrays(np.uint16, SHAPES), FILTERS)
@settings(max_examples=30)
def test_a_depth_in_millimetres_is_shown_the_same_however_it_comes(numbers: Any, filters: list[int]) -> None:
    png = encode_png(numbers, filters)
    plain = raw(numbers, "16UC1")
    assert plain.media_type == JPEG
    for name in ("16UC1; png compressed", "16UC1;png compressed ", "png", "16UC1; png compressed 16UC1"):
        assert packed(png, name) == plain
    for header in (HEADER, bytes(12)):  # which says the same of whatever it holds
        assert packed(header + png, "16UC1; compressedDepth png") == plain
        assert packed(header + png, "16UC1; compressedDepth") == plain
    assert packed(HEADER + png, "mono16; compressedDepth png") == raw(numbers, "mono16")


@given(arrays.arrays(np.float32, SHAPES, elements=st.just(np.nan) | st.floats(0.25, 60, width=32)), FILTERS)
@example(np.array([[10.0625]], np.float32), [0])
@settings(max_examples=30)
def test_a_depth_in_metres_is_shown_the_same_however_it_comes(metres: Any, filters: list[int]) -> None:
    numbers = np.where(np.isnan(metres), 0, np.round(A / metres + B)).clip(0).astype(np.uint16)
    found = read_depth(HEADER + encode_png(numbers, filters), "32FC1; compressedDepth png")
    assert found is not None
    depths = np.frombuffer(found.data, np.float32).reshape(metres.shape)
    near = numbers > 0  # up to about 10 m; what is farther is black, as what was not measured
    assert depths[near] == pytest.approx(metres[near], rel=0.06)
    shown, plain = (
        simplejpeg.decode_jpeg(each.data).astype(int)
        for each in (packed(HEADER + encode_png(numbers), "32FC1; compressedDepth png"), raw(metres, "32FC1"))
    )
    assert np.abs(shown - plain).max() <= 25


def test_two_depths_are_told_apart() -> None:
    numbers = np.full((8, 16), 1000, np.uint16)
    numbers[:, 8:] = 4000
    pixels = simplejpeg.decode_jpeg(packed(encode_png(numbers), "16UC1; png compressed").data)
    assert pixels[4, 2] == pytest.approx((229,) * 3, abs=3)
    assert pixels[4, 13] == pytest.approx((153,) * 3, abs=3)


@pytest.mark.parametrize(
    ("rows", "name"),
    [
        (np.full((2, 2), 99 << 8, np.uint16), "mono16; png compressed"),
        (np.full((2, 2), 99, np.uint8), "8UC1; png compressed"),
        (np.full((2, 2), 99, np.uint8), "16UC1; png compressed"),
    ],
)
def test_what_browsers_show_as_it_is_meant_is_passed_on(rows: Any, name: str) -> None:
    data = encode_png(rows)
    assert (packed(data, name).media_type, packed(data, name).data) == (PNG, data)


def test_what_cannot_be_read_is_refused_with_a_reason() -> None:
    numbers = np.zeros((2, 2), np.uint16)
    good = encode_png(numbers)
    header = good[16:29]
    interlaced = good.replace(chunk(b"IHDR", header), chunk(b"IHDR", header[:-1] + b"\1"))
    with pytest.raises(Unreadable, match="interlaced"):
        packed(interlaced, "16UC1; png compressed")
    for size in ((60_000, 60_000), (2_000_000, 2), (0, 0)):
        odd = good.replace(header, struct.pack(">II", *size) + header[8:])
        with pytest.raises(Unreadable, match=f"{size[0]} x {size[1]} pixels"):
            packed(odd, "16UC1; png compressed")
    at = good.index(b"IDAT") + 4
    with pytest.raises(Unreadable, match="a PNG is damaged"):
        packed(good[:at] + b"\0" + good[at + 1 :], "16UC1; png compressed")
    with pytest.raises(Unreadable, match="the format '16UC1; compressedDepth rvl' is neither"):
        packed(HEADER + bytes(40), "16UC1; compressedDepth rvl")
