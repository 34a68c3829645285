"""Topics of the ROS graph: they are read, and messages are published on those that the settings name."""

from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.access import Principal
from dock_gateway.core.grant import Role
from dock_gateway.core.request import slot
from dock_gateway.graph.publishing import FoundTopic, Publishing, SentMessage
from dock_gateway.graph.relay import Outlet
from dock_gateway.graph.relays import Relays
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.ros.messages.types import MessageClass


@dataclass(frozen=True)
class ReadTopic:
    """A topic to read.

    Attributes:
        topic: Absolute name of the topic.
        outlet: Receives each message as bytes, decoded at most once for all readers.
        type: Its type, as the reader knows it; needed if no one has the topic yet.
    """

    topic: str
    outlet: Outlet
    type: str | None = None


@operation(Role.VIEWER, Scope.TOPIC, Audit.NEVER)
async def subscribe(parts: Parts, _: Principal, order: ReadTopic) -> AsyncExitStack:
    """Read a topic until what is returned is closed.

    Raises:
        GatewayError: As `Relays.join`.
        TooManyRequests: The user has too many topics, or all users together.
    """
    relays = parts[Relays]
    async with AsyncExitStack() as reading:
        reading.enter_context(slot("topics", order.topic))
        await relays.join(order.topic, order.type, order.outlet)
        reading.push_async_callback(relays.leave, order.topic, order.outlet)
        return reading.pop_all()


@dataclass(frozen=True)
class Publish:
    """A message to publish.

    Attributes:
        topic: Absolute name of the topic.
        message: The message, or its fields as decoded JSON; those that are left out get their default.
        type: Its type; needed if no one is on the topic, or if others have several types there.
    """

    topic: str
    message: Any
    type: str | None = None


@operation(Role.OPERATOR, Scope.PUBLISHING, errors=(409,))
async def publish(parts: Parts, principal: Principal, order: Publish) -> SentMessage:
    """Publish one message on a topic.

    Raises:
        GatewayError: As `Publishing.publish`.
    """
    return await parts[Publishing].publish(order.topic, order.message, type_name=order.type, grant=principal.grant)


@dataclass(frozen=True)
class Advertise:
    """A topic that messages will be published on; without `type`, it is that of the others there."""

    topic: str
    type: str | None = None


@operation(Role.OPERATOR, Scope.PUBLISHING)
async def advertise(parts: Parts, principal: Principal, order: Advertise) -> tuple[FoundTopic, MessageClass]:
    """Prepare for messages on a topic. Return it, and the class of its messages.

    Raises:
        GatewayError: Nothing may be published on it, or others have another type there.
    """
    publishing = parts[Publishing]
    publishing.require_allowed(order.topic)
    found = await publishing.find(order.topic, order.type, principal.grant)
    return found, await publishing.load(found)
