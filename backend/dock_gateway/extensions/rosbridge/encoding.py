"""Encodes a message on a topic as clients of rosbridge get it; in another process, if it is large."""

from dataclasses import dataclass
from typing import Any

import cbor2

from dock_gateway.core.event import websocket_frame
from dock_gateway.extensions.rosbridge import png
from dock_gateway.extensions.rosbridge.protocol import Compression, published
from dock_gateway.extensions.rosbridge.protocol import png as png_message
from dock_gateway.extensions.rosbridge.values import cbor_values, json_values
from dock_gateway.ros.raw_port import echo_type


@dataclass(frozen=True)
class Payload:
    """An encoded message.

    Attributes:
        frame: It as a WebSocket frame.
        size: Its number of bytes, which are at the end of the frame.
        binary: Whether it is not text.
    """

    frame: bytes
    size: int
    binary: bool

    @classmethod
    def of(cls, data: bytes, *, binary: bool) -> "Payload":
        """Return a payload with this data."""
        return cls(websocket_frame(data, binary=binary), len(data), binary)

    @property
    def data(self) -> bytes:
        """The message without the head of the frame."""
        return self.frame[len(self.frame) - self.size :]


def encode(compression: Compression, topic: str, type_name: str, data: bytes, received_ns: int) -> Payload:
    """Encode a message.

    Args:
        compression: How clients get it.
        topic: Absolute name of its topic.
        type_name: Name of its type.
        data: The serialized message (CDR).
        received_ns: When it came, in ns since 1970.

    Raises:
        Exception: The bytes are not such a message.
    """
    match compression:
        case Compression.cbor_raw:
            seconds, nanoseconds = divmod(received_ns, 1_000_000_000)
            return _packed(topic, {"secs": seconds, "nsecs": nanoseconds, "bytes": data})
        case Compression.cbor:
            return _packed(topic, cbor_values(echo_type(type_name).decode(data)))
    text = published(topic, json_values(echo_type(type_name).decode(data)))
    return Payload.of(png_message(png.encode(text)) if compression is Compression.png else text, binary=False)


def _packed(topic: str, message: dict[str, Any]) -> Payload:
    return Payload.of(cbor2.dumps({"op": "publish", "topic": topic, "msg": message}), binary=True)
