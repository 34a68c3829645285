"""Parameters of nodes, as a client of another protocol reads and sets them."""

import asyncio
from collections.abc import Iterable

from dock_gateway.http.operation import carries_out
from dock_gateway.http.parts import Parts
from dock_gateway.operations.parameters import SetParameters, get_parameters, list_parameters, set_parameters
from dock_gateway.ros.parameter_values import Parameter
from dock_gateway.streams.rights import Json, Rights


class NodeParameters:
    """The parameters that one client may read and set.

    Args:
        parts: Read and set them.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._parts = parts
        self._rights = rights
        self._reading_many = asyncio.Lock()

    async def get(self, node: str) -> list[Parameter]:
        """Return the parameters of a node.

        Raises:
            GatewayError: It may not be asked, is not there, or does not answer.
        """
        return await self._rights.perform(
            get_parameters,
            {"node": node},
            lambda: get_parameters(self._parts, self._rights.principal, node),
            recorded=False,
        )

    async def get_all(self, nodes: Iterable[str]) -> dict[str, list[Parameter]]:
        """Return the parameters of many nodes, by node; those that do not answer have none. One such call at a time."""
        await self._rights.require(list_parameters, {})
        async with self._reading_many:
            return await list_parameters(self._parts, self._rights.principal, nodes)

    @carries_out(set_parameters)
    async def set_param(self, node: str, values: Json) -> None:
        """Set parameters of a node, all or none.

        Raises:
            GatewayError: They may not be set, or the node refuses them.
        """
        order = SetParameters(node, values)
        await self._rights.perform(
            NodeParameters.set_param,  # the name that the audit log has
            {"node": node},
            lambda: set_parameters(self._parts, self._rights.principal, order),
            subject=order.subject,
        )
