"""Reads the parameters of a ROS node, by the services that every node has."""

import asyncio
from collections.abc import Iterable, Mapping
from typing import Any

from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.parameter import parameter_value_to_python

from dock_gateway.core.graph import ACTION_PART, STATUS
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import read_topic
from dock_gateway.ros.service_client import FIND_WITHIN, ServiceClient

# Seconds to wait for each answer.
ANSWER_WITHIN = 1.5
# Requests for single parameters at the same time, where a node does not answer for all of them at once.
AT_ONCE = 20


class ParameterReader:
    """The parameters of one node. `close` it after use.

    Args:
        bridge: The bridge to the ROS thread.
        node: Full name of the node.
        find_within: Seconds to find the node's services.
        attempts: Maximum number of attempts of each request.
    """

    def __init__(self, bridge: Bridge, node: str, find_within: float = FIND_WITHIN, attempts: int = 1) -> None:
        self._attempts = attempts
        self._lister = ServiceClient(bridge, ListParameters, f"{node}/list_parameters", find_within)
        self._getter = ServiceClient(bridge, GetParameters, f"{node}/get_parameters", find_within)

    async def names(self) -> frozenset[str]:
        """Return the names of all parameters.

        Raises:
            TimeoutError: The node does not answer.
            Unavailable: It is gone, or the ROS thread is down.
        """
        answer = await self._lister.call(ListParameters.Request(), ANSWER_WITHIN, attempts=self._attempts)
        return frozenset(answer.result.names)

    async def values(self, names: Iterable[str]) -> Mapping[str, Any]:
        """Return the values of parameters, by name; without those that are not set or of an unknown type.

        Raises:
            TimeoutError: The node does not answer.
            Unavailable: It is gone, or the ROS thread is down.
        """
        found = await self.messages(names)
        values = {name: read_value(value) for name, value in found.items()}
        return {name: value for name, value in values.items() if value is not None}

    async def messages(self, names: Iterable[str]) -> Mapping[str, ParameterValue]:
        """Return the values as messages, by name; without those that the node does not have.

        Raises:
            TimeoutError, Unavailable: As for `values`.
        """
        wanted = list(names)
        values = await self._get(wanted)
        if len(values) != len(wanted):  # a parameter that is not set fails the whole request
            limit = asyncio.Semaphore(AT_ONCE)

            async def get(name: str) -> ParameterValue | None:
                async with limit:
                    return next(iter(await self._get([name])), None)

            values = await asyncio.gather(*map(get, wanted))
        return {name: value for name, value in zip(wanted, values, strict=True) if value is not None}

    async def _get(self, names: list[str]) -> list[ParameterValue | None]:
        if not names:
            return []
        answer = await self._getter.call(GetParameters.Request(names=names), ANSWER_WITHIN, attempts=self._attempts)
        return list(answer.values)

    def close(self) -> None:
        """Leave the graph."""
        self._lister.close()
        self._getter.close()


def read_value(value: ParameterValue) -> Any:
    """Return a parameter's value; None if it is not set, or of an unknown type."""
    try:
        return parameter_value_to_python(value)
    except RuntimeError:  # its type is unknown
        return None


async def find_servers(bridge: Bridge, action: str) -> list[tuple[str, bytes]]:
    """Return the full names of the nodes that serve an action, each with the GID of its endpoint; at most one, usually.

    Raises:
        Unavailable: The ROS thread is down.
    """
    topic = await bridge.call(lambda: read_topic(bridge.node, f"{action}{ACTION_PART}{STATUS}"))
    return [(publisher.node, publisher.gid) for publisher in topic.publishers if publisher.node is not None]
