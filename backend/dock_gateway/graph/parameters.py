"""Reads the parameters of nodes, and sets those that the setting `allow_parameters` allows."""

import asyncio
from collections import OrderedDict
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.allow_list import AllowList
from dock_gateway.core.errors import (
    Conflict,
    FieldError,
    GatewayError,
    InvalidField,
    NotFound,
    ServerTimeout,
)
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.request import slot, turn
from dock_gateway.core.work import in_turn
from dock_gateway.graph.names import not_found
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import node_names, read_service
from dock_gateway.ros.messages.bounds import MAX_NESTED
from dock_gateway.ros.parameter_port import ParameterPort
from dock_gateway.ros.parameter_values import Parameter, unknown, value_document
from dock_gateway.settings import Settings

# Nodes that are read at the same time for all who read many: not all that `quotas` allows, so that others are not
# refused.
MANY_AT_ONCE = 4
# Nodes whose services are kept for the next request: more than are in use.
MAX_PORTS = 16
# Parameters that are set at once, and errors that are reported.
MAX_PARAMETERS, MAX_ERRORS = 100, 20


@dataclass(frozen=True)
class Change:
    """The result for one parameter: whether it was set, why not, and its value now."""

    name: str
    successful: bool
    reason: str
    value: Any

    def document(self) -> dict[str, Any]:
        """Return the document that the API shows."""
        return {"name": self.name, "successful": self.successful, "reason": self.reason, "value": self.value}


class Parameters:
    """The parameters of all nodes. Who uses it has checked that the user's grant covers the node.

    Reading asks for `Grant.covers_place`, setting for `Grant.covers_parameters`.

    Args:
        settings: Name the nodes whose parameters may be set.
        bridge: The bridge to the ROS thread.

    Attributes:
        listed: The nodes whose parameters may be set.
    """

    def __init__(self, settings: Settings, bridge: Bridge) -> None:
        self._bridge = bridge
        self.listed = AllowList("allow_parameters", settings.allow_parameters, "the gateway sets no parameters of")
        self._within = settings.accept_timeout
        self._many = asyncio.Semaphore(MANY_AT_ONCE)
        self._ports: OrderedDict[str, ParameterPort] = OrderedDict()

    def require_allowed(self, node: str) -> None:
        """Refuse a node whose parameters may not be set.

        Raises:
            NotAllowed: It is not in the setting (`not_allowed`).
        """
        self.listed.require(node)

    async def read(self, node: str, grant: Grant = UNLIMITED) -> list[Parameter]:
        """Return all parameters of a node, sorted by name.

        Args:
            node: Full name of the node.
            grant: What the user may see of the graph.

        Raises:
            NotFound: There is no such node (`node_not_found`), or it has no parameters (`parameters_not_found`).
            TooManyRequests: `too_many_calls`.
            ServerTimeout: `parameters_timeout`: it did not answer.
            Unavailable: It has left, or `ros_unavailable`.
        """
        async with self._port(node, grant) as port:
            return [*(await _read(port)).values()]

    async def read_many(self, nodes: Iterable[str], grant: Grant = UNLIMITED) -> dict[str, list[Parameter]]:
        """Return the parameters of nodes, by node; those that do not answer have none.

        Args:
            nodes: Full names of the nodes.
            grant: What the user may see of the graph.
        """

        async def read(node: str) -> tuple[str, list[Parameter]]:
            try:
                async with turn("parameters of many"), self._many:
                    return node, await self.read(node, grant)
            except GatewayError:
                return node, []

        return dict(await asyncio.gather(*map(read, nodes)))

    async def change(
        self, node: str, values: Mapping[str, object], *, at_once: bool = True, grant: Grant = UNLIMITED
    ) -> list[Change]:
        """Set parameters of a node. Nothing is sent unless every value is valid.

        Args:
            node: Full name of the node.
            values: The new values by name, as decoded JSON.
            at_once: Whether all are set or none.
            grant: What the user may see of the graph.

        Raises:
            NotAllowed: As for `require_allowed`.
            InvalidField: A parameter is unknown or read-only, or its value is of another type or out of range.
            Conflict: `parameters_refused`: the node refuses them, all of them; its reason is in the sentence.
            NotFound, TooManyRequests, Unavailable: As for `read`.
            ServerTimeout: `parameters_timeout`: it did not answer. It may have set them.
        """
        self.require_allowed(node)
        if (items := sum(len(value) for value in values.values() if isinstance(value, list))) > MAX_NESTED:
            raise InvalidField([FieldError("", f"at most {MAX_NESTED:,} values in all arrays", f"got {items:,}")])
        if not 0 < len(values) <= MAX_PARAMETERS:
            raise InvalidField([FieldError("", f"1 to {MAX_PARAMETERS} parameters by name", f"got {len(values)}")])
        async with self._port(node, grant) as port:
            parsed = await in_turn(_parse, values, await _read(port))
            results = await port.set(parsed, at_once=at_once)
            if len(results) != (1 if at_once else len(parsed)):
                raise Conflict(f"{node} does not say whether it has set them", code="parameters_refused")
            if at_once:
                if not results[0].successful:
                    reason = results[0].reason or "it gives no reason"
                    raise Conflict(f"{node} refused, and has changed nothing: {reason}", code="parameters_refused")
                results *= len(parsed)
            now = await port.messages(parsed)
        return [
            Change(name, result.successful, result.reason, value_document(now.get(name, value)))
            for (name, value), result in zip(parsed.items(), results, strict=True)
        ]

    @asynccontextmanager
    async def _port(self, node: str, grant: Grant) -> AsyncIterator[ParameterPort]:
        """Ask a node while the block runs."""
        with slot("parameters"):
            await self._require_node(node, grant)
            try:
                yield self._keep(node)
            except TimeoutError:
                raise ServerTimeout(f"{node} does not answer for its parameters", code="parameters_timeout") from None

    def _keep(self, node: str) -> ParameterPort:
        """Return the port of a node, kept from an earlier request or new: making one takes a second."""
        port = self._ports.setdefault(node, ParameterPort(self._bridge, node, self._within))
        self._ports.move_to_end(node)
        while len(self._ports) > MAX_PORTS:
            self._ports.popitem(last=False)[1].close()
        return port

    async def close(self) -> None:
        """Leave all nodes."""
        while self._ports:
            self._ports.popitem()[1].close()

    async def _require_node(self, node: str, grant: Grant) -> None:
        if await self._bridge.call(lambda: read_service(self._bridge.node, f"{node}/list_parameters")):
            return
        known = await self._bridge.call(lambda: node_names(self._bridge.node))
        if node not in known:
            raise not_found("node", node, filter(grant.covers_place, known))
        raise NotFound(f"the node {node} has no parameters that can be asked for", code="parameters_not_found")


async def _read(port: ParameterPort) -> dict[str, Parameter]:
    names = sorted(await port.names())
    values, said = await asyncio.gather(port.messages(names), port.describe(names))
    return {name: Parameter.of(name, values.get(name), said.get(name)) for name in names}


def _parse(values: Mapping[str, object], known: Mapping[str, Parameter]) -> dict[str, Any]:
    parsed: dict[str, Any] = {}
    errors: list[FieldError] = []
    for name, value in values.items():
        if len(errors) >= MAX_ERRORS:
            break
        if name not in known:
            errors.append(unknown(name, known))
            continue
        try:
            parsed[name] = known[name].parse(value)
        except InvalidField as error:
            errors += error.errors
    if errors:
        raise InvalidField(errors[:MAX_ERRORS])
    return parsed
