"""The topics that one client may subscribe to, with the ids by which it knows them."""

import asyncio
import zlib
from collections.abc import Iterable, Iterator
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from itertools import islice
from typing import Any

from dock_gateway.core.filters import is_hidden
from dock_gateway.core.grant import Grant
from dock_gateway.core.graph import ACTION_PART, FEEDBACK, STATUS, GraphScan, Topic
from dock_gateway.extensions.foxglove.protocol import SCHEMA_ENCODING
from dock_gateway.ros.messages.full_definition import full_definition
from dock_gateway.ros.messages.interfaces import load_message

# The most topics that are advertised to a client.
MAX_CHANNELS = 5000


@dataclass(frozen=True)
class Channel:
    """A topic of one type."""

    id: int
    topic: str
    type: str
    schema: str

    def document(self) -> dict[str, Any]:
        """Return the channel as it is advertised."""
        return {
            "id": self.id,
            "topic": self.topic,
            "encoding": "cdr",
            "schemaName": self.type,
            "schemaEncoding": SCHEMA_ENCODING,
            "schema": self.schema,
        }


class Channels:
    """The channels of one client.

    Args:
        grant: The grant of its user.
    """

    def __init__(self, grant: Grant) -> None:
        self._grant = grant
        self._channels: dict[int, Channel] = {}

    def find(self, identity: int) -> Channel | None:
        """Return a channel by its id."""
        return self._channels.get(identity)

    async def update(self, seen: GraphScan) -> tuple[list[Channel], list[Channel]]:
        """Follow the graph; return the channels that are new, and those that are gone."""
        known = {(each.topic, each.type): each for each in self._channels.values()}
        wanted, schemas = await asyncio.to_thread(self._find, seen, known.keys())
        gone = [each for key, each in known.items() if wanted.get(key[0]) != key[1]]
        for channel in gone:
            del self._channels[channel.id]
        new = []
        for topic, kind in sorted(wanted.items() - known.keys()):
            if (schema := schemas.get(kind)) is not None:
                identity = unused_id(f"{topic} {kind}", self._channels)
                self._channels[identity] = channel = Channel(identity, topic, kind, schema)
                new.append(channel)
        return new, gone

    def _find(self, seen: GraphScan, known: AbstractSet[tuple[str, str]]) -> tuple[dict[str, str], dict[str, str]]:
        """Return the types of topics, and the definitions of those that are new; takes long, so it runs in a thread."""
        wanted = dict(islice(self._offered(seen), MAX_CHANNELS))
        return wanted, _schemas({kind for _, kind in wanted.items() - known})

    def _offered(self, seen: GraphScan) -> Iterator[tuple[str, str]]:
        """Yield the topics that the user may read, with their types."""
        for name, topic in sorted(seen.topics.items()):
            if topic.types and not _is_internal(name) and self._grant.covers_topic(name):
                yield name, _type_of(topic)


def unused_id(name: str, used: Iterable[int]) -> int:
    """Return an id for a name: the same one for each connection, unless others have it already."""
    identity = zlib.crc32(name.encode())
    while identity in used:
        identity = (identity + 1) % 2**32
    return identity


def _is_internal(name: str) -> bool:
    """Return whether a topic is hidden. The feedback and the status of an action are as visible as the action."""
    action, of_action, part = name.partition(ACTION_PART)
    return is_hidden(action if of_action and part in (FEEDBACK, STATUS) else name)


def _type_of(topic: Topic) -> str:
    """Return the type that is subscribed to if a topic has several, which is a mistake on the graph."""
    return min((endpoint.type for endpoint in topic.publishers), default=topic.types[0])


def _schemas(types: Iterable[str]) -> dict[str, str]:
    """Return the definitions of message types, of those that are installed."""
    found = {}
    for name in types:
        try:
            found[name] = full_definition(load_message(name))
        except (ImportError, TypeError):
            continue
    return found
