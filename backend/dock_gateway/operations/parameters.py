"""Parameters of ROS nodes: those of any node are read, those of nodes that the settings name are set."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.access import Principal
from dock_gateway.core.grant import Role
from dock_gateway.graph.parameters import Change, Parameters
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.ros.parameter_values import Parameter

# Nodes that are asked for all their parameters.
MAX_NODES = 50


@operation(Role.VIEWER, Scope.LOOKED_AT, errors=(429, 504))
async def get_parameters(parts: Parts, principal: Principal, node: str) -> list[Parameter]:
    """Return all parameters of a node, sorted by name.

    Raises:
        GatewayError: The node is not there, or does not answer.
    """
    return await parts[Parameters].read(node, principal.grant)


@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
async def list_parameters(parts: Parts, principal: Principal, nodes: Iterable[str]) -> dict[str, list[Parameter]]:
    """Return the parameters of the first `MAX_NODES` nodes, by node; those that do not answer have none."""
    return await parts[Parameters].read_many(sorted(nodes)[:MAX_NODES], principal.grant)


@dataclass(frozen=True)
class SetParameters:
    """Parameters to set.

    Attributes:
        node: Full name of the node.
        values: The new values by name, as decoded JSON.
        at_once: Whether all are set or none.
    """

    node: str
    values: Mapping[str, Any]
    at_once: bool = True

    @property
    def subject(self) -> str:
        """The subject, for the audit log."""
        return f"{self.node} {', '.join(self.values)}"[:200]


@operation(Role.SUPERVISOR, Scope.NODE, errors=(409, 429, 504))
async def set_parameters(parts: Parts, principal: Principal, order: SetParameters) -> list[Change]:
    """Set parameters of a node. Types and ranges are checked before anything is sent.

    Raises:
        GatewayError: As `Parameters.change`.
    """
    return await parts[Parameters].change(order.node, order.values, at_once=order.at_once, grant=principal.grant)
