"""The gateway's subscription to any topic: of the type and the quality that the topic's publishers have.

Its readers wait each for themselves, so that a slow one delays no other: one that reads every message, and one that
reads the newest at its own pace.
"""

import asyncio
from dataclasses import dataclass
from typing import NamedTuple

from dock_gateway.core.errors import NotFound
from dock_gateway.core.graph import TRANSFORMS, Endpoint, Topic
from dock_gateway.graph.cache import GraphCache
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.raw_port import EchoPort, EchoType, Heard

# The most messages that count as kept for later subscribers.
MOST_KEPT = 1_000
# Messages that are kept while earlier ones are encoded.
KEEP = 200


@dataclass(frozen=True)
class Listening:
    """The type and quality of service of a subscription."""

    kind: str
    reliable: bool
    latched: bool


class Offer(NamedTuple):
    """The QoS that the publishers of a topic offer together.

    Attributes:
        reliable: Whether one of them sends again what was lost.
        kept: Number of messages that they keep for later subscribers.
    """

    reliable: bool
    kept: int


OFFER = Offer(reliable=True, kept=0)


class TopicSubscription:
    """A subscription that is replaced when the topic's publishers change.

    Args:
        bridge: Runs calls on the ROS thread.
        graph: Knows the endpoints of the topic.
        topic: The current state of the topic.

    Attributes:
        topic: The topic, as it was last seen.
        kind: The type that is subscribed to; None before `listen`.
        listening: How it is subscribed to; None before `listen`.
        port: The subscription on the ROS thread; None before `listen`.
        offer: What the publishers offer; the last ones, while there are none.
    """

    def __init__(self, bridge: Bridge, graph: GraphCache, topic: Topic) -> None:
        self.topic = topic
        self.kind: EchoType | None = None
        self.listening: Listening | None = None
        self.port: EchoPort | None = None
        self.offer = OFFER
        self._bridge = bridge
        self._graph = graph
        self._all = False
        self._waiting: set[asyncio.Event] = set()

    @property
    def heard(self) -> Heard:
        """The messages so far, counted."""
        return Heard() if self.port is None else self.port.heard

    @property
    def is_readable(self) -> bool:
        """Whether its messages can be decoded. Others are not received."""
        return self.kind is not None and self.kind.installed

    @property
    def keeps_all(self) -> bool:
        """Whether every message is kept until it is taken: those of a latched topic for readers that come later."""
        return self._keeps(self.listening)

    def _keeps(self, listening: Listening | None) -> bool:
        return self._all or (listening is not None and listening.latched)

    def keep_all(self, *, wanted: bool) -> None:
        """Keep every message from now on, or only the newest one."""
        self._all = wanted
        self._keep()

    def _keep(self) -> None:
        if self.port is not None:
            self.port.keep(KEEP if self.keeps_all else 0)

    def tell_next(self, news: asyncio.Event) -> None:
        """Set an event at the next message."""
        self._waiting.add(news)
        if self.port is not None:
            self.port.tell_next()

    def _tell(self) -> None:
        waiting, self._waiting = self._waiting, set()
        for news in waiting:
            news.set()

    async def update(self) -> bool:
        """Follow the topic's publishers; return whether the topic or the subscription has changed.

        Raises:
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        before = self.topic
        try:
            self.topic = await self._graph.topic(before.name)
        except NotFound:  # it may come back
            self.topic = Topic(before.name, [], [])
        listening = listening_for(self.topic, self.listening)
        if listening != self.listening:
            await self.listen(listening)
            return True
        if self.topic.publishers:
            self.offer = offer_of(self.topic, listening)
        return self.topic.document() != before.document()

    async def listen(self, listening: Listening) -> None:
        """Subscribe, in place of an earlier subscription.

        Raises:
            Conflict: `topic_in_use`: the gateway itself uses the topic with another type.
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        if self.kind is None or self.kind.name != listening.kind:
            self.kind = await asyncio.to_thread(EchoType, listening.kind)
        kind, before = self.kind, self.port
        keep = KEEP if self._keeps(listening) else 0

        def change() -> EchoPort:
            if before is not None:
                before.close()
            return EchoPort(
                self._bridge,
                self.topic.name,
                kind,
                reliable=listening.reliable,
                latched=listening.latched,
                on_news=self._tell,
                heard=self.heard,
                keep=keep,
            )

        self.port, self.listening = await self._bridge.call(change, undo=EchoPort.close), listening
        self._keep()  # a reader may have come or left while the port was made
        self.offer = offer_of(self.topic, listening)
        self._tell()  # a message may have come already

    def close(self) -> None:
        """End the subscription."""
        if self.port is not None:
            self._bridge.to_ros(self.port.close)


async def wait(news: asyncio.Event, seconds: float) -> None:
    """Wait until an event is set, at most so long, and clear it."""
    try:
        async with asyncio.timeout(max(0.0, seconds)):
            await news.wait()
    except TimeoutError:
        pass
    news.clear()


def listening_for(topic: Topic, now: Listening | None) -> Listening:
    """Return how to subscribe to every publisher of a topic, and to earlier messages if all publishers keep them.

    If a topic has more than one type, which is a mistake on the graph, one of its publishers' types is used. Fixed
    transforms are published once: as in tf2, one publisher that keeps them is enough to ask for earlier messages.

    Args:
        topic: The current state of the topic.
        now: The current subscription; it is kept while there are no publishers.
    """
    publishers = topic.publishers
    if not publishers and now is not None:
        return now
    types = sorted({endpoint.type for endpoint in publishers}) or topic.types

    def all_are(name: str, value: str) -> bool:
        return bool(publishers) and all(_quality(endpoint, name) == value for endpoint in publishers)

    keeps = topic.name.endswith("/tf_static") and any(
        each.qos.reliability == "reliable" and each.qos.durability == "transient_local" for each in publishers
    )
    reliable, latched = all_are("reliability", "reliable"), all_are("durability", "transient_local")
    return Listening(types[0], reliable or keeps, latched or keeps)


def offer_of(topic: Topic, listening: Listening) -> Offer:
    """Return what the publishers of a topic offer.

    DDS does not tell how many messages a publisher keeps: it counts as one, but each publisher of transforms keeps all
    of its own.
    """
    qualities = [endpoint.qos for endpoint in topic.publishers]
    kept = 0
    if listening.latched:
        kept = MOST_KEPT if listening.kind == TRANSFORMS else min(MOST_KEPT, sum(each.depth or 1 for each in qualities))
    return Offer(any(each.reliability == "reliable" for each in qualities), kept)


def _quality(endpoint: Endpoint, name: str) -> str:
    value: str = getattr(endpoint.qos, name)
    return value
