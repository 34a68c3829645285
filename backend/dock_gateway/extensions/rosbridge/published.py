"""Messages as clients of rosbridge get them: each is encoded once for each compression, for all clients."""

import asyncio
import logging
from asyncio import Task

from dock_gateway.core.work import MEDIUM, SMALL, TooLarge, Work
from dock_gateway.extensions.rosbridge.encoding import Payload, encode
from dock_gateway.extensions.rosbridge.protocol import Compression
from dock_gateway.graph.received import Received

log = logging.getLogger(__name__)


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

    async def payload(self, compression: Compression, work: Work) -> Payload | None:
        """Return the message as clients get it; None if its bytes are not of its type.

        Raises:
            TooLarge: It is too large for that.
        """
        if compression not in self._payloads:
            if self.size <= SMALL:  # then nothing is waited for: a task for each message costs a tenth of it all
                self._payloads[compression] = await self._encode(compression, work)
            else:
                if compression not in self._encoding:
                    self._encoding[compression] = asyncio.create_task(self._encode(compression, work))
                self._payloads[compression] = await asyncio.shield(self._encoding[compression])
        return self._payloads[compression]

    async def _encode(self, compression: Compression, work: Work) -> Payload | None:
        message = self._message
        # Bytes that stay as they are only have to be copied.
        size = min(self.size, MEDIUM) if compression is Compression.cbor_raw else self.size
        try:
            topic, kind = message.topic, message.kind.name
            return await work(size, encode, compression, topic, kind, message.data, message.received_ns)
        except TooLarge:
            raise
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            log.debug("a message on %s cannot be read as %s: %s", message.topic, message.kind.name, error)
            return None
