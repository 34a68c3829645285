"""The forms of a camera: one subscription to the best one that has pictures."""

import asyncio
import logging
from collections.abc import Sequence
from contextlib import suppress

from dock_gateway.core.errors import GatewayError
from dock_gateway.graph.received import Received
from dock_gateway.graph.relay import Outlet
from dock_gateway.graph.relays import Relays

log = logging.getLogger(__name__)

# Seconds between two checks; after the first one without a picture, all forms are read.
TICK = 1.0
# Seconds without a message after which a form is silent. One with few pictures may take three times its interval.
SILENT, MAX_SILENT = 3.0, 30.0


class Forms:
    """Reads the best form of a camera that has pictures which can be shown, and all of them while none has.

    A form that is advertised may stay silent: image_transport advertises `compressed` for depths, too.

    Args:
        relays: Reads the topics.
        topics: The topic of each form, the best first.
        outlet: Receives the messages.
        tick: See `TICK`.

    Attributes:
        topic: The topic that the last message came on; before it, that of the best form.
    """

    def __init__(self, relays: Relays, topics: Sequence[str], outlet: Outlet, *, tick: float = TICK) -> None:
        self.topic = topics[0]
        self._relays = relays
        self._topics = topics
        self._outlet = outlet
        self._tick = tick
        self._joined: set[str] = set()
        # By topic: when the last message came, and how long it counts, in seconds.
        self._heard: dict[str, tuple[float, float]] = {}
        self._unreadable: set[str] = set()
        self._check = asyncio.Event()
        self._closing = False
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Read the best form.

        Raises:
            GatewayError: It cannot be read, as `Relays.join` says.
        """
        await self._join(self.topic)
        if len(self._topics) > 1:
            self._task = asyncio.create_task(self._run())

    async def offer(self, message: Received) -> None:
        """Pass a message on if it is of the best form that has any."""
        now = asyncio.get_running_loop().time()
        before, _ = self._heard.get(message.topic, (now, 0.0))
        self._heard[message.topic] = now, max(SILENT, min(MAX_SILENT, 3 * (now - before)))
        if message.topic == self._best():
            self.topic = message.topic
            await self._outlet.offer(message)

    def judge(self, topic: str, *, readable: bool) -> None:
        """Note whether the last picture of a form can be shown; if not, others are tried at once."""
        if readable:
            self._unreadable.discard(topic)
        elif topic not in self._unreadable:
            self._unreadable.add(topic)
            self._check.set()

    def _best(self) -> str | None:
        """Return the best form that has messages now, if possible one that can be shown."""
        now = asyncio.get_running_loop().time()
        speaking = [
            topic
            for topic in self._topics
            if topic in self._heard and now - self._heard[topic][0] < self._heard[topic][1]
        ]
        return min(speaking, key=self._unreadable.__contains__, default=None)

    async def _run(self) -> None:
        while not self._closing:
            with suppress(TimeoutError):
                async with asyncio.timeout(self._tick):
                    await self._check.wait()
            self._check.clear()
            best = self._best()
            wanted = self._topics if best is None or best in self._unreadable else [best]
            for topic in () if self._closing else self._topics:
                try:
                    await (self._join(topic) if topic in wanted else self._leave(topic))
                except GatewayError as error:
                    log.debug("%s cannot be read: %s", topic, error.detail)

    async def _join(self, topic: str) -> None:
        if topic not in self._joined:
            await self._relays.join(topic, None, self)
            self._joined.add(topic)

    async def _leave(self, topic: str) -> None:
        if topic in self._joined:
            self._joined.remove(topic)
            await self._relays.leave(topic, self)

    async def close(self) -> None:
        """Leave all topics."""
        self._closing = True
        self._check.set()
        if self._task is not None:
            await self._task
        for topic in self._topics:
            await self._leave(topic)
