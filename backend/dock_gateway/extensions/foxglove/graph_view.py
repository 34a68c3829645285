"""The ROS graph as one client sees it: its channels, its services, and who is connected to what."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import TypeVar

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Role
from dock_gateway.core.graph import GraphScan
from dock_gateway.extensions.foxglove import protocol
from dock_gateway.extensions.foxglove.channels import Channels
from dock_gateway.extensions.foxglove.connections import Connections
from dock_gateway.extensions.foxglove.services import FoxgloveServices
from dock_gateway.extensions.foxglove.subscriptions import FoxgloveSubscriptions
from dock_gateway.graph.cache import GraphCache
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.streams.rights import Rights

log = logging.getLogger(__name__)

# Seconds between two scans of the graph.
SCAN_INTERVAL = 2.0
# Channels or services in one message: a definition has kilobytes, and a client may not read.
AT_ONCE = 20

Item = TypeVar("Item")


class GraphView:
    """Follows the graph for one client.

    Args:
        graph: The graph.
        rights: Those of the client's user.
        services: The client's services.
        subscriptions: The client's subscriptions, which end with their channels.
        send: Sends a message to the client.
        scan_interval: Seconds between two scans of the graph.

    Attributes:
        channels: The client's channels.
        changing: Held while channels and subscriptions change.
    """

    def __init__(
        self,
        graph: GraphCache,
        rights: Rights,
        services: FoxgloveServices,
        subscriptions: FoxgloveSubscriptions,
        send: Callable[[bytes], Awaitable[None]],
        *,
        scan_interval: float = SCAN_INTERVAL,
    ) -> None:
        self.channels = Channels(rights.grant)
        self.changing = asyncio.Lock()
        self._graph = graph
        self._rights = rights
        self._services = services
        self._subscriptions = subscriptions
        self._send = send
        self._scan_interval = scan_interval
        self._seen: GraphScan | None = None
        self._connections: Connections | None = None  # as sent to the client; None: it has not subscribed to them

    async def follow(self) -> None:
        """Tell the client what there is, and what has changed, for as long as it is connected."""
        await self._send(protocol.advertise(()))
        while True:
            try:
                seen = (await self._graph.graph()).seen
            except GatewayError as error:
                log.info("cannot read the ROS graph: %s", error.detail)
            else:
                await self._show(seen)
            await asyncio.sleep(self._scan_interval)

    async def _show(self, seen: GraphScan) -> None:
        if seen is not self._seen:
            self._seen = seen
            async with self.changing:
                async with self._rights.turn("graph views"):
                    new, gone = await self.channels.update(seen)
                for channel in gone:
                    await self._subscriptions.leave(channel)
            await self._tell(protocol.unadvertise, [each.id for each in gone])
            await self._tell(protocol.advertise, [each.document() for each in new])
            await self._show_connections()
        async with self._rights.turn("graph views"):
            offered, withdrawn = await self._services.update(seen)  # actions are known a moment after their topics
        await self._tell(protocol.unadvertise_services, [each.id for each in withdrawn])
        await self._tell(protocol.advertise_services, [each.document() for each in offered])

    async def _tell(self, message: Callable[[list[Item]], bytes], items: list[Item]) -> None:
        for at in range(0, len(items), AT_ONCE):
            await self._send(message(items[at : at + AT_ONCE]))
            await asyncio.sleep(0)  # sending may not wait, and a fleet has thousands

    @operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
    async def show_connections(self) -> None:
        """Tell the client which nodes are at each topic and service, and changes of that."""
        await self._rights.require(GraphView.show_connections, {})
        if self._connections is None:
            self._connections = Connections()
            await self._show_connections()

    def hide_connections(self) -> None:
        """Tell it no more."""
        self._connections = None

    async def _show_connections(self) -> None:
        before = self._connections
        if before is None or self._seen is None:
            return
        async with self._rights.turn("graph views"):
            self._connections = now = await asyncio.to_thread(Connections.of, self._seen, self._rights.grant)
        if (update := now.changes_since(before)) is not None:
            await self._send(encode(update))
