"""Limits the size of one message of a client: it is read, and given to ROS, while others wait."""

from functools import cache

from dock_gateway.core.errors import FieldError
from dock_gateway.ros.messages.types import Float, Integer, Kind, MessageClass, Nested, Sequence, Text, kinds

# Nested messages and texts in a message, in all its arrays together. That many take ROS some 10 ms, all at once.
MAX_NESTED = 10_000
# Those of a message that is read on the event loop: about a millisecond. A longer one is read in a thread.
FEW_NESTED = 300
# Numbers in an array that take as long as a nested message.
NUMBERS = 50


class TooLong(Exception):
    """A message holds more than may be read."""


class Errors(list[FieldError]):
    """The errors of a message that is being read, and how much more of it may be read.

    Args:
        most: Maximum number of nested messages and texts.
    """

    def __init__(self, most: int = MAX_NESTED) -> None:
        super().__init__()
        self._left = most

    def take(self, items: int) -> None:
        """Take nested messages and texts, before they are read.

        Raises:
            TooLong: There are too many.
        """
        self._left -= items
        if self._left < 0:
            raise TooLong


def is_long(value: object) -> bool:
    """Return whether decoded JSON has more values than are worked on on the event loop."""
    waiting = [value]
    for _ in range(FEW_NESTED):
        if not waiting:
            return False
        item = waiting.pop()
        if isinstance(item, dict):
            waiting.extend(item.values())
        elif isinstance(item, list):
            waiting.extend(item)
    return True


@cache
def nested_in(message_class: MessageClass) -> int:
    """Return the number of messages that a message consists of if its arrays are empty, with itself."""
    return 1 + sum(map(_weight, kinds(message_class).values()))


def weight_of_item(kind: Sequence) -> float:
    """Return what an item of an array counts."""
    return 1 / NUMBERS if kind.code else max(1, _weight(kind.item))


def _weight(kind: Kind) -> int:
    match kind:
        case Nested(message_class):
            return nested_in(message_class)
        case Sequence(item=item, low=low):
            return low * _weight(item)
        case _:
            return 0


def most_nested(message_class: MessageClass, size: int) -> float:
    """Return how many nested messages and texts a serialized message of so many bytes (CDR) may have at most."""
    return nested_in(message_class) + size * _density(Nested(message_class))


@cache
def _density(kind: Kind) -> float:
    """Return how many nested messages and texts there may be for each byte."""
    match kind:
        case Nested(message_class):
            return max(map(_density, kinds(message_class).values()), default=0.0)
        case Sequence(item=item, code=None):
            return max(max(1, _weight(item)) / max(1, _least_size(item)), _density(item))
        case _:
            return 0.0


def _least_size(kind: Kind) -> int:
    """Return the least number of bytes of a value."""
    match kind:
        case Integer(high=high):
            return -(-high.bit_length() // 8)
        case Float(single=single):
            return 4 if single else 8
        case Text():
            return 4
        case Sequence(item=item, low=low, fixed=fixed):
            return low * _least_size(item) + (0 if fixed else 4)
        case Nested(message_class):
            return sum(map(_least_size, kinds(message_class).values()))
        case _:
            return 1
