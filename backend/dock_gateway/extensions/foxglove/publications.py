"""The channels on which one client publishes."""

from dataclasses import dataclass

from dock_gateway.core.errors import Conflict, NotFound, TooManyRequests
from dock_gateway.extensions.foxglove.forms import MessageForm, read_form, require_encoding
from dock_gateway.extensions.foxglove.protocol import ClientChannel, ClientMessage
from dock_gateway.http.parts import Parts
from dock_gateway.operations import topics as operations
from dock_gateway.ros.messages.interfaces import full_type
from dock_gateway.settings import Settings
from dock_gateway.streams.rights import Rights

MAX_ADVERTISED = 100


@dataclass(frozen=True)
class Advertised:
    """A channel of a client: its topic, the type of that, and how messages are encoded."""

    topic: str
    type: str
    encoding: str
    form: MessageForm


class FoxglovePublications:
    """Publishes for one client what the setting `allow_publish` and the user's grant allow.

    The audit log has each topic that is advertised.

    Args:
        parts: Publish.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._parts = parts
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
        topic = self._parts[Settings].resolve(channel.topic, "")

        async def advertise() -> None:
            wanted = operations.Advertise(topic, full_type(channel.schema_name))
            found, kind = await operations.advertise(self._parts, self._rights.principal, wanted)
            self._channels[channel.id] = Advertised(topic, found.type, channel.encoding, MessageForm(kind))

        await self._rights.perform(operations.advertise, {"topic": topic}, advertise)

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

        async def publish() -> None:
            fields = await read_form(channel.form, channel.encoding, message.message)
            order = operations.Publish(channel.topic, fields, channel.type)
            await operations.publish(self._parts, self._rights.principal, order)

        await self._rights.perform(operations.publish, {"topic": channel.topic}, publish, recorded=False)
