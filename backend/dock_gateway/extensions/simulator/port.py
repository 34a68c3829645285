"""Control of a simulated robot: its services, and `initialpose`, as used by RViz, to place it."""

import math
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from std_srvs.srv import SetBool, Trigger

from dock_gateway.core.scene import WORLD, Pose
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.service_client import ServiceClient, until_found

# Seconds to wait for a response. A request may get none until both sides have discovered each other.
ANSWER_WITHIN = 1.0
ATTEMPTS = 2


class SimulatorPort:
    """Clients of one simulator, each created on first use. `close` it after use.

    Args:
        bridge: The bridge to the ROS thread.
        resolve: Makes a name absolute.
    """

    def __init__(self, bridge: Bridge, resolve: Callable[[str], str]) -> None:
        self._bridge = bridge
        self._resolve = resolve
        self._clients: dict[str, ServiceClient] = {}
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
        await until_found(self._bridge, self._publisher.get_subscription_count)
        message = PoseWithCovarianceStamped()
        message.header.frame_id = WORLD
        message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
        message.pose.pose.orientation.z = math.sin(pose.theta / 2)
        message.pose.pose.orientation.w = math.cos(pose.theta / 2)
        await self._bridge.call(lambda: self._publisher.publish(message))

    def close(self) -> None:
        """Leave the graph."""
        for client in self._clients.values():
            client.close()
        publisher, self._publisher = self._publisher, None
        if publisher is not None:
            self._bridge.to_ros(lambda: self._bridge.node.destroy_publisher(publisher))

    async def _call(self, kind: Any, name: str, request: Any) -> None:
        if name not in self._clients:
            self._clients[name] = ServiceClient(self._bridge, kind, self._resolve(name))
        await self._clients[name].call(request, ANSWER_WITHIN, attempts=ATTEMPTS)
