"""Messages as clients of rosbridge get them: each is encoded once for each compression, for all clients."""

import asyncio
import logging
from asyncio import Task
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from dock_gateway.core.event import websocket_frame
from dock_gateway.graph.received import Received
from dock_gateway.rosbridge import cbor, png
from dock_gateway.rosbridge.protocol import Compression, published
from dock_gateway.rosbridge.protocol import png as png_message
from dock_gateway.rosbridge.values import cbor_values, json_values

log = logging.getLogger(__name__)

# Bytes of a message that is encoded on the event loop; a longer one is encoded in a thread.
SMALL = 4096


@dataclass(frozen=True)
class Payload:
    """An encoded message."""

    data: bytes
    binary: bool

    @cached_property
    def frame(self) -> bytes:
        """The message as a WebSocket frame."""
        return websocket_frame(self.data, binary=self.binary)


class Published:
    """A message on a topic, as it is published to clients.

    Args:
        message: The message.

    Attributes:
        size: Its number of bytes in ROS.
    """

    def __init__(self, message: Received) -> None:
        self.size = message.size
        self._message = message
        self._payloads: dict[Compression, Payload | None] = {}
        self._encoding: dict[Compression, Task[Payload | None]] = {}

    async def payload(self, compression: Compression) -> Payload | None:
        """Return the message as clients get it; None if its bytes are not of its type."""
        if compression not in self._payloads:
            if self.size <= SMALL:
                self._payloads[compression] = self._encode(compression)
            else:
                if compression not in self._encoding:
                    encoding = asyncio.to_thread(self._encode, compression)
                    self._encoding[compression] = asyncio.create_task(encoding)
                self._payloads[compression] = await asyncio.shield(self._encoding[compression])
        return self._payloads[compression]

    def _encode(self, compression: Compression) -> Payload | None:
        try:
            match compression:
                case Compression.cbor_raw:
                    return self._packed(self._raw())
                case Compression.cbor:
                    return self._packed(cbor_values(self._decoded()))
            text = published(self._message.topic, json_values(self._decoded()))
            return Payload(png_message(png.encode(text)) if compression is Compression.png else text, binary=False)
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            message = self._message
            log.debug("a message on %s cannot be read as %s: %s", message.topic, message.kind.name, error)
            return None

    def _decoded(self) -> Any:
        return self._message.kind.decode(self._message.data)

    def _raw(self) -> dict[str, Any]:
        seconds, nanoseconds = divmod(self._message.received_ns, 1_000_000_000)
        return {"secs": seconds, "nsecs": nanoseconds, "bytes": self._message.data}

    def _packed(self, message: dict[str, Any]) -> Payload:
        return Payload(cbor.encode({"op": "publish", "topic": self._message.topic, "msg": message}), binary=True)
