"""All metrics of a program."""

import asyncio
import platform
import time
from collections.abc import Iterable
from itertools import chain

from prometheus_client import (
    CollectorRegistry,
    GCCollector,
    Histogram,
    Info,
    Metric,
    PlatformCollector,
    ProcessCollector,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.registry import Collector

from dock_gateway import __version__
from dock_gateway.core.tasks import Tasks
from dock_gateway.observability.request_metrics import NAMESPACE, RequestMetrics

# Seconds between two measurements of the event loop's lag.
LAG_INTERVAL = 0.5
LAG_BUCKETS = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5)

# The library would add a series to each counter that says when the counter was made.
disable_created_metrics()  # type: ignore[no-untyped-call]


class Metrics:
    """The metrics of a gateway, or of another program with parts, and those of its process.

    Args:
        state: Reads the state of the parts.
        registry: Has what is counted.
    """

    def __init__(self, state: Collector, registry: CollectorRegistry) -> None:
        self._state, self._registry = state, registry
        ProcessCollector(registry=registry)
        PlatformCollector(registry=registry)
        GCCollector(registry=registry)
        build = Info("build", "The version of the gateway and of Python", namespace=NAMESPACE, registry=registry)
        build.info({"version": __version__, "python": platform.python_version()})
        self._lag = Histogram(
            "event_loop_lag_seconds",
            "How much later than due a timer of the event loop fires",
            namespace=NAMESPACE,
            registry=registry,
            buckets=LAG_BUCKETS,
        )
        self._tasks = Tasks("measuring the event loop")
        self._tasks.spawn(self._measure_lag())

    async def _measure_lag(self) -> None:
        while True:
            due = time.monotonic() + LAG_INTERVAL
            await asyncio.sleep(LAG_INTERVAL)
            self._lag.observe(max(0.0, time.monotonic() - due))

    async def text(self, requests: RequestMetrics) -> bytes:
        """Return all metrics in Prometheus' text format. On the event loop, only the state of the parts is read."""
        state = list(self._state.collect())
        return await asyncio.to_thread(generate_latest, _All(state, self._registry, requests.registry))

    async def close(self) -> None:
        """Stop measuring."""
        await self._tasks.close()


class _All(Collector):
    """Metrics that have been read, and those of registries."""

    def __init__(self, read: list[Metric], *registries: CollectorRegistry) -> None:
        self._read = read
        self._registries = registries

    def collect(self) -> Iterable[Metric]:
        """Return them."""
        return chain(self._read, *(registry.collect() for registry in self._registries))
