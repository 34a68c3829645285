"""Converts one field of a ROS message to JSON and back.

An integer beyond ±(2^53 - 1) is encoded as a decimal string, because most JSON readers keep numbers as doubles
(RFC 8259, section 6). The parser accepts 64-bit integers in both forms, bytes as numbers or as base64, and integers
with constants by name.
"""

import array
import binascii
import math
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from dock_gateway.core.errors import FieldError
from dock_gateway.core.json_text import Infinite
from dock_gateway.ros.messages.bounds import Errors, weight_of_item
from dock_gateway.ros.messages.constants import Constant
from dock_gateway.ros.messages.types import Boolean, Float, Integer, Kind, MessageClass, Nested, Sequence, Text

# Limits (characters, items, bytes) of parsed values without a bound in the definition. Messages from ROS may be longer.
MAX_STRING = 65_536
MAX_SEQUENCE = 10_000
MAX_BYTES = 1_000_000
MAX_ERRORS = 20
MAX_SAFE = 2**53 - 1
FEW = 32
FLOAT32_MAX = 3.4028235e38  # its shortest text, slightly more than the exact value
DECIMAL = r"-?(0|[1-9][0-9]{0,19})"

Encoder = Callable[[Any], Any]
Parser = Callable[[Any, str, Errors], Any]
Names = tuple[Constant, ...]


class NestedCodec(Protocol):
    """The part of a nested message's codec that a field needs."""

    @property
    def document(self) -> Encoder:
        """Converts a message to plain data."""

    def parse_into(self, value: object, path: str, errors: Errors) -> Any:
        """Build a message from decoded JSON; append the errors to `errors`."""

    def default(self) -> Any:
        """Return a message with nothing set."""

    @property
    def has_default(self) -> bool:
        """Whether `default` differs from a new instance of the class."""


@dataclass(frozen=True)
class Field:
    """A compiled field.

    Attributes:
        encode: Converts a value for JSON; None if `orjson` accepts the value as it is.
        parse: Converts decoded JSON; appends errors to the list, and its result is then meaningless.
        default: Makes the value of a missing field; None to use the message's own default.
    """

    encode: Encoder | None
    parse: Parser
    default: Callable[[], Any] | None = None


def compile_field(kind: Kind, constants: Names, nested: Callable[[MessageClass], NestedCodec]) -> Field:
    """Compile a field.

    Args:
        kind: Type of the field.
        constants: The constants that may be given by name.
        nested: Returns the codec of a nested message.
    """
    match kind:
        case Boolean():
            return Field(None, _parse_boolean)
        case Integer():
            return _integer(kind, constants)
        case Float():
            return _float(kind)
        case Text():
            return Field(None, _text(kind.maximum or MAX_STRING))
        case Sequence():
            item = compile_field(kind.item, constants, nested)
            return Field(_sequence_encoder(kind, item.encode), _sequence_parser(kind, item.parse))
        case Nested():
            other = nested(kind.message_class)
            return Field(other.document, other.parse_into, other.default if other.has_default else None)


def wrong(path: str, expected: str, value: object) -> FieldError:
    """Return the error of a value of the wrong type."""
    names = {dict: "an object", list: "an array", str: "a string", bool: "a boolean", type(None): "null"}
    if isinstance(value, int | float) and not isinstance(value, bool):
        got = f"got {value!r:.40}"
    else:
        got = f"got {names.get(type(value), type(value).__name__)}"
    return FieldError(path[:200], expected, got)


def _parse_boolean(value: Any, path: str, errors: Errors) -> Any:
    if not isinstance(value, bool):
        errors.append(wrong(path, "a boolean", value))
    return value


def _integer(kind: Integer, constants: Names) -> Field:
    low, high, wide, octet = kind.low, kind.high, kind.wide, kind.octet
    values: Mapping[str, int] = {constant.name.upper(): constant.value for constant in constants} | {
        constant.full_name.upper(): constant.value for constant in constants
    }
    expected = f"{kind.typename} ({low} to {high}{', as a number or a decimal string' if wide else ''})"
    if constants:
        expected += f" or one of {', '.join(constant.name for constant in constants)}"

    def parse(value: Any, path: str, errors: Errors) -> Any:
        number = value
        if isinstance(value, str):
            number = values.get(value.upper())
            if number is None and wide and re.fullmatch(DECIMAL, value):
                number = int(value)
        elif isinstance(value, float) and value.is_integer():  # 1.0 is an integer in JSON Schema and in JavaScript
            number = int(value)
        if not isinstance(number, int) or isinstance(number, bool) or not low <= number <= high:
            error = wrong(path, expected, value)
            if isinstance(value, str) and (constants or wide):
                error = FieldError(error.path, expected, f"got {value[:40]!r}")
            errors.append(error)
            return None
        return bytes([number]) if octet else number

    return Field(_first_byte if octet else _safe if wide else None, parse)


def _first_byte(value: bytes) -> int:
    return value[0]


def _safe(value: int) -> int | str:
    return value if -MAX_SAFE <= value <= MAX_SAFE else str(value)


def _float(kind: Float) -> Field:
    limit = FLOAT32_MAX if kind.single else sys.float_info.max
    expected = "float32 (-3.4e38 to 3.4e38) or null" if kind.single else "float64 or null"

    def parse(value: Any, path: str, errors: Errors) -> Any:
        if value is None:
            return math.nan
        if isinstance(value, Infinite):
            return float(value)
        if not isinstance(value, int | float) or isinstance(value, bool) or abs(value) > limit:
            errors.append(wrong(path, expected, value))
            return None
        return float(value)

    return Field(np.float32 if kind.single else None, parse)


def _text(maximum: int) -> Parser:
    def parse(value: Any, path: str, errors: Errors) -> Any:
        if not isinstance(value, str):
            errors.append(wrong(path, "a string", value))
        elif len(value) > maximum:
            errors.append(FieldError(path, f"a string of at most {maximum} characters", f"got {len(value)}"))
        elif "\0" in value:
            errors.append(FieldError(path, "a string without NUL characters", "got one"))
        return value

    return parse


def limit_of(kind: Sequence) -> int:
    """Return the maximum number of items that are accepted."""
    if kind.high is not None:
        return kind.high
    return MAX_BYTES if kind.binary else MAX_SEQUENCE


def _sequence_encoder(kind: Sequence, item: Encoder | None) -> Encoder | None:
    if isinstance(kind.item, Integer) and kind.item.wide:
        return _encode_wide
    if kind.code:
        return _encode_floats32 if kind.code == "f" else _encode_numbers
    if isinstance(kind.item, Integer):
        return _encode_octets
    return (lambda values: [item(value) for value in values]) if item else None


def _encode_numbers(values: Any) -> Any:
    # orjson writes whole numpy arrays; for a few numbers, creating one costs more than it saves.
    return values.tolist() if len(values) < FEW else np.asarray(values)


def _encode_floats32(values: Any) -> Any:
    return np.asarray(values) if len(values) else []


def _encode_wide(values: Any) -> Any:
    if len(values) < FEW:
        return [_safe(number) for number in values.tolist()]
    numbers = np.asarray(values)
    if numbers.max() <= MAX_SAFE and numbers.min() >= -MAX_SAFE:
        return numbers
    return [_safe(number) for number in numbers.tolist()]


def _encode_octets(values: Any) -> list[int]:
    return list(b"".join(values))


def _sequence_parser(kind: Sequence, item: Parser) -> Parser:
    low, high = kind.low, limit_of(kind)
    expected = f"an array of {low} items" if kind.fixed else f"an array of at most {high} items"
    if kind.binary:
        expected += ", or base64"
    pack, whole, weight = _packer(kind), _whole(kind), weight_of_item(kind)

    def parse(value: Any, path: str, errors: Errors) -> Any:
        if kind.binary and isinstance(value, str):
            value = _decode(value, path, expected, errors)
            if value is None:
                return None
        elif not isinstance(value, list):
            errors.append(wrong(path, expected, value))
            return None
        if not low <= len(value) <= high:
            errors.append(FieldError(path[:200], expected, f"got {len(value)}"))
            return None
        errors.take(int(len(value) * weight))
        done = whole(value)
        if done is not None:
            return done
        parsed, before = [], len(errors)
        for index, entry in enumerate(value):
            parsed.append(item(entry, f"{path}.{index}", errors))
            if len(errors) >= MAX_ERRORS:
                break
        return None if len(errors) > before else pack(parsed)

    return parse


def _decode(text: str, path: str, expected: str, errors: Errors) -> list[int] | None:
    try:
        return list(binascii.a2b_base64(text.encode("ascii"), strict_mode=True))
    except (binascii.Error, UnicodeEncodeError) as error:
        errors.append(FieldError(path[:200], expected, f"got a string that is not base64 ({str(error)[:60]})"))
        return None


def _packer(kind: Sequence) -> Encoder:
    """Return a function that packs items into the container of the Python class."""
    code = kind.code
    if code is None:
        return list
    if kind.fixed:
        return lambda values: np.asarray(array.array(code, values))
    return lambda values: array.array(code, values)


def _whole(kind: Sequence) -> Encoder:
    """Return a function that packs a list of plain numbers at once, or returns None to parse item by item."""
    pack = _packer(kind)
    if isinstance(kind.item, Integer) and kind.code:

        def integers(values: list[Any]) -> Any:
            try:
                return pack(values) if set(map(type, values)) <= {int} else None
            except OverflowError:
                return None

        return integers
    if isinstance(kind.item, Float):
        limit = FLOAT32_MAX if kind.item.single else sys.float_info.max

        def floats(values: list[Any]) -> Any:
            if not set(map(type, values)) <= {int, float}:
                return None
            return pack(values) if max(map(abs, values), default=0) <= limit else None

        return floats
    return lambda _: None
