"""A relayed topic: one subscription for all clients, each message encoded once for each compression."""

import asyncio
import logging
import time
from asyncio import Task
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from dock_gateway.core.errors import GatewayError, NotFound
from dock_gateway.core.event import websocket_frame
from dock_gateway.core.graph import Topic
from dock_gateway.core.tasks import cancel
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.subscription import Listening, TopicSubscription, listening_for
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.raw_port import EchoType
from dock_gateway.rosbridge import cbor, png
from dock_gateway.rosbridge.protocol import Compression, published
from dock_gateway.rosbridge.protocol import png as png_message
from dock_gateway.rosbridge.values import cbor_values, json_values

log = logging.getLogger(__name__)

# Seconds between two checks of a topic: who publishes it, and how.
TICK = 1.0
# Messages that are kept while earlier ones are encoded.
KEEP = 200
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
    """A message on a topic.

    Attributes:
        size: Its number of bytes in ROS.
    """

    def __init__(self, topic: str, kind: EchoType, message: bytes) -> None:
        self.size = len(message)
        self._received_ns = time.time_ns()
        self._topic = topic
        self._kind = kind
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
                    return self._packed(cbor_values(self._kind.decode(self._message)))
            text = published(self._topic, json_values(self._kind.decode(self._message)))
            return Payload(png_message(png.encode(text)) if compression is Compression.png else text, binary=False)
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            log.debug("a message on %s cannot be read as %s: %s", self._topic, self._kind.name, error)
            return None

    def _raw(self) -> dict[str, Any]:
        seconds, nanoseconds = divmod(self._received_ns, 1_000_000_000)
        return {"secs": seconds, "nsecs": nanoseconds, "bytes": self._message}

    def _packed(self, message: dict[str, Any]) -> Payload:
        return Payload(cbor.encode({"op": "publish", "topic": self._topic, "msg": message}), binary=True)


class Outlet(Protocol):
    """A client's end of a relayed topic."""

    async def offer(self, message: Published) -> None:
        """Take a message; waits for nothing but its encoding."""


class Relay:
    """One topic, for all its clients.

    Args:
        bridge: Runs calls on the ROS thread.
        graph: Knows the endpoints of the topic.
        topic: The current state of the topic.
        tick: See `TICK`.

    Attributes:
        outlets: The clients.
    """

    def __init__(self, bridge: Bridge, graph: GraphCache, topic: Topic, tick: float = TICK) -> None:
        self.outlets: set[Outlet] = set()
        self._tick = tick
        self._subscription = TopicSubscription(bridge, graph, topic, KEEP)
        self._newest: Published | None = None
        self._task: Task[None] | None = None

    @property
    def kind(self) -> str:
        """The type of the topic."""
        kind = self._subscription.kind
        return "" if kind is None else kind.name

    async def open(self, type_name: str | None) -> None:
        """Subscribe to the topic.

        Args:
            type_name: Its type, if nobody has the topic yet.

        Raises:
            NotFound: Its messages cannot be read: their package is not installed (`interface_not_found`).
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        subscription = self._subscription
        types = subscription.topic.types or [type_name or ""]
        at_first = Listening(types[0], reliable=False, latched=False)
        await subscription.listen(listening_for(subscription.topic, at_first))
        if (kind := subscription.kind) is None or not kind.installed:
            raise NotFound(f"{subscription.topic.name}: {kind and kind.hint}", code="interface_not_found")
        self._task = asyncio.create_task(self._run())

    async def close(self) -> None:
        """End the subscription."""
        if self._task is not None:
            await cancel(self._task)
        self._subscription.close()

    async def add(self, outlet: Outlet) -> None:
        """Add a client. If the topic's publishers keep earlier messages, the client gets the last one."""
        if self._newest is not None:
            await outlet.offer(self._newest)
        self.outlets.add(outlet)

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        tick = loop.time() + self._tick
        while True:
            try:
                await self._subscription.wait(tick - loop.time())
                await self._pass_on()
                if loop.time() >= tick:
                    tick = loop.time() + self._tick
                    await self._subscription.look_again()
            except GatewayError as error:
                log.warning("cannot subscribe to %s: %s", self._subscription.topic.name, error.detail)
            except Exception:
                log.exception("while reading %s", self._subscription.topic.name)
                await asyncio.sleep(self._tick)

    async def _pass_on(self) -> None:
        heard = self._subscription
        if heard.port is None or heard.kind is None:
            return
        heard.port.tell_next()  # before the take: what comes after it is told, and does not wait for the next message
        for message in heard.port.take():
            newest = Published(heard.topic.name, heard.kind, message)
            for outlet in tuple(self.outlets):
                await outlet.offer(newest)
            self._newest = newest if heard.listening is not None and heard.listening.latched else None
