"""A client of one ROS service, created on first use."""

import asyncio
from collections.abc import Callable
from typing import Any

from rclpy.client import Client

from dock_gateway.core.errors import Unavailable
from dock_gateway.ros.bridge import Bridge
from robot_io.rclpy_private import InvalidHandle

# Seconds to find a service or a subscriber on the graph.
FIND_WITHIN = 2.0
# Seconds between the moment at which a new client has found the service and that at which the service has found it.
SETTLE = 0.3
# Seconds between two checks whether the service that is to answer is still there.
CHECK_INTERVAL = 0.5


async def until_found(bridge: Bridge, holds: Callable[[], Any], within: float = FIND_WITHIN) -> None:
    """Wait until the other side is on the graph.

    Args:
        bridge: The bridge to the ROS thread.
        holds: Whether it is; called on the ROS thread.
        within: Seconds to wait.

    Raises:
        TimeoutError: It was not found.
        Unavailable: The ROS thread is down.
    """
    async with asyncio.timeout(within):
        while not await bridge.call(holds):  # noqa: ASYNC110 - DDS has no event for that
            await asyncio.sleep(0.02)


class ServiceClient:
    """Calls a service; each call has a time limit.

    Args:
        bridge: The bridge to the ROS thread.
        kind: Type of the service.
        name: Absolute name of the service.
        find_within: Seconds to find the service.
    """

    def __init__(self, bridge: Bridge, kind: Any, name: str, find_within: float = FIND_WITHIN) -> None:
        self._find_within = find_within
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

    async def ask(self, request: Any, within: float, before: Callable[[], None]) -> Any:
        """Return the answer to a request that is sent once. Unlike `call`, notice that the service leaves.

        Args:
            request: The request.
            within: Seconds to wait for the answer, after the service has been found.
            before: Called right before the request is sent; an exception of it ends the call.

        Raises:
            TimeoutError: It was found and did not answer.
            Unavailable: It is not reached (`service_unavailable`) or has left (`service_gone`), or the ROS thread is
                down.
        """
        gone = Unavailable(f"{self.name} is not reached: its server is gone", code="service_unavailable")
        try:
            client = await self._find()
        except TimeoutError:
            raise gone from None
        before()
        if not self._is_ready(client):
            raise gone
        pending = self._bridge.request(client, request)
        try:
            async with asyncio.timeout(within):
                while not pending.response.done():
                    await asyncio.wait({pending.response}, timeout=CHECK_INTERVAL)
                    if not (pending.response.done() or self._is_ready(client)):
                        detail = f"the server of {self.name} has left; it may have carried out the call"
                        raise Unavailable(detail, code="service_gone")
            return pending.response.result()
        finally:
            if not pending.response.done():
                pending.forget()

    @staticmethod
    def _is_ready(client: Client) -> bool:
        try:
            return bool(client.service_is_ready())
        except InvalidHandle:
            return False

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
        await until_found(self._bridge, client.service_is_ready, self._find_within)
        if known is None:
            await asyncio.sleep(SETTLE)
        return client
