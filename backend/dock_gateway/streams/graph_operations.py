"""What clients of other protocols do on the ROS graph: each operation is declared once, whichever protocol asks."""

import asyncio
from collections.abc import Iterable

from dock_gateway.core.grant import Role
from dock_gateway.graph.parameters import Change, Parameters
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.ros.parameter_values import Parameter
from dock_gateway.streams.rights import Do, Json, Rights

# Nodes that are asked for all their parameters.
MAX_NODES = 50


class GraphOperations:
    """The operations of one client.

    Args:
        parts: Carry them out.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._parameters = parts[Parameters]
        self._rights = rights
        self._reading_many = asyncio.Lock()

    @operation(Role.OPERATOR, Scope.SERVICE)
    async def call_service(self, service: str, do: Do) -> Json:
        """Call a service of a ROS node, as `do` does. Return its answer.

        Raises:
            GatewayError: It may not be called, or failed.
        """
        return await self._rights.carry_out(GraphOperations.call_service, {"service": service}, do)

    @operation(Role.OPERATOR, Scope.PUBLISHING)
    async def advertise(self, topic: str, do: Do) -> None:
        """Prepare for messages on a topic, as `do` does.

        Raises:
            GatewayError: Nothing may be published on it, or that failed.
        """
        await self._rights.carry_out(GraphOperations.advertise, {"topic": topic}, do)

    @operation(Role.OPERATOR, Scope.PUBLISHING)
    async def publish(self, topic: str, do: Do, *, recorded: bool) -> None:
        """Publish a message, as `do` does.

        Args:
            topic: Absolute name of the topic.
            do: Publishes it.
            recorded: Whether the audit log has it; else it has that the topic was advertised.

        Raises:
            GatewayError: It may not be published, or that failed.
        """
        fields = {"topic": topic}
        if recorded:
            await self._rights.carry_out(GraphOperations.publish, fields, do)
        else:
            await self._rights.require(GraphOperations.publish, fields)
            await do()

    @operation(Role.VIEWER, Scope.PLACE, Audit.NEVER)
    async def get_param(self, node: str) -> list[Parameter]:
        """Return the parameters of a node.

        Raises:
            GatewayError: It may not be asked, is not there, or does not answer.
        """
        await self._rights.require(GraphOperations.get_param, {"node": node})
        return await self._parameters.read(node, self._rights.grant)

    @operation(Role.SUPERVISOR, Scope.NODE)
    async def set_param(self, node: str, values: Json) -> list[Change]:
        """Set parameters of a node, all or none.

        Raises:
            GatewayError: They may not be set, or it refuses them.
        """
        changes: list[Change] = []

        async def change() -> Json:
            changes.extend(await self._parameters.change(node, values, grant=self._rights.grant))
            return {}

        subject = f"{node} {', '.join(values)}"[:200]
        await self._rights.carry_out(GraphOperations.set_param, {"node": node}, change, subject=subject)
        return changes

    @operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
    async def get_params(self, nodes: Iterable[str]) -> dict[str, list[Parameter]]:
        """Return the parameters of many nodes, by node; those that do not answer have none. One such call at a time."""
        await self._rights.require(GraphOperations.get_params, {})
        async with self._reading_many:
            return await self._parameters.read_many(sorted(nodes)[:MAX_NODES], self._rights.grant)
