"""The parameters of action servers, for the recordings of their goals."""

import logging
import time
from collections.abc import Container
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

from dock_gateway.core.errors import GatewayError
from dock_gateway.graph.parameter_events import EVENT_TYPE, EVENTS, read_event
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.parameter_reader import ParameterReader, find_servers, read_value

log = logging.getLogger(__name__)

# Seconds after which a server that has not answered is asked again.
PAUSE = 10.0


@dataclass
class _Known:
    """The parameters of a server. The endpoint of one that starts again is another."""

    gid: bytes
    node: str
    values: dict[str, Any] = field(default_factory=dict)
    complete: bool = False
    asked_at: float = field(default_factory=time.monotonic)


class ServerParameters:
    """The parameters of action servers. Each is asked once; then its changes are followed.

    Args:
        bridge: Runs calls on the ROS thread.
        relays: The topics.
    """

    def __init__(self, bridge: Bridge, relays: Relays) -> None:
        self._bridge = bridge
        self._relays = relays
        self._listening = False
        self._known: dict[str, _Known] = {}

    async def read(self, action: str) -> dict[str, Any] | None:
        """Return the node of an action server and the values of its parameters; None if it does not tell them."""
        try:
            await self._listen()
            known = await self._know(action)
        except (GatewayError, TimeoutError) as error:
            log.info("the parameters of the server of %s are not recorded: %s", action, error or "it does not answer")
            return None
        if known is None or not known.complete:
            return None
        values = {name: value for name, value in known.values.items() if value is not None}
        return {"node": known.node, "values": values}

    async def _know(self, action: str) -> _Known | None:
        """Return what is known of a server, and ask it if that is not all."""
        if not (servers := await find_servers(self._bridge, action)):
            return None
        node, gid = servers[-1]
        known = self._known.get(action)
        # One that was killed stays on the graph beside its successor for a while.
        same = known is not None and known.gid == gid and len(servers) == 1
        if known is not None and same and (known.complete or time.monotonic() - known.asked_at < PAUSE):
            return known
        known = self._known[action] = _Known(gid, node)
        known.values = {**await self._ask(node), **known.values}  # a change meanwhile is newer
        known.complete = True
        return known

    def keep(self, actions: Container[str]) -> None:
        """Forget the servers of all other actions."""
        for action in [action for action in self._known if action not in actions]:
            del self._known[action]

    async def _listen(self) -> None:
        if not self._listening:
            await self._relays.join(EVENTS, EVENT_TYPE, self)
            self._listening = True

    async def _ask(self, node: str) -> dict[str, Any]:
        with closing(ParameterReader(self._bridge, node)) as reader:
            return dict(await reader.values(sorted(await reader.names())))

    async def offer(self, message: Received) -> None:
        """Take a message about parameters that have changed."""
        event = message.once(read_event)
        if event is None:
            return
        for known in self._known.values():
            if known.node != event.node:
                continue
            for parameter in (*event.new_parameters, *event.changed_parameters):
                known.values[parameter.name] = read_value(parameter.value)
            for parameter in event.deleted_parameters:
                known.values[parameter.name] = None

    async def close(self) -> None:
        """Follow changes no longer."""
        if self._listening:
            self._listening = False
            await self._relays.leave(EVENTS, self)
