"""ROS messages to JSON and back, made from the message's own fields and types.

A codec is compiled once for each message class. Towards JSON a float32 is written as its shortest text, NaN and
±Infinity as null. From JSON a codec takes partial messages and says everything that is wrong, each with its dotted
path.
"""

import importlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from rosidl_parser.definition import (
    AbstractGenericString,
    AbstractNestedType,
    AbstractType,
    Array,
    BasicType,
    BoundedSequence,
    NamespacedType,
)

from dock_gateway.errors import FieldError, InvalidField
from dock_gateway.goals import Json, encode

MAX_STRING = 65_536
MAX_SEQUENCE = 10_000
MAX_ERRORS = 20
FLOAT32_MAX = float(np.finfo(np.float32).max)

# Messages whose own definition asks for NaN where a value was not measured.
UNSET_FLOATS_ARE_NAN = frozenset({("sensor_msgs", "msg", "BatteryState")})

Encoder = Callable[[Any], Any]
Parser = Callable[[Any, str, list[FieldError]], Any]
Schema = dict[str, Any]


def load_action(type_name: str) -> Any:
    """The Python class of an action type such as `action_tutorials_interfaces/action/Fibonacci`.

    Raises:
        ImportError: The package is not installed, or has no such action.
    """
    package, _, name = type_name.partition("/action/")
    if not (package.isidentifier() and name.isidentifier()):
        raise ImportError(f"{type_name!r} is not an action type such as package/action/Name")
    try:
        return getattr(importlib.import_module(f"{package}.action"), name)
    except AttributeError:
        raise ImportError(f"the package {package} has no action {name}") from None


@cache
def codec(message_class: type[Any]) -> "MessageCodec":
    """The codec of a message class, compiled at the first call."""
    return MessageCodec(message_class)


class MessageCodec:
    """Converts the messages of one class."""

    def __init__(self, message_class: type[Any]) -> None:
        self._class = message_class
        self._fields: dict[str, _Field] = {
            name: _compile(slot_type)
            for name, slot_type in zip(
                message_class.get_fields_and_field_types(), message_class.SLOT_TYPES, strict=True
            )
        }
        module = message_class.__module__.split(".")
        self.unset_is_nan = (module[0], module[1], message_class.__name__) in UNSET_FLOATS_ARE_NAN
        self._floats = [
            name for name, slot in zip(self._fields, message_class.SLOT_TYPES, strict=True) if _is_float(slot)
        ]
        self._defaults = [(name, field.default) for name, field in self._fields.items() if field.default]
        self._encoders = [(name, field.encode) for name, field in self._fields.items()]

    def document(self, message: Any) -> dict[str, Any]:
        """The message as plain data, ready for `orjson`."""
        return {name: encoder(getattr(message, name)) for name, encoder in self._encoders}

    def encode(self, message: Any) -> Json:
        """The message as JSON text."""
        return encode(self.document(message))

    def parse(self, value: object, path: str = "") -> Any:
        """A message out of decoded JSON; what is left out keeps its default, NaN where the message asks for it.

        Raises:
            InvalidField: With everything that is wrong, up to a limit.
        """
        errors: list[FieldError] = []
        message = self.parse_into(value, path, errors)
        if errors:
            raise InvalidField(errors[:MAX_ERRORS])
        return message

    def parse_into(self, value: object, path: str, errors: list[FieldError]) -> Any:
        """Like `parse`, but what is wrong is appended to `errors`."""
        message = self.default()
        if not isinstance(value, Mapping):
            errors.append(_wrong(path, f"an object ({self._class.__name__})", value))
            return message
        for name, item in value.items():
            item_path = f"{path}.{name}" if path else str(name)
            field = self._fields.get(name)
            if field is None:
                errors.append(FieldError(item_path[:200], f"one of {', '.join(self._fields)}", "got an unknown field"))
            else:
                before = len(errors)
                parsed = field.parse(item, item_path, errors)
                if len(errors) == before:
                    setattr(message, name, parsed)
            if len(errors) >= MAX_ERRORS:
                break
        return message

    def default(self) -> Any:
        """A message with nothing set: NaN where the message asks for it."""
        message = self._class()
        for name, make in self._defaults:
            setattr(message, name, make())
        if self.unset_is_nan:
            for name in self._floats:
                setattr(message, name, math.nan)
        return message

    @property
    def has_default(self) -> bool:
        """Whether `default` differs from what the class makes by itself."""
        return self.unset_is_nan or bool(self._defaults)

    def schema(self, *, complete: bool = False) -> Schema:
        """JSON Schema of the message: as `parse` takes it, or, `complete`, as `encode` writes it."""
        return {
            "type": "object",
            "title": self._class.__name__,
            "additionalProperties": False,
            "properties": {name: field.schema(complete) for name, field in self._fields.items()},
            **({"required": list(self._fields)} if complete else {}),
        }


@dataclass(frozen=True)
class _Field:
    """How one type is encoded, parsed and described; `default` where the message's own default is not ours."""

    encode: Encoder
    parse: Parser
    schema: Callable[[bool], Schema]
    default: Callable[[], Any] | None = None


def _is_float(slot: AbstractType) -> bool:
    return isinstance(slot, BasicType) and slot.typename in ("float", "double")


def _compile(slot: AbstractType) -> _Field:
    if isinstance(slot, BasicType):
        return _basic(slot.typename)
    if isinstance(slot, AbstractGenericString):
        return _string(slot.maximum_size if slot.has_maximum_size() else MAX_STRING)
    if isinstance(slot, AbstractNestedType):
        return _sequence(slot)
    if isinstance(slot, NamespacedType):
        nested = codec(getattr(importlib.import_module(".".join(slot.namespaces)), slot.name))
        return _Field(
            nested.document,
            nested.parse_into,
            lambda complete: nested.schema(complete=complete),
            nested.default if nested.has_default else None,
        )
    raise TypeError(f"fields of type {slot} are not supported")


def _basic(typename: str) -> _Field:
    if typename in ("float", "double"):
        return _float(typename)
    if typename == "boolean":
        return _Field(_same, _parse_boolean, lambda _: {"type": "boolean"})
    if typename == "octet":
        integer = _integer("octet", 0, 255)

        def parse_octet(value: Any, path: str, errors: list[FieldError]) -> Any:
            number = integer.parse(value, path, errors)
            return None if number is None else bytes([number])

        return _Field(lambda value: value[0], parse_octet, integer.schema)
    bits = int(typename.removeprefix("u").removeprefix("int"))
    low, high = (0, 2**bits - 1) if typename.startswith("u") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    return _integer(typename, low, high)


def _same(value: Any) -> Any:
    return value


def _wrong(path: str, expected: str, value: object) -> FieldError:
    names = {dict: "an object", list: "an array", str: "a string", bool: "a boolean", type(None): "null"}
    if isinstance(value, int | float) and not isinstance(value, bool):
        got = f"got {value!r:.40}"
    else:
        got = f"got {names.get(type(value), type(value).__name__)}"
    return FieldError(path[:200], expected, got)


def _parse_boolean(value: Any, path: str, errors: list[FieldError]) -> Any:
    if not isinstance(value, bool):
        errors.append(_wrong(path, "a boolean", value))
    return value


def _integer(typename: str, low: int, high: int) -> _Field:
    expected = f"{typename} ({low} to {high})"

    def parse(value: Any, path: str, errors: list[FieldError]) -> Any:
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            errors.append(_wrong(path, expected, value))
            return None
        return value

    return _Field(_same, parse, lambda _: {"type": "integer", "minimum": low, "maximum": high})


def _float(typename: str) -> _Field:
    single = typename == "float"
    limit = FLOAT32_MAX if single else math.inf
    expected = "float32 (-3.4e38 to 3.4e38) or null" if single else "float64 or null"

    def parse(value: Any, path: str, errors: list[FieldError]) -> Any:
        if value is None:
            return math.nan
        if not isinstance(value, int | float) or isinstance(value, bool) or abs(value) > limit:
            errors.append(_wrong(path, expected, value))
            return None
        return float(value)

    return _Field(
        np.float32 if single else _same,
        parse,
        lambda _: {"type": ["number", "null"], **({"minimum": -limit, "maximum": limit} if single else {})},
    )


def _string(maximum: int) -> _Field:
    def parse(value: Any, path: str, errors: list[FieldError]) -> Any:
        if not isinstance(value, str):
            errors.append(_wrong(path, "a string", value))
        elif len(value) > maximum:
            errors.append(FieldError(path, f"a string of at most {maximum} characters", f"got {len(value)}"))
        elif "\0" in value:
            errors.append(FieldError(path, "a string without NUL characters", "got one"))
        return value

    return _Field(_same, parse, lambda _: {"type": "string", "maxLength": maximum})


def _sequence(slot: AbstractNestedType) -> _Field:
    item = _compile(slot.value_type)
    if isinstance(slot, Array):
        low, high = slot.size, slot.size
    else:
        low, high = 0, slot.maximum_size if isinstance(slot, BoundedSequence) else MAX_SEQUENCE
    expected = f"an array of {low} items" if low else f"an array of at most {high} items"

    def parse(value: Any, path: str, errors: list[FieldError]) -> Any:
        if not isinstance(value, list):
            errors.append(_wrong(path, expected, value))
            return None
        if not low <= len(value) <= high:
            errors.append(FieldError(path, expected, f"got {len(value)}"))
            return None
        parsed = []
        for index, entry in enumerate(value):
            parsed.append(item.parse(entry, f"{path}.{index}", errors))
            if len(errors) >= MAX_ERRORS:
                break
        return parsed

    # Numbers come as array.array or numpy arrays, which orjson writes whole.
    numeric = isinstance(slot.value_type, BasicType) and slot.value_type.typename not in ("boolean", "octet")
    encode_items: Encoder = np.asarray if numeric else lambda values: [item.encode(value) for value in values]
    return _Field(
        encode_items,
        parse,
        lambda complete: {"type": "array", "items": item.schema(complete), "minItems": low, "maxItems": high},
    )
