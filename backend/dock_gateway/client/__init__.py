"""A client of a gateway, for Python programs: `Client`, and `AsyncClient` for asyncio.

It needs neither ROS nor a server.
"""

from dock_gateway.client.aio import AsyncClient, AsyncGoal
from dock_gateway.client.documents import Battery, Event, GoalState, Robot, StopReport
from dock_gateway.client.errors import ClientError, ClientTimeout, GatewayRefused, GatewayUnreachable, GoalFailed
from dock_gateway.client.sync import Client, Goal
from dock_gateway.core.goal import GoalStatus

__all__ = [
    "AsyncClient",
    "AsyncGoal",
    "Battery",
    "Client",
    "ClientError",
    "ClientTimeout",
    "Event",
    "GatewayRefused",
    "GatewayUnreachable",
    "Goal",
    "GoalFailed",
    "GoalState",
    "GoalStatus",
    "Robot",
    "StopReport",
]
