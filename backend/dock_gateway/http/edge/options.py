"""The uvicorn options that install this package's connections."""

from functools import partial
from typing import Any

from dock_gateway.http.edge.connection import Edge
from dock_gateway.http.edge.http import create_connection
from dock_gateway.http.edge.limits import ConnectionLimits
from dock_gateway.http.edge.websocket import WebSocketProtocol
from dock_gateway.settings import Settings

# Seconds that a connection stays open between two requests. Differs from common intervals, such as that of heartbeats:
# a client that sends its next request exactly then would find the connection closed.
KEEP_ALIVE = 17


def edge_options(settings: Settings) -> dict[str, Any]:
    """Return options of `uvicorn.Config`."""
    edge = Edge(settings, ConnectionLimits(settings))
    return {
        "http": partial(create_connection, edge),
        "proxy_headers": False,  # `ForwardedHeaders` reads them
        "h11_max_incomplete_event_size": settings.max_header_bytes,
        "timeout_keep_alive": KEEP_ALIVE,
        "ws": partial(WebSocketProtocol, edge),
        "ws_max_size": settings.max_body_bytes,
    }
