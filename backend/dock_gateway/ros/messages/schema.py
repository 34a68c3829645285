"""JSON Schema (draft 2020-12) of ROS messages, with the comments of their definition files and their constants.

`x-unit` is the unit of a number if the definition's comment names one. `x-constants` are the named values of a field;
any other number of its type stays valid, as in ROS.
"""

from collections.abc import Callable
from typing import Any

from dock_gateway.ros.messages.constants import Constant, constants_by_field
from dock_gateway.ros.messages.definitions import Definition, definition, unit
from dock_gateway.ros.messages.fields import DECIMAL, FLOAT32_MAX, MAX_SAFE, MAX_STRING, limit_of
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

Schema = dict[str, Any]
DIALECT = "https://json-schema.org/draft/2020-12/schema"

WITHOUT_NUL = r"^[^\u0000]*$"

# Items. Longer defaults, such as a covariance of 36 zeros, are left out as useless to a reader.
MAX_DEFAULT = 16


def message_schema(
    message_class: MessageClass, defaults: Callable[[MessageClass], dict[str, Any]], *, complete: bool
) -> Schema:
    """Return the schema of a message; nested messages are under `$defs`, each once.

    Args:
        message_class: The message class.
        defaults: Returns a message with nothing set, as decoded JSON.
        complete: Whether to describe the messages that are written, else those that are accepted.
    """
    builder = _Builder(defaults, complete)
    schema = builder.message(message_class)
    if builder.nested:
        schema["$defs"] = dict(sorted(builder.nested.items()))
    return schema


class _Builder:
    def __init__(self, defaults: Callable[[MessageClass], dict[str, Any]], complete: bool) -> None:
        self._defaults = defaults
        self._complete = complete
        self.nested: dict[str, Schema] = {}

    def message(self, message_class: MessageClass) -> Schema:
        fields = kinds(message_class)
        constants = constants_by_field(message_class, fields)
        comments = definition(message_class)
        defaults = {} if self._complete else self._defaults(message_class)
        schema: Schema = {"type": "object", "title": message_class.__name__, "x-ros-type": type_name(message_class)}
        if comments.description:
            schema["description"] = comments.description
        schema["additionalProperties"] = False
        schema["properties"] = {
            name: self._kind(kind, constants.get(name, ()), comments)
            | _comment(kind, comments.fields.get(name, ""))
            | _default(kind, name, defaults)
            for name, kind in fields.items()
        }
        if self._complete:
            schema["required"] = list(fields)
        return schema

    def _kind(self, kind: Kind, constants: tuple[Constant, ...], comments: Definition) -> Schema:
        match kind:
            case Boolean():
                return {"type": "boolean"}
            case Integer():
                return self._integer(kind, constants, comments)
            case Float():
                bounds = {"minimum": -FLOAT32_MAX, "maximum": FLOAT32_MAX} if kind.single else {}
                return {"type": ["number", "null"], "format": "float" if kind.single else "double", **bounds}
            case Text():
                return self._text(kind)
            case Sequence():
                return self._sequence(kind, self._kind(kind.item, constants, comments))
            case Nested():
                return self._reference(kind.message_class)

    def _reference(self, message_class: MessageClass) -> Schema:
        name = type_name(message_class).replace("/", ".")
        if name not in self.nested:
            self.nested[name] = self.message(message_class)
        return {"$ref": f"#/$defs/{name}"}

    def _text(self, kind: Text) -> Schema:
        if self._complete:
            return {"type": "string", **({} if kind.maximum is None else {"maxLength": kind.maximum})}
        return {"type": "string", "maxLength": kind.maximum or MAX_STRING, "pattern": WITHOUT_NUL}

    def _integer(self, kind: Integer, constants: tuple[Constant, ...], comments: Definition) -> Schema:
        schema: Schema = {"type": "integer", "minimum": kind.low, "maximum": kind.high}
        if kind.wide:
            schema["type"] = ["integer", "string"]
            schema["format"] = kind.typename
            schema["pattern"] = f"^{DECIMAL if kind.low else DECIMAL.removeprefix('-?')}$"
            if self._complete:
                schema["minimum"], schema["maximum"] = max(kind.low, -MAX_SAFE), MAX_SAFE
        if not constants:
            return schema
        names = {"x-constants": {constant.name: constant.value for constant in constants}}
        if self._complete:
            return schema | names
        return {"anyOf": [*(_choice(constant, comments) for constant in constants), schema, _names(constants)], **names}

    def _sequence(self, kind: Sequence, item: Schema) -> Schema:
        maximum = kind.high if self._complete else limit_of(kind)
        limits = {"minItems": kind.low, **({} if maximum is None else {"maxItems": maximum})}
        schema: Schema = {"type": "array", "items": item, **limits}
        if self._complete or not kind.binary:
            return schema
        base64 = {"type": "string", "contentEncoding": "base64", "maxLength": (limit_of(kind) + 2) // 3 * 4}
        return {"anyOf": [schema, base64]}


def _choice(constant: Constant, comments: Definition) -> Schema:
    comment = comments.constants.get(constant.full_name)
    return {
        "const": constant.value,
        "title": constant.name,
        **({"description": comment} if comment else {}),
    }


def _names(constants: tuple[Constant, ...]) -> Schema:
    """Return the schema of constants by name. Parsing ignores case, which a schema cannot express."""
    names = dict.fromkeys(name for constant in constants for name in (constant.name, constant.full_name))
    return {"type": "string", "enum": list(names)}


def _comment(kind: Kind, comment: str) -> Schema:
    number = kind.item if isinstance(kind, Sequence) else kind
    symbol = unit(comment) if isinstance(number, Integer | Float) else None
    return {**({"description": comment} if comment else {}), **({"x-unit": symbol} if symbol else {})}


def _default(kind: Kind, name: str, defaults: dict[str, Any]) -> Schema:
    if isinstance(kind, Nested) or name not in defaults:
        return {}
    value = defaults[name]
    return {} if isinstance(value, list) and len(value) > MAX_DEFAULT else {"default": value}
