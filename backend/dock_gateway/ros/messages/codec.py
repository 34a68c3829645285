"""Converts ROS messages to JSON and back, based on the message's own fields and types.

A codec is compiled once for each message class. It encodes a float32 as its shortest text, NaN and ±Infinity as null.
It parses partial messages and reports every error with its dotted path. `ros/messages/fields.py` has the kinds of
fields.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

import orjson

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.goal import Json, encode
from dock_gateway.core.work import in_turn
from dock_gateway.ros.messages.bounds import FEW_NESTED, MAX_NESTED, NUMBERS, Errors, TooLong, nested_in
from dock_gateway.ros.messages.constants import constants_by_field
from dock_gateway.ros.messages.fields import MAX_ERRORS, Field, compile_field, wrong
from dock_gateway.ros.messages.schema import Schema, message_schema
from dock_gateway.ros.messages.types import Float, MessageClass, kinds, unset_is_nan


@cache
def codec(message_class: MessageClass) -> "MessageCodec":
    """Return the codec of a message class, compiled at the first call."""
    return MessageCodec(message_class)


class MessageCodec:
    """Converts the messages of one class.

    Attributes:
        document: Converts a message to plain data, ready for `orjson`.
    """

    def __init__(self, message_class: MessageClass) -> None:
        self._class = message_class
        types = kinds(message_class)
        constants = constants_by_field(message_class, types)
        self._fields: dict[str, Field] = {
            name: compile_field(kind, constants.get(name, ()), codec) for name, kind in types.items()
        }
        self.document = _document_function(message_class, self._fields)
        self._defaults = [(name, field.default) for name, field in self._fields.items() if field.default]
        if unset_is_nan(message_class):
            floats = [name for name, kind in types.items() if isinstance(kind, Float)]
            self._defaults += [(name, _nan) for name in floats]

    def encode(self, message: Any) -> Json:
        """Encode a message as JSON text."""
        return encode(self.document(message))

    async def read(self, value: object, path: str = "") -> Any:
        """Build a message as `parse` does, and give way while that takes long.

        Raises:
            InvalidField: With all errors, up to a limit.
        """
        try:
            return self._parse(value, path, FEW_NESTED)
        except TooLong:
            return await in_turn(self.parse, value, path)

    def parse(self, value: object, path: str = "", further: Iterable[str] = ()) -> Any:
        """Build a message from decoded JSON; missing fields get their default, NaN if the message type wants it.

        A message is returned unchanged: a client may have sent it as bytes.

        Args:
            value: The JSON.
            path: Where it was, for errors.
            further: Fields that a client may send, too, of which others make those of the message.

        Raises:
            InvalidField: With all errors, up to a limit.
        """
        try:
            return self._parse(value, path, MAX_NESTED, further)
        except TooLong:
            most = f"at most {MAX_NESTED:,} nested messages and texts in all, a number counting 1/{NUMBERS}"
            raise InvalidField([FieldError(path, most, "got more")]) from None

    def _parse(self, value: object, path: str, most: int, further: Iterable[str] = ()) -> Any:
        if isinstance(value, self._class):
            return value
        errors = Errors(most)
        errors.take(nested_in(self._class))
        message = self.parse_into(value, path, errors, further)
        if errors:
            raise InvalidField(errors[:MAX_ERRORS])
        return message

    def parse_into(self, value: object, path: str, errors: Errors, further: Iterable[str] = ()) -> Any:
        """Like `parse`, but append the errors to `errors`."""
        message = self.default()
        if not isinstance(value, Mapping):
            errors.append(wrong(path, f"an object ({self._class.__name__})", value))
            return message
        for name, item in value.items():
            item_path = f"{path}.{name}" if path else str(name)
            field = self._fields.get(name)
            if field is None:
                known = ", ".join(dict.fromkeys((*further, *self._fields)))
                fields = f"one of {known}" if known else "no fields"
                errors.append(FieldError(item_path[:200], fields, "got an unknown field"))
            else:
                before = len(errors)
                parsed = field.parse(item, item_path, errors)
                if len(errors) == before:
                    setattr(message, name, parsed)
            if len(errors) >= MAX_ERRORS:
                break
        return message

    def default(self) -> Any:
        """Return a message with nothing set; floats are NaN if the message type wants it."""
        message = self._class()
        for name, make in self._defaults:
            setattr(message, name, make())
        return message

    @property
    def has_default(self) -> bool:
        """Whether `default` differs from a new instance of the class."""
        return bool(self._defaults)

    def schema(self, *, complete: bool = False) -> Schema:
        """Return the JSON Schema of the message as `parse` accepts it or, if `complete`, as `encode` writes it.

        Nested messages are under `$defs`, each once.
        """
        return message_schema(self._class, _default_json, complete=complete)


def _default_json(message_class: MessageClass) -> dict[str, Any]:
    compiled = codec(message_class)
    document: dict[str, Any] = orjson.loads(compiled.encode(compiled.default()))
    return document


def _nan() -> float:
    return math.nan


def _document_function(message_class: MessageClass, fields: Mapping[str, Field]) -> Callable[[Any], dict[str, Any]]:
    """Compile a function for this class: `lambda m: {"x": m._x, "points": encode_points(m._points)}`.

    It takes half the time of a loop over the fields. It reads the slots directly, not rosidl's properties.
    """
    slots = set(message_class.__slots__)
    parts = []
    for name, field in fields.items():
        value = f"m._{name}" if f"_{name}" in slots else f"m.{name}"
        parts.append(f"{name!r}: {f'encode_{name}({value})' if field.encode else value}")
    encoders = {f"encode_{name}": field.encode for name, field in fields.items()}
    function: Callable[[Any], dict[str, Any]] = eval(  # noqa: S307 - of names in classes that are code themselves
        f"lambda m: {{{', '.join(parts)}}}", {"__builtins__": {}, **encoders}
    )
    return function
