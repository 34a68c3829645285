"""The topics that one client reads, which a door encodes in its own way."""

from collections.abc import Callable, Hashable
from contextlib import AsyncExitStack

from dock_gateway.core.access import Principal
from dock_gateway.core.fanout import FrameWriter
from dock_gateway.http.parts import Parts
from dock_gateway.operations import topics as operations


class TopicReadings:
    """The topics that one client reads.

    Args:
        parts: Carry out the operations.
        principal: The user.
        writer: Writes frames past the queue; None if the connection cannot.

    Attributes:
        write: Writes a frame past the queue; returns False, without writing, if it would have to wait.
    """

    def __init__(self, parts: Parts, principal: Principal, writer: FrameWriter | None) -> None:
        self._parts = parts
        self._principal = principal
        self._readings: dict[Hashable, AsyncExitStack] = {}
        self.write: Callable[[bytes], bool] = (lambda _: False) if writer is None else writer.write_frame

    async def begin(self, key: Hashable, order: operations.ReadTopic) -> None:
        """Read a topic.

        Raises:
            GatewayError: As `operations.subscribe`.
        """
        self._readings[key] = await operations.subscribe(self._parts, self._principal, order)

    async def end(self, key: Hashable) -> None:
        """Stop reading what was begun with a key."""
        await self._readings.pop(key).aclose()
