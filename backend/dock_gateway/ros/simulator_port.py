"""Control of a simulated robot: its services, and `initialpose`, as used by RViz, to place it."""

import asyncio
import math
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from rclpy.client import Client
from std_srvs.srv import SetBool, Trigger

from dock_gateway.core.scene import WORLD, Pose
from dock_gateway.ros.bridge import Bridge

FAULTS = (
    "dead_charger",
    "occluded_marker",
    "stuck_wheel",
    "late_commands",
    "worn_wheel",
    "wrong_detections",
    "obstacle",
    "hidden_beacon",
    "infrared_ghosts",
    "silent_battery",
    "percentage_0_to_100",
)
# Seconds to find a service or a subscriber on the graph.
FIND_WITHIN = 2.0
# Seconds to wait for a response. A request may get none until both sides have discovered each other.
ANSWER_WITHIN = 1.0
ATTEMPTS = 2


class SimulatorPort:
    """Clients of one simulator, each created on first use.

    Args:
        bridge: The bridge to the ROS thread.
        resolve: Makes a name absolute.
    """

    def __init__(self, bridge: Bridge, resolve: Callable[[str], str]) -> None:
        self._bridge = bridge
        self._resolve = resolve
        self._clients: dict[str, Client] = {}
        self._publisher: Any = None

    async def reset(self) -> None:
        """Reset robot, battery and faults to their initial state.

        Raises:
            TimeoutError: The simulator did not answer.
        """
        await self._call(Trigger, "dock_simulator/reset", Trigger.Request())

    async def switch(self, fault: str, *, active: bool) -> None:
        """Switch a fault on or off.

        Raises:
            TimeoutError: The simulator did not answer.
        """
        await self._call(SetBool, f"dock_simulator/faults/{fault}", SetBool.Request(data=active))

    async def place(self, pose: Pose) -> None:
        """Place the robot at a pose in the frame `world`.

        Raises:
            TimeoutError: The topic has no subscriber.
        """
        if self._publisher is None:
            node, topic = self._bridge.node, self._resolve("initialpose")
            self._publisher = await self._bridge.call(
                lambda: node.create_publisher(PoseWithCovarianceStamped, topic, 10), undo=node.destroy_publisher
            )
        await self._until(self._publisher.get_subscription_count)
        message = PoseWithCovarianceStamped()
        message.header.frame_id = WORLD
        message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
        message.pose.pose.orientation.z = math.sin(pose.theta / 2)
        message.pose.pose.orientation.w = math.cos(pose.theta / 2)
        await self._bridge.call(lambda: self._publisher.publish(message))

    async def _call(self, kind: Any, name: str, request: Any) -> None:
        if name not in self._clients:
            node, path = self._bridge.node, self._resolve(name)
            self._clients[name] = await self._bridge.call(
                lambda: node.create_client(kind, path), undo=node.destroy_client
            )
        client = self._clients[name]
        await self._until(client.service_is_ready)
        for attempt in range(ATTEMPTS):
            pending = self._bridge.request(client, request)
            try:
                async with asyncio.timeout(ANSWER_WITHIN):
                    await asyncio.shield(pending.response)
            except TimeoutError:
                pending.forget()
                if attempt + 1 == ATTEMPTS:
                    raise
            else:
                return

    async def _until(self, holds: Callable[[], Any]) -> None:
        async with asyncio.timeout(FIND_WITHIN):
            while not await self._bridge.call(holds):  # noqa: ASYNC110 - DDS tells nobody
                await asyncio.sleep(0.02)
