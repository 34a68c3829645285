"""Messages as bytes, as they are on the wire (CDR)."""

from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from dock_gateway.core.errors import MalformedRequest
from dock_gateway.ros.messages.types import MessageClass, type_name


def from_cdr(data: bytes, message_class: MessageClass) -> Any:
    """Return the message that a client sends as bytes.

    Raises:
        MalformedRequest: They are no such message.
    """
    try:
        return deserialize_message(data, message_class)
    except Exception as error:  # whatever the bytes bring about
        name = type_name(message_class)
        raise MalformedRequest(f"{len(data)} bytes are no {name} in CDR", code="malformed_cdr") from error


def to_cdr(message: Any) -> bytes:
    """Return a message as bytes."""
    data: bytes = serialize_message(message)
    return data
