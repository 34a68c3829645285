"""Measures every request that reaches the application."""

import time

from starlette.types import ASGIApp, Message, Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.observability.request_metrics import RequestMetrics

# Without HEAD, which counts as the GET that it is answered like.
METHODS = frozenset({"GET", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
OTHER = "other"


class RequestMeter:
    """ASGI middleware that counts requests by route. A response's time is that to its beginning, as streams last.

    A WebSocket counts as the GET request that it begins as: 101 if it was opened.
    """

    def __init__(self, app: ASGIApp, metrics: RequestMetrics) -> None:
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Pass the request on."""
        if scope["type"] == "http":
            with self._metrics.in_progress.track_inprogress():
                await self._measure(scope, receive, send)
        elif scope["type"] == "websocket":
            await self._measure(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _measure(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        began = time.perf_counter()
        status = 0

        async def measured_send(message: Message) -> None:
            nonlocal status
            if not status and (status := _status(message)):
                self._count(scope, status, began)
            await send(message)

        try:
            await self._app(scope, receive, measured_send)
        except Exception:
            if not status:
                self._count(scope, 500, began)
            raise
        finally:
            if status == 101:
                self._metrics.websockets.labels(_route(scope)).dec()

    def _count(self, scope: ConnectionScope, status: int, began: float) -> None:
        route, method = _route(scope), scope.get("method", "GET")
        seconds = time.perf_counter() - began
        self._metrics.answered(method if method in METHODS else OTHER, route, status, seconds)
        if status == 101:
            self._metrics.websockets.labels(route).inc()


def _status(message: Message) -> int:
    """Return the status of the response that a message begins; 0 if it begins none."""
    match message["type"]:
        case "http.response.start" | "websocket.http.response.start":
            status: int = message["status"]
            return status
        case "websocket.accept":
            return 101
        case "websocket.close":
            return 403  # closed before it was opened
    return 0


def _route(scope: ConnectionScope) -> str:
    """Return the template of the route that answers; `other` for files of the dashboard and unknown paths."""
    path: str = getattr(scope.get("route"), "path", OTHER)
    return path
