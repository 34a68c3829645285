"""Reads and writes requests and responses of services, in CDR and in JSON."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import orjson

from dock_gateway.core.errors import FieldError, InvalidField, MalformedRequest
from dock_gateway.core.goal import encode, fragment
from dock_gateway.core.json_text import decode_json
from dock_gateway.core.work import SMALL, in_turn
from dock_gateway.extensions.foxglove.protocol import ENCODINGS, SCHEMA_ENCODING
from dock_gateway.ros.messages.cdr import from_cdr, to_cdr
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.full_definition import SEPARATOR, full_definition, short_name
from dock_gateway.ros.messages.types import MessageClass, type_name

HEADER = b"\x00\x01\x00\x00"


class Form(Protocol):
    """The form of a request or a response."""

    @property
    def name(self) -> str:
        """Name of the type."""

    @property
    def schema(self) -> str:
        """Definition of the type."""

    def read(self, encoding: str, data: bytes) -> Any:
        """Return what a client has sent.

        Raises:
            MalformedRequest, InvalidField: It is not of this form.
        """

    def write(self, encoding: str, value: Any) -> bytes:
        """Return what a client is sent."""


def form_document(form: Form) -> dict[str, str]:
    """Return a form as it is advertised."""
    return {
        "encoding": ENCODINGS[0],
        "schemaName": form.name,
        "schemaEncoding": SCHEMA_ENCODING,
        "schema": form.schema,
    }


def require_encoding(encoding: str) -> None:
    """Refuse an encoding that is not supported.

    Raises:
        InvalidField: It is not.
    """
    if encoding not in ENCODINGS:
        raise InvalidField([FieldError("encoding", f"one of {', '.join(ENCODINGS)}", f"got {encoding[:60]!r}")])


async def read_form(form: Form, encoding: str, data: bytes) -> Any:
    """Return what a client has sent. What is long is read in turn, while others work.

    Raises:
        MalformedRequest, InvalidField: It is not of this form.
        TooManyRequests: `too_much_input`: too much waits to be read.
    """
    return form.read(encoding, data) if len(data) <= SMALL else await in_turn(form.read, encoding, data)


class MessageForm:
    """A ROS message. JSON stays as it is: who uses it builds the message, and reports what is wrong."""

    def __init__(self, message_class: MessageClass) -> None:
        self.name = type_name(message_class)
        self.schema = full_definition(message_class)
        self._class = message_class

    def read(self, encoding: str, data: bytes) -> Any:
        """Return the message, or its fields as decoded JSON."""
        require_encoding(encoding)
        return from_cdr(data, self._class) if encoding == "cdr" else decode_json(data, "the message")

    def write(self, encoding: str, value: Any) -> bytes:
        """Return the message."""
        return to_cdr(value) if encoding == "cdr" else codec(self._class).encode(value)


@dataclass(frozen=True)
class TextForm:
    """Some texts by name, which the gateway defines itself. Those that are empty were not given.

    Attributes:
        name: Name of the type.
        fields: Names of the texts.
    """

    name: str
    fields: tuple[str, ...]

    @property
    def schema(self) -> str:
        """Its definition."""
        return "\n".join(f"string {field}" for field in self.fields)

    def read(self, encoding: str, data: bytes) -> dict[str, Any]:
        """Return the texts that were given."""
        require_encoding(encoding)
        values = self._from_cdr(data) if encoding == "cdr" else decode_json(data, "the request")
        if not isinstance(values, dict):
            raise InvalidField([FieldError("", "an object", "got something else")])
        return {name: value for name, value in values.items() if name not in self.fields or value not in ("", None)}

    def write(self, encoding: str, value: Mapping[str, str]) -> bytes:
        """Return the texts."""
        texts = {field: value.get(field) or "" for field in self.fields}
        return encode(texts) if encoding == "json" else HEADER + texts_to_cdr(b"", texts.values())

    def _from_cdr(self, data: bytes) -> dict[str, str]:
        try:
            return dict(zip(self.fields, _texts_from_cdr(data, len(self.fields)), strict=True))
        except (struct.error, ValueError):
            raise MalformedRequest(f"{len(data)} bytes are no {self.name} in CDR", code="malformed_cdr") from None


class ResultForm:
    """The result of an action, followed by texts about its goal."""

    def __init__(self, name: str, result_class: MessageClass, fields: tuple[str, ...]) -> None:
        self.name = name
        self._class = result_class
        self._texts = TextForm(name, fields)
        own, separator, others = full_definition(result_class).partition(f"{SEPARATOR}\n")
        self.schema = (
            f"{short_name(result_class)} result\n{self._texts.schema}\n"
            f"{SEPARATOR}\nMSG: {short_name(result_class)}\n{own.strip()}\n{separator}{others}"
        )

    def read(self, encoding: str, data: bytes) -> Any:
        """Not needed: a result is only sent."""
        raise NotImplementedError

    def write(self, encoding: str, value: Mapping[str, Any]) -> bytes:
        """Return the result, as JSON in `result`, and the texts."""
        result = value["result"]
        texts = {field: value.get(field) or "" for field in self._texts.fields}
        if encoding == "json":
            return encode({"result": fragment(result), **texts})
        message = codec(self._class).parse({} if result is None else orjson.loads(result))
        return HEADER + texts_to_cdr(to_cdr(message)[len(HEADER) :], texts.values())


def texts_to_cdr(before: bytes, texts: Any) -> bytes:
    """Return what is before some texts, and the texts: each has its length, and ends with a zero."""
    data = bytearray(before)
    for text in texts:
        octets = text.encode() + b"\0"
        data += bytes(-len(data) % 4) + struct.pack("<I", len(octets)) + octets
    return bytes(data)


def _texts_from_cdr(data: bytes, count: int) -> list[str]:
    """Return texts.

    Raises:
        struct.error, ValueError: There are none.
    """
    order = {b"\x00\x00": ">I", b"\x00\x01": "<I"}.get(data[:2])
    if order is None:
        raise ValueError("the representation is not known")
    body, at, texts = data[len(HEADER) :], 0, []
    for _ in range(count):
        at += -at % 4
        (length,) = struct.unpack_from(order, body, at)
        octets = body[at + 4 : at + 4 + length]
        if len(octets) != length:
            raise ValueError("a text is cut off")
        texts.append(octets.rstrip(b"\0").decode())
        at += 4 + length
    return texts
