"""A client of a gateway, for Python programs: `Client`, and `AsyncClient` for asyncio.

It needs neither ROS nor a server.
"""

from dock_gateway.client.aio import AsyncClient, AsyncGoalHandle
from dock_gateway.client.documents import Battery, Event, Goal, Robot, StopReport
from dock_gateway.client.errors import ClientError, ClientTimeout, GatewayRefused, GatewayUnreachable, GoalFailed
from dock_gateway.client.sync import Client, GoalHandle
from dock_gateway.core.goal import GoalStatus

__all__ = [
    "AsyncClient",
    "AsyncGoalHandle",
    "Battery",
    "Client",
    "ClientError",
    "ClientTimeout",
    "Event",
    "GatewayRefused",
    "GatewayUnreachable",
    "Goal",
    "GoalFailed",
    "GoalHandle",
    "GoalStatus",
    "Robot",
    "StopReport",
]
