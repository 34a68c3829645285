"""Requests and WebSockets, by route."""

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram

# The prefix of the gateway's metrics.
NAMESPACE = "dock_gateway"
# From 1 ms to the longest `Prefer: wait=`, in seconds.
BUCKETS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 300)


class RequestMetrics:
    """Counts requests. Labels are routes, not paths: what clients send makes no series.

    Attributes:
        registry: Has these metrics.
        in_progress: The requests that are being answered.
        websockets: The open WebSockets, by route.
    """

    def __init__(self) -> None:
        self.registry = registry = CollectorRegistry()
        self.in_progress = Gauge(
            "http_requests_in_progress",
            "Requests being answered, including event streams",
            namespace=NAMESPACE,
            registry=registry,
        )
        self.websockets = Gauge("websockets", "Open WebSockets", ["route"], namespace=NAMESPACE, registry=registry)
        self._requests = Counter(
            "http_requests",
            "Requests by the status of their response; a WebSocket that was opened has status 101",
            ["method", "route", "status"],
            namespace=NAMESPACE,
            registry=registry,
        )
        self._response_time = Histogram(
            "http_request_duration_seconds",
            "Time from a request to the beginning of its response",
            ["method", "route"],
            namespace=NAMESPACE,
            registry=registry,
            buckets=BUCKETS,
        )

    def answered(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count a response that begins."""
        self._requests.labels(method, route, status).inc()
        self._response_time.labels(method, route).observe(seconds)
