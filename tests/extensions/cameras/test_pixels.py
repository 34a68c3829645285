"""Pixels of sensor_msgs/Image become JPEG, or one sentence says why not."""

from contextlib import suppress
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import simplejpeg

from dock_gateway.extensions.cameras.pixels import ENCODINGS, Unreadable, encode

WIDTH, HEIGHT = 32, 16
RED = (200, 30, 30)


def image(encoding: str, rows: Any, *, width: int = WIDTH, big: bool = False, pad: int = 0) -> Any:
    """An Image of rows of bytes, each with `pad` bytes behind it."""
    rows = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), -1)
    rows = np.pad(rows, ((0, 0), (0, pad)))
    return SimpleNamespace(
        encoding=encoding,
        width=width,
        height=len(rows),
        step=rows.shape[1],
        is_bigendian=int(big),
        data=rows.tobytes(),
    )


def shown(message: Any) -> Any:
    """The middle pixel that a browser would show."""
    data, width, height = encode(message, 95)
    pixels = simplejpeg.decode_jpeg(data)
    assert pixels.shape == (height, width, 3)
    return pixels[height // 2, width // 2].astype(int)


def of_one(*values: int, dtype: str = "u1") -> Any:
    return np.tile(np.array(values, dtype), (HEIGHT, WIDTH))


@pytest.mark.parametrize(
    ("encoding", "values"),
    [("rgb8", RED), ("bgr8", RED[::-1]), ("rgba8", (*RED, 9)), ("bgra8", (*RED[::-1], 9)), ("8UC3", RED[::-1])],
)
@pytest.mark.parametrize("pad", [0, 7])
def test_colors(encoding: str, values: tuple[int, ...], pad: int) -> None:
    assert shown(image(encoding, of_one(*values), pad=pad)) == pytest.approx(RED, abs=4)


@pytest.mark.parametrize(
    ("encoding", "rows", "gray"),
    [
        ("mono8", of_one(99), 99),
        ("mono16", of_one(99 << 8, dtype="<u2"), 99),
        ("16UC1", of_one(5000, dtype="<u2"), 127),  # 5 m, half of what is shown
        ("16UC1", of_one(0, dtype="<u2"), 0),
        ("32FC1", of_one(5, dtype="<f4"), 127),
        ("32FC1", of_one(1, dtype="<f4") * np.float32("nan"), 0),
    ],
)
def test_shades(encoding: str, rows: Any, gray: int) -> None:
    assert shown(image(encoding, rows)) == pytest.approx((gray,) * 3, abs=2)


def test_the_byte_order_counts() -> None:
    assert shown(image("mono16", of_one(99 << 8, dtype=">u2"), big=True)) == pytest.approx((99,) * 3, abs=2)


@pytest.mark.parametrize(
    ("encoding", "pair"), [("yuv422", (85, 82, 255, 82)), ("uyvy", (85, 82, 255, 82)), ("yuyv", (82, 85, 82, 255))]
)
def test_yuv(encoding: str, pair: tuple[int, ...]) -> None:
    red, green, blue = shown(image(encoding, np.tile(np.array(pair, "u1"), (HEIGHT, WIDTH // 2))))
    assert (red > 220, max(green, blue) < 60) == (True, True)


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_bayer_is_shown_at_half_the_size(pattern: str) -> None:
    values = {"r": 200, "g": 60, "b": 20}
    cell = np.array([values[color] for color in pattern], "u1").reshape(2, 2)
    message = image(f"bayer_{pattern}8", np.tile(cell, (HEIGHT // 2, WIDTH // 2)))
    assert encode(message, 95)[1:] == (WIDTH // 2, HEIGHT // 2)
    assert shown(message) == pytest.approx((200, 60, 20), abs=4)


def test_the_last_row_may_lack_its_padding() -> None:
    message = image("rgb8", of_one(*RED), pad=8)
    message.data = message.data[:-8]
    assert shown(message) == pytest.approx(RED, abs=4)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"encoding": "lidar"}, "the encoding 'lidar' is not shown; shown are rgb8"),
        ({"step": 95}, "32 x 16 pixels of rgb8 do not fit step 95 and 1536 bytes"),
        ({"data": b"few"}, "do not fit step 96 and 3 bytes"),
        ({"height": 4_000_000_000}, "do not fit"),
        ({"encoding": "mono8", "width": 70_000, "height": 1, "step": 70_000, "data": bytes(70_000)}, "65500"),
    ],
)
def test_what_does_not_fit_is_refused(change: dict[str, Any], words: str) -> None:
    message = image("rgb8", of_one(*RED))
    vars(message).update(change)
    with pytest.raises(Unreadable, match=words):
        encode(message, 75)


def test_a_step_that_no_row_follows_takes_no_memory() -> None:
    message = image("mono8", of_one(99)[:1])
    message.step = 2**45
    assert encode(message, 75)[1:] == (WIDTH, 1)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("size", [(1, 1), (3, 3)])
def test_no_size_is_too_small_or_odd(encoding: str, size: tuple[int, int]) -> None:
    """They are encoded or refused; nothing else is raised."""
    width, height = size
    rows = np.zeros((height, width * ENCODINGS[encoding][0]), "u1")
    with suppress(Unreadable):
        assert encode(image(encoding, rows, width=width), 75)[0].startswith(b"\xff\xd8")
