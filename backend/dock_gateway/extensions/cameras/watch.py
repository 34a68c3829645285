"""A camera that is being watched: its newest picture for all viewers, encoded once for each size."""

import asyncio
import logging
import time
from asyncio import Task
from collections.abc import Callable
from functools import partial

from dock_gateway.core.fanout import Subscriber
from dock_gateway.extensions.cameras.camera import Camera
from dock_gateway.extensions.cameras.forms import Forms
from dock_gateway.extensions.cameras.picture import WHOLE, Picture, read_picture
from dock_gateway.extensions.cameras.pixels import Unreadable
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays

log = logging.getLogger(__name__)

# Seconds after which a picture is not shown to a viewer that comes.
STALE = 3.0


class Shot:
    """A message of a camera.

    Args:
        message: The message.
        quality: Of the JPEGs that are encoded.
    """

    def __init__(self, message: Received, quality: int) -> None:
        self._message = message
        self._quality = quality
        self._encoded: dict[int, Task[Picture]] = {}

    @property
    def topic(self) -> str:
        """The topic that it came on."""
        return self._message.topic

    @property
    def stale(self) -> bool:
        """Whether it is too old for a viewer that comes."""
        return time.time() - self._message.received_ns / 1e9 > STALE

    async def picture(self, max_width: int) -> Picture:
        """Return the picture, scaled by eighths of its size to be at most so wide.

        Raises:
            Unreadable: It cannot be shown.
        """
        whole = await self._once(WHOLE, partial(read_picture, self._message, self._quality))
        eighths = whole.eighths(max_width)
        if eighths == WHOLE:
            return whole
        return await self._once(eighths, partial(whole.scaled, eighths, self._quality))

    async def _once(self, eighths: int, encode: Callable[[], Picture]) -> Picture:
        if eighths not in self._encoded:
            self._encoded[eighths] = asyncio.create_task(asyncio.to_thread(encode))
        return await asyncio.shield(self._encoded[eighths])


class Watch:
    """A camera while it has viewers.

    Args:
        camera: The camera.
        relays: Reads the topics.
        quality: Of the JPEGs that are encoded.
        logged: By topic, why its pictures cannot be shown, as the log has it.

    Attributes:
        camera: The camera.
        forms: Reads its pictures.
        viewers: Woken up by each message.
        count: Number of messages so far.
        newest: The newest one.
        hint: Why the last picture cannot be shown; None if it can.
    """

    def __init__(self, camera: Camera, relays: Relays, quality: int, logged: dict[str, str]) -> None:
        self.camera = camera
        self.forms = Forms(relays, camera.topics, self)
        self.viewers: set[Subscriber] = set()
        self.count = 0
        self.newest: Shot | None = None
        self.hint: str | None = None
        self._logged = logged
        self._quality = quality

    async def offer(self, message: Received) -> None:
        """Take a message. It is encoded when a viewer takes it."""
        self.newest = Shot(message, self._quality)
        self.count += 1
        for viewer in self.viewers:
            viewer.wake()

    async def picture(self, max_width: int) -> Picture | None:
        """Return the newest picture, at most so wide; None if it cannot be shown, as `hint` says."""
        if self.newest is None:
            return None
        topic = self.newest.topic
        try:
            picture = await self.newest.picture(max_width)
        except Unreadable as error:
            self.hint = str(error)
            self.forms.judge(topic, readable=False)
            if self._logged.get(topic) != self.hint:  # once, however often viewers come again
                self._logged[topic] = self.hint
                log.warning("%s cannot be shown: %s", topic, self.hint)
            return None
        self.hint = None
        self.forms.judge(topic, readable=True)
        self._logged.pop(topic, None)
        return picture
