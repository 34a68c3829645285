"""Counts the nested messages in a serialized message (CDR), before ROS decodes it."""

from functools import cache

from dock_gateway.ros.messages.bounds import MAX_NESTED, Errors, TooLong, nested_in, weight_of_item
from dock_gateway.ros.messages.types import Boolean, Float, Integer, Kind, MessageClass, Nested, Sequence, Text, kinds

# Bytes before the values, which say in which order the bytes of a number are; 0 and 1 are plain CDR.
HEADER = 4
ORDERS = {b"\0\0": "big", b"\0\1": "little"}


def count_nested(data: bytes, message_class: MessageClass, most: int = MAX_NESTED) -> int:
    """Count the nested messages and texts, those of an array before its items are read. Return the end of the message.

    Args:
        data: The bytes.
        message_class: Class of the message.
        most: Maximum number of nested messages and texts.

    Raises:
        TooLong: There are more, or they cannot be counted, as with wide strings.
        ValueError: The bytes are no such message.
    """
    bound = Errors(most)
    bound.take(nested_in(message_class))
    counter = _Counter(data, bound)
    counter.skip(Nested(message_class))
    return counter.at


class _Counter:
    def __init__(self, data: bytes, bound: Errors) -> None:
        order = ORDERS.get(data[:2])
        if order is None:
            raise ValueError("no plain CDR")
        self._big = order == "big"
        self._data = data
        self._bound = bound
        self.at = HEADER

    def skip(self, kind: Kind) -> None:
        """Go behind a value."""
        match kind:
            case Nested(message_class):
                fields = _fields(message_class)
                for field in fields:
                    self.skip(field)
                self.at += not fields  # a message without fields is one byte
            case Sequence():
                self._skip_items(kind)
            case Text(wide=True):
                raise TooLong
            case Text():
                length = self._length()
                self.at += length
            case _:
                self._skip_numbers(kind, 1)

    def _skip_items(self, kind: Sequence) -> None:
        number = kind.low
        if not kind.fixed:
            number = self._length()
            if kind.code is None:
                self._bound.take(int(number * weight_of_item(kind)))
        if isinstance(kind.item, Nested | Text):
            for _ in range(number):
                self.skip(kind.item)
        elif number:
            self._skip_numbers(kind.item, number)

    def _length(self) -> int:
        start = self._align(4)
        self.at = start + 4
        if self.at > len(self._data):
            raise ValueError("cut off")
        return int.from_bytes(self._data[start : self.at], "big" if self._big else "little")

    def _skip_numbers(self, kind: Kind, number: int) -> None:
        size = _size(kind)
        self.at = self._align(size) + size * number

    def _align(self, size: int) -> int:
        return self.at + (HEADER - self.at) % size


@cache
def _fields(message_class: MessageClass) -> tuple[Kind, ...]:
    return tuple(kinds(message_class).values())


@cache
def _size(kind: Kind) -> int:
    match kind:
        case Integer(low=low, high=high):
            return (high - low).bit_length() // 8
        case Float(single=single):
            return 4 if single else 8
        case Boolean():
            return 1
        case _:
            raise TypeError(f"{kind} has no size of its own")
