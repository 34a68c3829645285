"""Truncates messages for display: the first items of long arrays, the beginning of long texts.

A message is truncated before it is encoded, so that an image or a point cloud costs no more than its first items.
"""

from functools import cache
from typing import Any

from dock_gateway.ros.messages.types import Kind, MessageClass, Nested, Sequence, Text, kinds

MAX_ITEMS = 100
MAX_TEXT = 10_000

# The fields of a class that can be long or contain something long: name, slot, kind.
Plan = tuple[tuple[str, str, Kind], ...]


def abbreviate(message: Any) -> dict[str, int]:
    """Truncate a message in place.

    Returns:
        The original length of each truncated array (items) and text (characters), by dotted path.
    """
    lengths: dict[str, int] = {}
    _cut_fields(message, "", lengths)
    return lengths


@cache
def _plan(message_class: MessageClass) -> Plan:
    slots = set(message_class.__slots__)
    return tuple(
        (name, f"_{name}" if f"_{name}" in slots else name, kind)
        for name, kind in kinds(message_class).items()
        if _can_be_long(kind)
    )


def _can_be_long(kind: Kind) -> bool:
    match kind:
        case Text(maximum):
            return maximum is None or maximum > MAX_TEXT
        case Sequence():
            return kind.high is None or kind.high > MAX_ITEMS or _can_be_long(kind.item)
        case Nested(message_class):
            return bool(_plan(message_class))
        case _:
            return False


def _cut_fields(message: Any, path: str, lengths: dict[str, int]) -> None:
    message_class: MessageClass = type(message)
    for name, slot, kind in _plan(message_class):
        value = getattr(message, slot)
        short = _cut(value, kind, f"{path}{name}", lengths)
        if short is not value:
            setattr(message, slot, short)  # bypasses the property, which checks the length of fixed arrays


def _cut(value: Any, kind: Kind, path: str, lengths: dict[str, int]) -> Any:
    if isinstance(kind, Nested):
        _cut_fields(value, f"{path}.", lengths)
        return value
    limit = MAX_TEXT if isinstance(kind, Text) else MAX_ITEMS
    if len(value) > limit:
        lengths[path] = len(value)
        value = value[:limit]
    if isinstance(kind, Sequence) and _can_be_long(kind.item):
        return [_cut(item, kind.item, f"{path}.{index}", lengths) for index, item in enumerate(value)]
    return value
