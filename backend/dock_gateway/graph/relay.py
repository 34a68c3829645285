"""A topic that is read: one subscription for all who read its messages as bytes, and all who view them decoded."""

import asyncio
import logging
from asyncio import Task
from typing import Protocol

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.graph import Topic
from dock_gateway.core.tasks import cancel
from dock_gateway.core.work import Work
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.earlier import EarlierMessages
from dock_gateway.graph.echo import Echo, Viewer
from dock_gateway.graph.received import Received
from dock_gateway.graph.subscription import Listening, TopicSubscription, listening_for, wait
from dock_gateway.ros.bridge import Bridge

log = logging.getLogger(__name__)

# Seconds between two checks of a topic: who publishes it, and how.
TICK = 1.0
# Seconds between two takes if all readers are patient.
PAUSE = 0.25
# How many times longer the interval of checks is then.
SELDOM = 5


class Outlet(Protocol):
    """A reader of a relayed topic.

    One with an attribute `patient` that is true, such as a recording, takes messages a little later, if no other reader
    of the topic is in a hurry. That saves half of the processor time.
    """

    async def offer(self, message: Received) -> None:
        """Take a message; waits for nothing but its encoding."""


class Relay:
    """One topic, for all its readers.

    Args:
        bridge: Runs calls on the ROS thread.
        graph: Knows the endpoints of the topic.
        topic: The current state of the topic.
        work: Decodes messages for viewers.
        tick: See `TICK`.

    Attributes:
        outlets: The readers of every message.
        joining: Those that get the earlier messages first.
    """

    def __init__(self, bridge: Bridge, graph: GraphCache, topic: Topic, work: Work, tick: float = TICK) -> None:
        self.outlets: set[Outlet] = set()
        self.joining: set[Outlet] = set()
        self._tick = tick
        self._check_at = float("-inf")
        self._news = asyncio.Event()
        self._subscription = TopicSubscription(bridge, graph, topic)
        self._echo = Echo(self._subscription, work, tick)
        self._earlier = EarlierMessages()
        self._task: Task[None] | None = None

    @property
    def kind(self) -> str:
        """The type of the topic."""
        kind = self._subscription.kind
        return "" if kind is None else kind.name

    @property
    def hint(self) -> str | None:
        """The reason why its messages cannot be read: their package is not installed. None if they can be."""
        kind = self._subscription.kind
        return None if kind is None else kind.hint

    @property
    def viewed(self) -> bool:
        """Whether it has viewers."""
        return self._echo.viewed

    @property
    def used(self) -> bool:
        """Whether it has readers or viewers."""
        return bool(self.outlets or self.joining) or self.viewed

    async def open(self, type_name: str | None) -> None:
        """Subscribe to the topic.

        Args:
            type_name: Its type, if no node has the topic yet.

        Raises:
            Conflict: `topic_in_use`: the gateway itself uses the topic with another type.
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        subscription = self._subscription
        types = subscription.topic.types or [type_name or ""]
        at_first = Listening(types[0], reliable=False, latched=False)
        await subscription.listen(listening_for(subscription.topic, at_first))
        self._check_at = asyncio.get_running_loop().time() + self._tick
        self._task = asyncio.create_task(self._run())

    async def close(self) -> None:
        """End the subscription."""
        if self._task is not None:
            await cancel(self._task)
        await self._echo.close()
        self._subscription.close()

    def view(self, viewer: Viewer) -> None:
        """Show the topic to a viewer."""
        if self.used and not self.viewed:  # its publishers may have been checked some seconds ago
            self._check_at = float("-inf")
            self._news.set()
        self._echo.add(viewer)

    def hide(self, viewer: Viewer) -> None:
        """Show the topic to a viewer no more."""
        self._echo.remove(viewer)

    def join(self, outlet: Outlet) -> None:
        """Note that a reader is about to be added, so that the topic stays open."""
        self.joining.add(outlet)
        self._arrange()

    async def add(self, outlet: Outlet) -> None:
        """Add one of those that are joining. It gets the `EarlierMessages`, if the topic's publishers keep any."""
        for message in self._earlier:
            await outlet.offer(message)
        if outlet in self.joining:  # else it has left since
            self.joining.remove(outlet)
            self.outlets.add(outlet)

    def discard(self, outlet: Outlet) -> None:
        """Remove a reader, if it is one or is joining."""
        self.outlets.discard(outlet)
        self.joining.discard(outlet)
        self._arrange()

    def _arrange(self) -> None:
        self._subscription.keep_all(wanted=bool(self.outlets or self.joining))
        self._news.set()

    @property
    def _patient(self) -> bool:
        return bool(self.outlets) and all(getattr(outlet, "patient", False) for outlet in self.outlets)

    async def _run(self) -> None:
        now = asyncio.get_running_loop().time
        self._news.set()
        while True:
            try:
                if self._patient:
                    await asyncio.sleep(PAUSE)
                await wait(self._news, self._check_at - now())
                await self._pass_on()
                if now() >= self._check_at:
                    self._check_at = now() + self._tick * (SELDOM if self._patient and not self.viewed else 1)
                    if await self._subscription.update():
                        self._echo.changed()
                        self._news.set()
            except GatewayError as error:
                log.warning("cannot subscribe to %s: %s", self._subscription.topic.name, error.detail)
            except Exception:
                log.exception("while reading %s", self._subscription.topic.name)
                await asyncio.sleep(self._tick)

    async def _pass_on(self) -> None:
        heard = self._subscription
        if heard.port is None or heard.kind is None or not heard.keeps_all:
            return
        heard.tell_next(self._news)  # before the take: what comes after it wakes us at once
        for arrival in heard.port.take():
            message = Received(heard.topic.name, heard.kind, arrival, heard.offer)
            for outlet in tuple(self.outlets):
                try:
                    await outlet.offer(message)
                except GatewayError as error:
                    log.warning("a message of %s was not taken: %s", heard.topic.name, error.detail)
                except Exception:
                    log.exception("a reader of %s failed, and reads no more", heard.topic.name)
                    self.discard(outlet)
            if heard.listening is not None and heard.listening.latched:
                self._earlier.add(message)
            else:
                self._earlier.clear()
