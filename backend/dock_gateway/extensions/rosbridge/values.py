"""ROS messages as rosbridge writes them.

In JSON, arrays of uint8 are base64, 64-bit integers are numbers, NaN and ±Infinity are null. In CBOR, arrays of uint8
are bytes and other arrays of numbers are typed arrays.
"""

from base64 import b64encode
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from cbor2 import CBORTag

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.rosbridge.protocol import stamp
from dock_gateway.ros.messages.types import Integer, Kind, MessageClass, Nested, Sequence, kinds, type_name

Encoder = Callable[[Any], Any]
TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
# Tags of little-endian typed arrays in CBOR (RFC 8746), by the type code of Python's `array`.
TYPED = {"H": 69, "I": 70, "Q": 71, "b": 72, "h": 77, "i": 78, "q": 79, "f": 85, "d": 86}
# For fewer numbers, a numpy array costs more than it saves.
FEW = 32


class Style(NamedTuple):
    """The way in which arrays are written: those of bytes, and those of other numbers, with their type code."""

    octets: Callable[[bytes], Any]
    numbers: Callable[[Any, str], Any]


def json_values(message: Any) -> Any:
    """Return a message as plain data for `orjson`."""
    message_class: MessageClass = type(message)
    return _document(message_class, JSON)(message)


def cbor_values(message: Any) -> Any:
    """Return a message as plain data for CBOR."""
    message_class: MessageClass = type(message)
    return _document(message_class, CBOR)(message)


def _base64(octets: bytes) -> str:
    return b64encode(octets).decode()


def _plain(numbers: Any, code: str) -> Any:
    if len(numbers) < FEW:
        return numbers.tolist()
    return np.asarray(numbers, np.float64) if code == "f" else np.asarray(numbers)


def _typed(numbers: Any, code: str) -> Any:
    return CBORTag(TYPED[code], numbers.tobytes())


JSON, CBOR = Style(_base64, _plain), Style(lambda octets: octets, _typed)


@cache
def _document(message_class: MessageClass, style: Style) -> Encoder:
    fields = [(name, _encoder(kind, style)) for name, kind in kinds(message_class).items()]

    def encode(message: Any) -> dict[str, Any]:
        values = ((name, getattr(message, name), encoder) for name, encoder in fields)
        return {name: encoder(value) if encoder else value for name, value, encoder in values}

    return encode


def _encoder(kind: Kind, style: Style) -> Encoder | None:
    """Return what converts a value; None if it stays as it is."""
    match kind:
        case Integer(octet=True):
            return lambda value: value[0]
        case Nested(message_class):
            return _document(message_class, style)
        case Sequence():
            return _array_encoder(kind, style)
        case _:
            return None


def _array_encoder(kind: Sequence, style: Style) -> Encoder | None:
    code = kind.code
    if kind.binary:
        return (lambda values: style.octets(bytes(values))) if code else lambda values: style.octets(b"".join(values))
    if code:
        return lambda values: style.numbers(values, code)
    encode = _encoder(kind.item, style)
    return None if encode is None else lambda values: [encode(value) for value in values]


@cache
def adapter(message_class: MessageClass) -> Encoder | None:
    """Return what converts a message from the JSON of the gateway to that of rosbridge; None if both are the same."""
    fields = {name: adapt for name, kind in kinds(message_class).items() if (adapt := _adapt(kind)) is not None}
    if not fields:
        return None

    def convert(document: dict[str, Any]) -> dict[str, Any]:
        return {name: fields[name](value) if name in fields else value for name, value in document.items()}

    return convert


def _adapt(kind: Kind) -> Encoder | None:
    match kind:
        case Integer(wide=True):
            return int
        case Nested(message_class):
            return adapter(message_class)
        case Sequence(binary=True):
            return lambda numbers: _base64(bytes(numbers))
        case Sequence(item=item):
            adapt = _adapt(item)
            return None if adapt is None else lambda values: [adapt(value) for value in values]
        case _:
            return None


@cache
def reader(message_class: MessageClass) -> Encoder | None:
    """Return what converts a message of a client to what the gateway reads; None if both are the same.

    Times may have the field names of ROS 1, or be `"now"`. What is no such message is left as it is.
    """
    if type_name(message_class) in TIMES:
        return _read_time
    fields = {name: read for name, kind in kinds(message_class).items() if (read := _reader(kind)) is not None}
    if not fields:
        return None

    def convert(value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        return {name: fields[name](item) if name in fields else item for name, item in value.items()}

    return convert


def _reader(kind: Kind) -> Encoder | None:
    if isinstance(kind, Nested):
        return reader(kind.message_class)
    if not isinstance(kind, Sequence) or (read := _reader(kind.item)) is None:
        return None
    return lambda value: [read(item) for item in value] if isinstance(value, list) else value


def _read_time(value: Any) -> Any:
    if value == "now":
        return stamp(utc_now())
    if isinstance(value, dict) and value.keys() == {"secs", "nsecs"}:
        return {"sec": value["secs"], "nanosec": value["nsecs"]}
    return value
