"""Messages as bytes, as they are on the wire (CDR)."""

from http import HTTPStatus
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from dock_gateway.core.errors import MalformedRequest
from dock_gateway.ros.messages.bounds import MAX_NESTED, most_nested
from dock_gateway.ros.messages.types import MessageClass, type_name


def from_cdr(data: bytes, message_class: MessageClass) -> Any:
    """Return the message that a client sends as bytes.

    Raises:
        MalformedRequest: They are no such message, or may hold too many nested ones (`body_too_large`).
    """
    if most_nested(message_class, len(data)) > MAX_NESTED:
        name = type_name(message_class)
        raise MalformedRequest(
            f"{len(data)} bytes of {name} may hold more than {MAX_NESTED:,} nested messages and texts",
            code="body_too_large",
            status=HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
        )
    try:
        return deserialize_message(data, message_class)
    except Exception as error:  # whatever the bytes bring about
        name = type_name(message_class)
        raise MalformedRequest(f"{len(data)} bytes are no {name} in CDR", code="malformed_cdr") from error


def to_cdr(message: Any) -> bytes:
    """Return a message as bytes."""
    data: bytes = serialize_message(message)
    return data
