"""The channels on which one client publishes."""

from dataclasses import dataclass
from typing import Any

from dock_gateway.core.errors import Conflict, NotFound, TooManyRequests
from dock_gateway.foxglove.forms import MessageForm, read_form, require_encoding
from dock_gateway.foxglove.protocol import ClientChannel, ClientMessage
from dock_gateway.graph.publishing import Publishing
from dock_gateway.http.parts import Parts
from dock_gateway.ros.messages.interfaces import full_type
from dock_gateway.settings import Settings
from dock_gateway.streams.graph_operations import GraphOperations
from dock_gateway.streams.rights import Rights

MAX_ADVERTISED = 100


@dataclass(frozen=True)
class Advertised:
    """A channel of a client: its topic, the type of that, and how messages are encoded."""

    topic: str
    type: str
    encoding: str
    form: MessageForm


class Publications:
    """Publishes for one client, as far as the setting `publish` and the user's grant allow it.

    The audit log has each topic that is advertised.

    Args:
        parts: Publish.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._publishing = parts[Publishing]
        self._settings = parts[Settings]
        self._operations = GraphOperations(parts, rights)
        self._rights = rights
        self._channels: dict[int, Advertised] = {}

    async def advertise(self, channel: ClientChannel) -> None:
        """Prepare for messages on a channel.

        Raises:
            GatewayError: Nothing may be published on its topic, others have another type there, or its id is in use.
        """
        require_encoding(channel.encoding)
        if channel.id in self._channels:
            raise Conflict(f"the channel {channel.id} is advertised already", code="channel_exists")
        if len(self._channels) >= MAX_ADVERTISED:
            raise TooManyRequests(f"this connection already publishes on {MAX_ADVERTISED} channels")
        topic = self._settings.resolve(channel.topic, "")

        async def look() -> dict[str, Any]:
            self._publishing.require_allowed(topic)
            found = await self._publishing.find(topic, full_type(channel.schema_name), self._rights.grant)
            form = MessageForm(await self._publishing.load(found))
            self._channels[channel.id] = Advertised(topic, found.type, channel.encoding, form)
            return {}

        await self._operations.advertise(topic, look)

    def unadvertise(self, identity: int) -> None:
        """Forget a channel. The publisher leaves after a minute without messages."""
        self._channels.pop(identity, None)

    async def publish(self, message: ClientMessage) -> None:
        """Publish a message.

        Raises:
            GatewayError: The channel is not advertised; or as `Publishing.publish`.
        """
        channel = self._channels.get(message.channel)
        if channel is None:
            raise NotFound(f"the channel {message.channel} is not advertised", code="channel_not_found")

        async def publish() -> dict[str, Any]:
            fields = await read_form(channel.form, channel.encoding, message.message)
            await self._publishing.publish(channel.topic, fields, type_name=channel.type, grant=self._rights.grant)
            return {}

        await self._operations.publish(channel.topic, publish, recorded=False)
