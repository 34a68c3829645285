"""The constants of a message and the fields they belong to.

ROS definitions do not link them, but there is a naming convention: `STATUS_ABORTED` is a value of the field `status`. A
constant belongs to the field with the longest name that is a prefix of its own. Constants without such a field belong
to none.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from dock_gateway.ros.messages.types import Integer, Kind, MessageClass, Sequence


@dataclass(frozen=True)
class Constant:
    """A constant of a field, such as `CHARGING`, with the full name `POWER_SUPPLY_STATUS_CHARGING`."""

    name: str
    full_name: str
    value: int


def constants_by_field(message_class: MessageClass, fields: Mapping[str, Kind]) -> dict[str, tuple[Constant, ...]]:
    """Return the constants of each integer field that has any, in the order of the definition."""
    integers: dict[str, Integer] = {}
    for field, kind in fields.items():
        item = kind.item if isinstance(kind, Sequence) else kind
        if isinstance(item, Integer):
            integers[field] = item
    found: dict[str, tuple[Constant, ...]] = {}
    for full_name, value in _integer_constants(message_class).items():
        owners = [field for field in fields if full_name.startswith(f"{field.upper()}_")]
        owner = max(owners, key=len, default="")
        if owner in integers and integers[owner].low <= value <= integers[owner].high:
            name = full_name[len(owner) + 1 :]
            found[owner] = (*found.get(owner, ()), Constant(name, full_name, value))
    return found


def _integer_constants(message_class: MessageClass) -> dict[str, int]:
    # rosidl makes each constant a property of the metaclass, and each default a property NAME__DEFAULT.
    metaclass = type(message_class)
    found = {}
    for name, member in vars(metaclass).items():
        if not isinstance(member, property) or name.endswith("__DEFAULT"):
            continue
        value = getattr(message_class, name)
        if isinstance(value, bytes) and len(value) == 1:
            value = value[0]
        if isinstance(value, int) and not isinstance(value, bool):
            found[name] = value
    return found
