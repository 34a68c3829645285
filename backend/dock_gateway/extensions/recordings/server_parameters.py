"""The parameters of an action server, for the recordings of its goals."""

import logging
from contextlib import closing
from typing import Any

from dock_gateway.core.errors import GatewayError
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.parameter_reader import ParameterReader, find_server_node

log = logging.getLogger(__name__)


async def read_parameters(bridge: Bridge, action: str) -> dict[str, Any] | None:
    """Return the node of an action server and the values of its parameters; None if it does not tell them."""
    try:
        if (node := await find_server_node(bridge, action)) is None:
            return None
        with closing(ParameterReader(bridge, node)) as reader:
            values = await reader.values(sorted(await reader.names()))
    except (GatewayError, TimeoutError) as error:
        log.info("the parameters of the server of %s are not recorded: %s", action, error or "it does not answer")
        return None
    return {"node": node, "values": dict(values)}
