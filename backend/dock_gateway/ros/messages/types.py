"""The kinds of fields that a ROS message can have, read from its class."""

import importlib
from dataclasses import dataclass
from typing import Any

from rosidl_parser.definition import (
    AbstractGenericString,
    AbstractNestedType,
    AbstractType,
    Array,
    BasicType,
    BoundedSequence,
    NamespacedType,
)

# A class that rosidl made; nothing more is known to a type checker.
MessageClass = Any

# What the Python classes keep sequences of numbers in.
ARRAY_CODES = {
    "float": "f",
    "double": "d",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
}

# Messages whose own definition asks for NaN where a value was not measured.
UNSET_FLOATS_ARE_NAN = frozenset({"sensor_msgs/msg/BatteryState"})


@dataclass(frozen=True)
class Boolean:
    """True or false."""


@dataclass(frozen=True)
class Integer:
    """A whole number; `octet` is what a .msg calls `byte`, and a `bytes` of length 1 in Python."""

    typename: str
    low: int
    high: int

    @property
    def wide(self) -> bool:
        """Whether it has 64 bits: more than a JSON number is sure to carry."""
        return self.high >= 2**53

    @property
    def octet(self) -> bool:
        """Whether it is a `bytes` in Python."""
        return self.typename == "octet"


@dataclass(frozen=True)
class Float:
    """A float32 (`single`) or a float64."""

    single: bool


@dataclass(frozen=True)
class Text:
    """A string or wstring; `maximum` in characters where the definition has one."""

    maximum: int | None = None


@dataclass(frozen=True)
class Sequence:
    """A fixed array (`low` equals `high`) or a sequence; `high` is None where the definition has no bound.

    `code` is that of `array.array` where the items are numbers that Python keeps in one, or in a numpy array of the
    same type (fixed arrays).
    """

    item: "Kind"
    low: int
    high: int | None
    code: str | None

    @property
    def fixed(self) -> bool:
        """Whether the length never changes."""
        return self.low == self.high

    @property
    def binary(self) -> bool:
        """Whether it holds bytes: uint8, char or byte."""
        return isinstance(self.item, Integer) and (self.item.typename in ("uint8", "octet"))


@dataclass(frozen=True)
class Nested:
    """Another message."""

    message_class: MessageClass


Kind = Boolean | Integer | Float | Text | Sequence | Nested


def kinds(message_class: MessageClass) -> dict[str, Kind]:
    """The fields of a message class.

    Raises:
        TypeError: A field is of a type that no .msg file can have.
    """
    names = message_class.get_fields_and_field_types()
    return {name: _kind(slot) for name, slot in zip(names, message_class.SLOT_TYPES, strict=True)}


def type_name(message_class: MessageClass) -> str:
    """Such as `sensor_msgs/msg/BatteryState`; of an action's parts, `package/action/Name_Goal`."""
    package, kind, *_ = message_class.__module__.split(".")
    return f"{package}/{kind}/{message_class.__name__}"


def unset_is_nan(message_class: MessageClass) -> bool:
    """Whether floats that nobody set are NaN."""
    return type_name(message_class) in UNSET_FLOATS_ARE_NAN


def _kind(slot: AbstractType) -> Kind:
    if isinstance(slot, BasicType):
        return _basic(slot.typename)
    if isinstance(slot, AbstractGenericString):
        return Text(slot.maximum_size if slot.has_maximum_size() else None)
    if isinstance(slot, AbstractNestedType):
        return _sequence(slot)
    if isinstance(slot, NamespacedType):
        return Nested(_find_class(slot))
    raise TypeError(f"fields of type {slot} are not supported")


def _find_class(slot: NamespacedType) -> MessageClass:
    module = importlib.import_module(".".join(slot.namespaces))
    found = getattr(module, slot.name, None)
    if found is None:  # the parts of an action: `Fibonacci_Feedback` is at `Fibonacci.Feedback`
        action, _, part = slot.name.rpartition("_")
        found = getattr(getattr(module, action), part)
    return found


def _sequence(slot: AbstractNestedType) -> Sequence:
    value = slot.value_type
    code = ARRAY_CODES.get(value.typename) if isinstance(value, BasicType) else None
    if isinstance(slot, Array):
        return Sequence(_kind(value), slot.size, slot.size, code)
    return Sequence(_kind(value), 0, slot.maximum_size if isinstance(slot, BoundedSequence) else None, code)


def _basic(typename: str) -> Kind:
    if typename == "boolean":
        return Boolean()
    if typename in ("float", "double"):
        return Float(single=typename == "float")
    if typename == "octet":
        return Integer("octet", 0, 255)
    if typename not in ARRAY_CODES:
        raise TypeError(f"fields of type {typename} are not supported")
    bits = int(typename.removeprefix("u").removeprefix("int"))
    if typename.startswith("u"):
        return Integer(typename, 0, 2**bits - 1)
    return Integer(typename, -(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
