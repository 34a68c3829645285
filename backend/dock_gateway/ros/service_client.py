"""A client of one ROS service, created on first use."""

import asyncio
from collections.abc import Callable
from typing import Any

from rclpy.client import Client

from dock_gateway.ros.bridge import Bridge

# Seconds to find a service or a subscriber on the graph.
FIND_WITHIN = 2.0
# Seconds between the moment at which a new client has found the service and that at which the service has found it.
SETTLE = 0.3


async def until_found(bridge: Bridge, holds: Callable[[], Any]) -> None:
    """Wait until the other side is on the graph.

    Args:
        bridge: The bridge to the ROS thread.
        holds: Whether it is; called on the ROS thread.

    Raises:
        TimeoutError: It was not found.
        Unavailable: The ROS thread is down.
    """
    async with asyncio.timeout(FIND_WITHIN):
        while not await bridge.call(holds):  # noqa: ASYNC110 - DDS has no event for that
            await asyncio.sleep(0.02)


class ServiceClient:
    """Calls a service; each call has a time limit.

    Args:
        bridge: The bridge to the ROS thread.
        kind: Type of the service.
        name: Absolute name of the service.
    """

    def __init__(self, bridge: Bridge, kind: Any, name: str) -> None:
        self.name = name
        self._bridge = bridge
        self._kind = kind
        self._client: Client | None = None

    async def is_offered(self) -> bool:
        """Return whether the service is on the graph.

        Raises:
            Unavailable: The ROS thread is down.
        """
        return bool(await self._bridge.call(lambda: self._bridge.node.count_services(self.name)))

    async def call(self, request: Any, within: float, *, attempts: int = 1) -> Any:
        """Return the answer.

        Args:
            request: The request.
            within: Seconds to wait for each answer, after the service has been found.
            attempts: Maximum number of attempts.

        Raises:
            TimeoutError: The service was not found, or did not answer.
            Unavailable: The service is gone, or the ROS thread is down.
        """
        client = await self._find()
        while True:
            attempts -= 1
            pending = self._bridge.request(client, request)
            try:
                async with asyncio.timeout(within):
                    return await asyncio.shield(pending.response)
            except TimeoutError:
                pending.forget()
                if attempts <= 0:
                    raise

    def close(self) -> None:
        """Leave the graph."""
        client, self._client = self._client, None
        if client is not None:
            self._bridge.to_ros(lambda: self._bridge.node.destroy_client(client))

    async def _find(self) -> Client:
        """Return the client, once the service has found it."""
        node, known = self._bridge.node, self._client
        client: Client = known or await self._bridge.call(
            lambda: node.create_client(self._kind, self.name), undo=node.destroy_client
        )
        self._client = client
        await until_found(self._bridge, client.service_is_ready)
        if known is None:
            await asyncio.sleep(SETTLE)
        return client
