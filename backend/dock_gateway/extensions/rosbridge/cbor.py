"""Encodes plain data as CBOR (RFC 8949), with numbers of one type as typed arrays (RFC 8746)."""

import struct
from typing import Any, NamedTuple

_UNSIGNED, _NEGATIVE, _BYTES, _TEXT, _ARRAY, _MAP, _TAG = range(7)
_SIZES = ((24, 1, ">B"), (25, 2, ">H"), (26, 4, ">I"), (27, 8, ">Q"))

# Tags of little-endian typed arrays, by the type code of Python's `array`.
TYPED = {"H": 69, "I": 70, "Q": 71, "b": 72, "h": 77, "i": 78, "q": 79, "f": 85, "d": 86}


class Tagged(NamedTuple):
    """Bytes with a tag."""

    tag: int
    data: bytes


def encode(value: Any) -> bytes:
    """Encode objects, arrays, texts, bytes, numbers, booleans, null and tagged bytes.

    Raises:
        TypeError: It is something else.
    """
    out = bytearray()
    _write(out, value)
    return bytes(out)


def _write(out: bytearray, value: Any) -> None:
    match value:
        case bool() | None:
            out.append({False: 0xF4, True: 0xF5, None: 0xF6}[value])
        case int():
            _head(out, _UNSIGNED if value >= 0 else _NEGATIVE, value if value >= 0 else -1 - value)
        case float():
            out += b"\xfb" + struct.pack(">d", value)
        case str():
            _write_bytes(out, _TEXT, value.encode(errors="replace"))
        case bytes():
            _write_bytes(out, _BYTES, value)
        case Tagged(tag, data):
            _head(out, _TAG, tag)
            _write_bytes(out, _BYTES, data)
        case dict() | list():
            _write_items(out, value)
        case _:
            raise TypeError(f"{type(value).__name__} has no CBOR")


def _write_bytes(out: bytearray, major: int, data: bytes) -> None:
    _head(out, major, len(data))
    out += data


def _write_items(out: bytearray, items: dict[str, Any] | list[Any]) -> None:
    if isinstance(items, dict):
        _head(out, _MAP, len(items))
        for name, item in items.items():
            _write(out, name)
            _write(out, item)
    else:
        _head(out, _ARRAY, len(items))
        for item in items:
            _write(out, item)


def _head(out: bytearray, major: int, number: int) -> None:
    if number < 24:
        out.append(major << 5 | number)
        return
    for code, size, layout in _SIZES:
        if number < 1 << 8 * size:
            out.append(major << 5 | code)
            out += struct.pack(layout, number)
            return
