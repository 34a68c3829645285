"""Messages as bytes, as they are on the wire (CDR)."""

from http import HTTPStatus
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from dock_gateway.core.errors import MalformedRequest
from dock_gateway.ros.messages.bounds import MAX_NESTED, TooLong, most_nested
from dock_gateway.ros.messages.types import MessageClass, type_name
from dock_gateway.ros.messages.wire import count_nested


def from_cdr(data: bytes, message_class: MessageClass) -> Any:
    """Return the message that a client sends as bytes.

    Raises:
        MalformedRequest: They are no such message, or hold too many nested ones (`body_too_large`).
    """
    try:
        if most_nested(message_class, len(data)) > MAX_NESTED:  # by its size: few messages have to be counted
            count_nested(data, message_class)
        return deserialize_message(data, message_class)
    except TooLong:
        name = type_name(message_class)
        raise MalformedRequest(
            f"{len(data)} bytes of {name} hold more than {MAX_NESTED:,} nested messages and texts",
            code="body_too_large",
            status=HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
        ) from None
    except Exception as error:  # whatever the bytes bring about
        name = type_name(message_class)
        raise MalformedRequest(f"{len(data)} bytes are no {name} in CDR", code="malformed_cdr") from error


def to_cdr(message: Any) -> bytes:
    """Return a message as bytes."""
    data: bytes = serialize_message(message)
    return data
