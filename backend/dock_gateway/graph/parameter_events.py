"""Where every node says which of its parameters have changed."""

from typing import Any

from dock_gateway.graph.received import Received

EVENTS, EVENT_TYPE = "/parameter_events", "rcl_interfaces/msg/ParameterEvent"


def read_event(message: Received) -> Any:
    """Return a message as a `ParameterEvent`; None if it cannot be read. For `Received.once`: all readers share it."""
    try:
        return message.kind.decode(message.data)
    except Exception:  # noqa: BLE001 - whatever the bytes of others bring about
        return None
