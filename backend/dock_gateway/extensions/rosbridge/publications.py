"""The topics on which one client publishes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.event import utc_now
from dock_gateway.core.work import in_turn
from dock_gateway.extensions.rosbridge.protocol import stamp
from dock_gateway.extensions.rosbridge.values import reader
from dock_gateway.http.parts import Parts
from dock_gateway.operations import topics as operations
from dock_gateway.ros.messages.bounds import is_long
from dock_gateway.ros.messages.types import Nested, kinds, type_name
from dock_gateway.streams.rights import Rights

HEADER = "std_msgs/msg/Header"
MAX_ADVERTISED = 100


@dataclass(frozen=True)
class Advertised:
    """A topic on which a client publishes.

    Attributes:
        type: Its type.
        has_header: Whether its messages have a header.
        read: Converts what the client sends; None if that is not needed.
    """

    type: str
    has_header: bool
    read: Callable[[Any], Any] | None


class RosbridgePublications:
    """Publishes for one client what the setting `allow_publish` and the user's grant allow.

    The audit log has each topic that is advertised, and the first message on one that is not.

    Args:
        parts: Publish.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._parts = parts
        self._rights = rights
        self._types: dict[str, str | None] = {}  # as the client says
        self._advertised: dict[str, Advertised] = {}

    async def advertise(self, topic: str, wanted: str) -> None:
        """Note the type of a topic.

        Raises:
            GatewayError: Nothing may be published on it, or others have another type there.
        """

        async def advertise() -> None:
            if len(self._types) >= MAX_ADVERTISED:
                self._types.clear()
            self._types[topic] = wanted
            await self._prepare(topic)

        await self._rights.perform(operations.advertise, {"topic": topic}, advertise)

    def unadvertise(self, topic: str) -> None:
        """Forget a topic. Its publisher leaves after a minute without messages."""
        self._types.pop(topic, None)
        self._advertised.pop(topic, None)

    async def publish(self, topic: str, message: Any) -> None:
        """Publish a message.

        Raises:
            GatewayError: As `Publishing.publish`; or the user's grant does not reach.
        """
        known = topic in self._advertised
        await self._rights.perform(
            operations.publish, {"topic": topic}, lambda: self._publish(topic, message), recorded=not known
        )

    async def _publish(self, topic: str, message: Any) -> None:
        known = self._advertised.get(topic) or await self._prepare(topic)
        if known.has_header and isinstance(message, dict):
            header = message.get("header") or {}
            if isinstance(header, dict) and header.get("stamp") is None:
                message = {**message, "header": {**header, "stamp": stamp(utc_now())}}
        if known.read is not None:
            message = await in_turn(known.read, message) if is_long(message) else known.read(message)
        order = operations.Publish(topic, message, known.type)
        await operations.publish(self._parts, self._rights.principal, order)

    async def _prepare(self, topic: str) -> Advertised:
        wanted = operations.Advertise(topic, self._types.get(topic))
        found, kind = await operations.advertise(self._parts, self._rights.principal, wanted)
        header = kinds(kind).get("header")
        has_header = isinstance(header, Nested) and type_name(header.message_class) == HEADER
        if len(self._advertised) >= MAX_ADVERTISED:
            self._advertised.clear()
        known = self._advertised[topic] = Advertised(found.type, has_header, reader(kind))
        return known
