"""Parameters of nodes, for one client: `/node.parameter`. It reads, sets and subscribes to them."""

import asyncio
from base64 import b64decode, b64encode
from binascii import Error as NoBase64
from collections.abc import Awaitable, Callable, Iterable
from typing import Any

from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, NotInstalled, TooManyRequests
from dock_gateway.core.grant import Role
from dock_gateway.core.work import in_turns
from dock_gateway.extensions.foxglove.protocol import MAX_PARAMETERS, Json, ParameterIn
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.parameter_events import EVENT_TYPE, EVENTS, read_event
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.ros.parameter_values import plain_value
from dock_gateway.streams.node_parameters import NodeParameters
from dock_gateway.streams.rights import Rights

SEPARATOR = "."
# The parameter types of the protocol, by those of ROS.
BYTE_ARRAY = "byte_array"
TYPES = {"double": "float64", "double array": "float64_array", "byte array": BYTE_ARRAY}


class ClientParameters:
    """The parameters of one client.

    Args:
        parts: Read and set them.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._parts = parts
        self._rights = rights
        self._nodes = NodeParameters(parts, rights)
        self._wanted: set[str] | None = set()  # None: all
        self._listening = False
        self._changed: dict[str, Json] = {}
        self._waiting = asyncio.Event()

    async def get(self, names: list[str]) -> tuple[list[Json], list[str]]:
        """Return the parameters with these names, all without names; and what was not possible."""
        if not names:
            seen = (await self._parts[GraphCache].graph(self._rights.grant)).seen
            nodes = await self._nodes.get_all(seen.nodes)
            return [parameter_document(node, each.name, each.value) for node in nodes for each in nodes[node]], []
        found: list[Json] = []
        errors: list[str] = []
        async for node, wanted in in_turns(_by_node(names).items()):
            try:
                known = {each.name: each.value for each in await self._nodes.get(node)}
            except GatewayError as error:
                errors.append(error.detail)
            else:
                found += [parameter_document(node, name, known[name]) for name in wanted if name in known]
        return found, errors

    async def set(self, parameters: Iterable[ParameterIn]) -> list[str]:
        """Set parameters, those of each node all or none; return what was not possible."""
        nodes: dict[str, Json] = {}
        errors = []
        async for parameter in in_turns(parameters):
            try:
                node, name = split_name(parameter.name)
                nodes.setdefault(node, {})[name] = _value(parameter)
            except GatewayError as error:
                errors.append(error.detail)
        async for node, values in in_turns(nodes.items()):
            try:
                await self._nodes.set_param(node, values)
            except GatewayError as error:
                errors.append(error.detail)
        return errors

    @operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
    async def subscribe(self, names: list[str]) -> None:
        """Tell the client of changes of parameters with these names; without names, of all that the user may see.

        Raises:
            GatewayError: They are too many, or the changes cannot be read.
        """
        await self._rights.require(ClientParameters.subscribe, {})
        if names and self._wanted is not None:
            if len(self._wanted.union(names)) > MAX_PARAMETERS:
                raise TooManyRequests(f"this connection may subscribe to {MAX_PARAMETERS} parameters")
            self._wanted |= set(names)
        else:
            self._wanted = None
        if not self._listening:
            await self._parts[Relays].join(EVENTS, EVENT_TYPE, self)
            self._listening = True

    async def unsubscribe(self, names: list[str]) -> None:
        """Tell the client no more of changes; without names, of none."""
        self._wanted = set() if self._wanted is None or not names else self._wanted.difference(names)
        if self._listening and not self._wanted:
            self._listening = False
            await self._parts[Relays].leave(EVENTS, self)

    async def offer(self, message: Received) -> None:
        """Take a message about parameters that have changed."""
        event = message.once(read_event)
        if event is None or not self._rights.grant.covers_place(event.node):
            return
        for parameter in (*event.new_parameters, *event.changed_parameters):
            document = parameter_document(event.node, parameter.name, parameter.value)
            room = len(self._changed) < MAX_PARAMETERS or document["name"] in self._changed
            if room and (self._wanted is None or document["name"] in self._wanted):
                self._changed[document["name"]] = document
                self._waiting.set()

    async def send_all(self, send: Callable[[list[Json]], Awaitable[None]]) -> None:
        """Send the newest values of what has changed, for as long as the client is connected."""
        while True:
            await self._waiting.wait()
            self._waiting.clear()
            changed, self._changed = list(self._changed.values()), {}
            await send(changed)

    async def close(self) -> None:
        """End the subscription."""
        await self.unsubscribe([])


def split_name(name: str) -> tuple[str, str]:
    """Return the node and the parameter of a name.

    Raises:
        InvalidField: It is none.
    """
    node, _, parameter = name.partition(SEPARATOR)
    if not (node.strip("/") and parameter):
        expected = "a node and a parameter, such as /node.name"
        raise InvalidField([FieldError("name", expected, f"got {name[:60]!r}")])
    return f"/{node.lstrip('/')}", parameter


def parameter_document(node: str, name: str, value: Any) -> Json:
    """Return a parameter as a client gets it."""
    kind, plain = plain_value(value)
    if isinstance(plain, bytes):
        plain = b64encode(plain).decode()
    document = {"name": f"{node}{SEPARATOR}{name}", "value": plain}
    return document if kind not in TYPES else {**document, "type": TYPES[kind]}


def _value(parameter: ParameterIn) -> Any:
    """Return the value that a client wants to set.

    Raises:
        InvalidField, NotAllowed: It is none.
    """
    if parameter.value is None:
        raise NotInstalled(f"{parameter.name}: parameters are not removed", code="not_supported")
    if parameter.type != BYTE_ARRAY:
        return parameter.value
    try:
        return list(b64decode(parameter.value, validate=True))
    except (NoBase64, TypeError, ValueError):
        raise InvalidField([FieldError(parameter.name, "base64", "got something else")]) from None


def _by_node(names: Iterable[str]) -> dict[str, list[str]]:
    nodes: dict[str, list[str]] = {}
    for name in names:
        node, parameter = split_name(name)
        nodes.setdefault(node, []).append(parameter)
    return nodes
