"""A topic that is read while it is needed, if it is published with the type that is expected."""

import logging
from collections.abc import Sequence
from contextlib import suppress

from dock_gateway.core.errors import GatewayError, NotFound
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.received import Received
from dock_gateway.graph.relay import Outlet
from dock_gateway.graph.relays import Relays

log = logging.getLogger(__name__)

# The most bytes of a message that is read. Decoding one holds up everything else, a stop included: 0.5 MB of
# poses or transforms, 6,000 of them, take 0.2 s.
MOST_BYTES = 500_000


class TopicReader:
    """Passes the messages of a topic on, once it has a publisher.

    Args:
        relays: The relayed topics.
        graph: Knows who publishes what.
        topic: Absolute name.
        type_name: The type that is expected.
        outlet: Receives the messages.
        most: The most bytes of a message that is passed on.

    Attributes:
        hint: Why there is nothing to read; None if there is.
        there: Whether it is published at all.
    """

    def __init__(
        self,
        relays: Relays,
        graph: GraphCache,
        topic: str,
        type_name: str,
        outlet: Outlet,
        *,
        most: int = MOST_BYTES,
    ) -> None:
        self.topic = topic
        self.hint: str | None = None
        self.there = False
        self._relays = relays
        self._graph = graph
        self._type = type_name
        self._outlet = outlet
        self._most = most
        self._joined = False

    async def check(self) -> None:
        """Join the topic if it is there."""
        if self._joined:
            return
        types = await published_types(self._graph, self.topic)
        self.there = bool(types)
        if types and self._type not in types:
            self._doubt(self._mistyped(types[0]))
            return
        self.hint = None if types else f"Nothing is published on {self.topic} ({self._type})."
        if not types:
            return
        try:
            await self._relays.join(self.topic, self._type, self)
        except GatewayError as error:
            self.hint = f"{self.topic} cannot be read: {error.detail}"
            return
        self._joined = True

    async def offer(self, message: Received) -> None:
        """Pass a message on, if it is of the right type, and not too large."""
        if message.kind.name != self._type:
            self._doubt(self._mistyped(message.kind.name))
            return
        if message.size > self._most:
            self._doubt(f"A message on {self.topic} has more than {self._most / 1e6:g} MB, and is not read.")
            return
        self.hint = None
        await self._outlet.offer(message)

    def _mistyped(self, type_name: str) -> str:
        return f"{self.topic} is of the type {type_name}, not {self._type}."

    def _doubt(self, hint: str) -> None:
        if hint != self.hint:
            log.warning("%s", hint)
        self.hint = hint

    async def close(self) -> None:
        """Leave the topic."""
        if self._joined:
            self._joined = False
            await self._relays.leave(self.topic, self)


async def published_types(graph: GraphCache, *topics: str) -> list[str]:
    """Return the types with which some topics are published; none if none of them is."""
    types: set[str] = set()
    for topic in topics:
        with suppress(NotFound):
            types.update(endpoint.type for endpoint in (await graph.topic(topic)).publishers)
    return sorted(types)


async def find_topic(
    graph: GraphCache, names: Sequence[str], type_name: str, *, suffixes: Sequence[str] = ("",)
) -> str:
    """Return the first of some topics that is published with a type; else the first that is published, or the first.

    Args:
        graph: Knows who publishes what.
        names: Absolute names of the topics.
        type_name: The type that is expected.
        suffixes: A topic counts as published if it is with one of them behind its name.
    """
    if len(names) == 1:
        return names[0]
    types = [await published_types(graph, *(f"{name}{suffix}" for suffix in suffixes)) for name in names]
    right = [name for name, found in zip(names, types, strict=True) if type_name in found]
    there = [name for name, found in zip(names, types, strict=True) if found]
    return next(iter((*right, *there)), names[0])
