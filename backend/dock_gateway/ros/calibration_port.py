"""The service `calibrate_dock` of a robot's docking server."""

import asyncio
from typing import Any

from rclpy.client import Client
from std_srvs.srv import Trigger

from dock_gateway.ros.bridge import Bridge

# Seconds to find the service on the graph.
FIND_WITHIN = 2.0
# Seconds between the moment at which a new client has found the service and that at which the service has found it.
SETTLE = 0.3
# Seconds to wait for an answer. A calibration takes up to 10 s.
ANSWER_WITHIN = 16.0


class CalibrationPort:
    """A client of the service, created on first use.

    Args:
        bridge: The bridge to the ROS thread.
        service: Absolute name.
    """

    def __init__(self, bridge: Bridge, service: str) -> None:
        self.service = service
        self._bridge = bridge
        self._client: Client | None = None

    async def is_offered(self) -> bool:
        """Return whether the service is on the graph.

        Raises:
            Unavailable: The ROS thread is down.
        """
        return bool(await self._bridge.call(lambda: self._bridge.node.count_services(self.service)))

    async def calibrate(self) -> tuple[bool, str]:
        """Return whether the dock was calibrated, and the server's text.

        Raises:
            TimeoutError: The server did not answer.
            Unavailable: The service is not there, or the ROS thread is down.
        """
        client = await self._find()
        pending = self._bridge.request(client, Trigger.Request())
        try:
            async with asyncio.timeout(ANSWER_WITHIN):
                answer: Any = await asyncio.shield(pending.response)
        except TimeoutError:
            pending.forget()
            raise
        return answer.success, answer.message

    async def _find(self) -> Client:
        """Return the client, once the service has found it."""
        node, known = self._bridge.node, self._client
        client: Client = known or await self._bridge.call(
            lambda: node.create_client(Trigger, self.service), undo=node.destroy_client
        )
        self._client = client
        async with asyncio.timeout(FIND_WITHIN):
            while not await self._bridge.call(client.service_is_ready):  # noqa: ASYNC110 - DDS tells nobody
                await asyncio.sleep(0.02)
        if known is None:
            await asyncio.sleep(SETTLE)
        return client
