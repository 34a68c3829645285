"""The definitions of ROS types, as `/rosapi` returns them."""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from dock_gateway.ros.messages.interfaces import definition_text, load_message, load_service
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
    type_name,
)
from dock_gateway.rosbridge.protocol import full_type

Json = dict[str, Any]

SEPARATOR = "=" * 80
# Definitions that are kept: looking for a type costs milliseconds.
KEEP = 1000


@lru_cache(KEEP)
def message_definitions(name: str) -> list[Json]:
    """Return the definition of a message type and of the types in it.

    Raises:
        ImportError: There is no such type here.
    """
    return list(_definitions(load_message(full_type(name)), set()))


@lru_cache(KEEP)
def service_definitions(name: str, part: str) -> list[Json]:
    """Return the definition of a service's `Request` or `Response`, and of the types in it.

    Raises:
        ImportError: There is no such type here.
    """
    return list(_definitions(getattr(load_service(full_type(name, "srv")), part), set()))


def definition_texts(name: str) -> str:
    """Return the text of a message definition, and those of the types in it; empty if there is none here."""
    try:
        return _texts(full_type(name))
    except (ImportError, TypeError):
        return ""


@lru_cache(KEEP)
def _texts(name: str) -> str:
    classes = [message_class for message_class, _ in _classes(load_message(name), set())]
    texts = []
    for index, message_class in enumerate(classes):
        package, kind, short = type_name(message_class).split("/")
        head = f"{SEPARATOR}\nMSG: {package}/{short}\n" if index else ""
        texts.append(head + (definition_text(package, kind, short) or ""))
    return "\n".join(texts)


def _classes(message_class: MessageClass, seen: set[MessageClass]) -> Iterator[tuple[MessageClass, dict[str, Kind]]]:
    """Yield a class and those of the messages in it, each once, with their fields."""
    if message_class in seen:
        return
    seen.add(message_class)
    fields = kinds(message_class)
    yield message_class, fields
    for kind in fields.values():
        item = kind.item if isinstance(kind, Sequence) else kind
        if isinstance(item, Nested):
            yield from _classes(item.message_class, seen)


def _definitions(message_class: MessageClass, seen: set[MessageClass]) -> Iterator[Json]:
    for each, fields in _classes(message_class, seen):
        constants = _constants(each)
        yield {
            "type": _short(each),
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


def _short(message_class: MessageClass) -> str:
    package, _, name = type_name(message_class).split("/")
    return f"{package}/{name}"


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
            return _short(message_class)


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
