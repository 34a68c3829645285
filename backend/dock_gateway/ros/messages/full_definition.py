"""The whole definition of a message type, with the types in it, as the format `ros2msg` of recordings and viewers.

A definition begins with the text of the type itself. Each type in it follows after a line of `=`, under
`MSG: package/Name`. The parts of actions and services have no files of their own, and are named as their classes,
such as `package/Name_Feedback`.
"""

import re
from collections.abc import Iterator
from functools import lru_cache

from dock_gateway.ros.messages.definitions import PARTS
from dock_gateway.ros.messages.interfaces import definition_text
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

SEPARATOR = "=" * 80
# Definitions that are kept: looking for a type costs milliseconds.
KEEP = 1000


@lru_cache(KEEP)
def full_definition(message_class: MessageClass) -> str:
    """Return the definition of a message class and of all types in it.

    Where the definition file of a type is not installed, its fields are written from its class.

    Raises:
        TypeError: A field has a type that no .msg file can have.
    """
    own, *others = nested_classes(message_class)
    parts = [_text(own)]
    parts += [f"{SEPARATOR}\nMSG: {short_name(each)}\n{_text(each)}" for each in others]
    return "\n".join(parts)


def nested_classes(message_class: MessageClass) -> list[MessageClass]:
    """Return a class and those of all messages in it, each once.

    Raises:
        TypeError: A field has a type that no .msg file can have.
    """
    return list(dict.fromkeys(_nested(message_class, set())))


def short_name(message_class: MessageClass) -> str:
    """Return a name without its kind, such as `sensor_msgs/BatteryState`."""
    package, _, name = type_name(message_class).split("/")
    return f"{package}/{name}"


def _nested(message_class: MessageClass, seen: set[MessageClass]) -> Iterator[MessageClass]:
    if message_class in seen:
        return
    seen.add(message_class)
    yield message_class
    for kind in kinds(message_class).values():
        item = kind.item if isinstance(kind, Sequence) else kind
        if isinstance(item, Nested):
            yield from _nested(item.message_class, seen)


def _text(message_class: MessageClass) -> str:
    package, kind, name = type_name(message_class).split("/")
    if kind in PARTS:
        name, _, part = name.rpartition("_")
        sections = re.split(r"^---.*\n?", definition_text(package, kind, name) or "", flags=re.MULTILINE)
        if part in PARTS[kind] and len(sections) == len(PARTS[kind]):
            return sections[PARTS[kind].index(part)].strip()
    elif (text := definition_text(package, kind, name)) is not None:
        return text.strip()
    return "\n".join(_field(each, field) for field, each in kinds(message_class).items())


def _field(kind: Kind, name: str) -> str:
    if not isinstance(kind, Sequence):
        return f"{_item(kind)} {name}"
    bound = str(kind.low) if kind.fixed else "" if kind.high is None else f"<={kind.high}"
    return f"{_item(kind.item)}[{bound}] {name}"


def _item(kind: Kind) -> str:
    match kind:
        case Boolean():
            return "bool"
        case Integer(typename):
            return "byte" if kind.octet else typename
        case Float(single):
            return "float32" if single else "float64"
        case Text(maximum):
            return "string" if maximum is None else f"string<={maximum}"
        case Nested(message_class):
            return short_name(message_class)
        case _:
            raise TypeError(f"{kind} is no item of a field")
