"""JSON for any ROS message, made up from its type."""

import base64
from typing import Any

import numpy as np
from hypothesis import strategies as st

from dock_gateway.ros.messages.constants import constants_by_field
from dock_gateway.ros.messages.types import Boolean, Float, Integer, Kind, MessageClass, Nested, Sequence, Text, kinds

# At a time, or messages of messages become too large to look at.
MAX_FIELDS = 4

Strategy = st.SearchStrategy[Any]


def documents(message_class: MessageClass) -> Strategy:
    """What `parse` takes: some of the fields, each in one of its forms."""
    fields = kinds(message_class)
    constants = constants_by_field(message_class, fields)
    names = {
        field: [name for constant in found for name in (constant.name, constant.full_name)]
        for field, found in constants.items()
    }
    found = {name: values(kind, names.get(name, [])) for name, kind in fields.items()}
    if not found:
        return st.just({})
    some = st.lists(st.sampled_from(sorted(found)), unique=True, max_size=MAX_FIELDS)
    return some.flatmap(lambda chosen: st.fixed_dictionaries({name: found[name] for name in chosen}))


def values(kind: Kind, names: list[str]) -> Strategy:
    """What a field takes."""
    match kind:
        case Boolean():
            return st.booleans()
        case Integer():
            numbers = st.integers(kind.low, kind.high)
            texts = numbers.map(str) if kind.wide else st.nothing()
            return numbers | texts | (st.sampled_from(names) if names else st.nothing())
        case Float():
            width = 32 if kind.single else 64
            return st.none() | st.floats(width=width, allow_nan=False, allow_infinity=False) | st.integers(-9, 9)
        case Text():
            return texts_of(kind.maximum if kind.maximum is not None else 20)
        case Sequence():
            high = kind.high if kind.high is not None else kind.low + 3
            binary = st.binary(min_size=kind.low, max_size=high).map(lambda raw: base64.b64encode(raw).decode())
            lists = st.lists(values(kind.item, names), min_size=kind.low, max_size=high)
            return lists | binary if kind.binary else lists
        case Nested():
            return documents(kind.message_class)


def texts_of(maximum: int) -> Strategy:
    """Text that CDR carries: without NUL and halves of surrogate pairs."""
    return st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=maximum)


def alike(one: Any, other: Any) -> bool:
    """Whether two messages hold the same values; NaN is like NaN."""
    if hasattr(one, "get_fields_and_field_types"):
        return type(one) is type(other) and all(
            alike(getattr(one, name), getattr(other, name)) for name in one.get_fields_and_field_types()
        )
    if isinstance(one, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, str | bytes | bool):
        return bool(one == other)
    return np.array_equal(np.asarray(one), np.asarray(other), equal_nan=True)
