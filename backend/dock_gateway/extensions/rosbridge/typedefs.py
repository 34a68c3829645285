"""The definitions of ROS types, as `/rosapi` returns them."""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from dock_gateway.ros.messages.full_definition import full_definition, nested_classes, short_name
from dock_gateway.ros.messages.interfaces import full_type, load_message, load_service
from dock_gateway.ros.messages.types import (
    Boolean,
    Float,
    Integer,
    Kind,
    MessageClass,
    Nested,
    Sequence,
    Text,
    kinds,
)

Json = dict[str, Any]

# Definitions that are kept: looking for a type costs milliseconds.
KEEP = 1000


@lru_cache(KEEP)
def message_definitions(name: str) -> list[Json]:
    """Return the definition of a message type and of the types in it.

    Raises:
        ImportError: There is no such type here.
    """
    return list(_definitions(load_message(full_type(name))))


@lru_cache(KEEP)
def service_definitions(name: str, part: str) -> list[Json]:
    """Return the definition of a service's `Request` or `Response`, and of the types in it.

    Raises:
        ImportError: There is no such type here.
    """
    return list(_definitions(getattr(load_service(full_type(name, "srv")), part)))


def definition_texts(name: str) -> str:
    """Return the text of a message definition, and those of the types in it; empty if there is none here."""
    try:
        return full_definition(load_message(full_type(name)))
    except (ImportError, TypeError):
        return ""


def _definitions(message_class: MessageClass) -> Iterator[Json]:
    for each in nested_classes(message_class):
        fields = kinds(each)
        constants = _constants(each)
        yield {
            "type": short_name(each),
            "fieldnames": list(fields),
            "fieldtypes": [_name(kind) for kind in fields.values()],
            "fieldarraylen": [_length(kind) for kind in fields.values()],
            "examples": [_example(kind) for kind in fields.values()],
            "constnames": list(constants),
            "constvalues": [str(value) for value in constants.values()],
        }


def _constants(message_class: MessageClass) -> Json:
    # rosidl makes each constant a property of the metaclass, and each default a property NAME__DEFAULT.
    properties = (name for name, member in vars(type(message_class)).items() if isinstance(member, property))
    return {name: getattr(message_class, name) for name in properties if not name.endswith("__DEFAULT")}


def _name(kind: Kind) -> str:
    match kind:
        case Boolean():
            return "boolean"
        case Integer(typename):
            return typename
        case Float(single):
            return "float" if single else "double"
        case Text():
            return "string"
        case Sequence(item):
            return _name(item)
        case Nested(message_class):
            return short_name(message_class)


def _length(kind: Kind) -> int:
    """Return the length of an array, 0 if it varies, -1 if it is none."""
    if not isinstance(kind, Sequence):
        return -1
    return kind.low if kind.fixed else 0


def _example(kind: Kind) -> str:
    match kind:
        case Sequence():
            return "[]"
        case Nested():
            return "{}"
        case Boolean():
            return "False"
        case Text():
            return ""
        case Float():
            return "0.0"
        case _:
            return "0"
