"""The state of the parts that a gateway has in common with other programs, read when it is scraped."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from dock_gateway.core.alerts import Alerts
from dock_gateway.core.fanout import Fanout
from dock_gateway.http.parts import Parts
from dock_gateway.observability.request_metrics import NAMESPACE
from dock_gateway.storage import History

SEVERITIES = ("critical", "warning")
Further = Sequence[Callable[[], Iterable[Metric]]]


class PartsCollector(Collector):
    """Reads streams, the history, alerts, and what extensions measure.

    Args:
        parts: The parts.
        further: Return the metrics of extensions.
    """

    def __init__(self, parts: Parts, further: Further = ()) -> None:
        self.parts = parts
        self._further = further

    def collect(self) -> Iterator[Metric]:
        """Yield the metrics as they are now. Call it on the event loop."""
        yield from self._streams()
        yield from self._history()
        yield from self._alerts()
        for measure in self._further:
            yield from measure()

    def _streams(self) -> Iterator[Metric]:
        fanout = self.parts[Fanout]
        yield gauge("stream_subscribers", "Readers of event streams, and WebSockets at /ws", len(fanout))
        yield counters(
            "events_published", "Events by kind; feedback is that received from ROS", "kind", fanout.published
        )
        yield counters("events_sent", "Events handed to readers of streams, by kind", "kind", fanout.sent)
        yield counter("events_dropped", "Events that slow readers did not get", fanout.dropped)

    def _history(self) -> Iterator[Metric]:
        stats = self.parts[History].stats()
        yield gauge("history_waiting", "Entries in memory that are not in the database yet", stats.waiting)
        yield gauge("history_spooled", "Entries on disk that are not in the database yet", stats.spooled)
        yield counter("history_dropped", "Feedback and battery events that were not stored", stats.dropped)
        yield gauge("database_reachable", "Whether the database answers", stats.database_reachable)

    def _alerts(self) -> Iterator[Metric]:
        alerts = Counter(dict.fromkeys(SEVERITIES, 0))
        alerts.update(alert["severity"] for alert in self.parts[Alerts].documents())
        yield gauges("alerts", "Active alerts", "severity", alerts)


def gauge(name: str, text: str, value: float) -> Metric:
    """Return a number that goes up and down."""
    return GaugeMetricFamily(f"{NAMESPACE}_{name}", text, value)


def gauges(name: str, text: str, label: str, values: Mapping[str, float]) -> Metric:
    """Return such numbers, by the value of a label."""
    return _filled(GaugeMetricFamily(f"{NAMESPACE}_{name}", text, labels=[label]), values)


def counter(name: str, text: str, value: float) -> Metric:
    """Return a number that only goes up."""
    return CounterMetricFamily(f"{NAMESPACE}_{name}", text, value)


def counters(name: str, text: str, label: str, values: Mapping[str, float]) -> Metric:
    """Return such numbers, by the value of a label."""
    return _filled(CounterMetricFamily(f"{NAMESPACE}_{name}", text, labels=[label]), values)


def _filled(family: GaugeMetricFamily | CounterMetricFamily, values: Mapping[str, float]) -> Metric:
    """Return a metric with a series for each value of its label."""
    for value, number in values.items():
        family.add_metric([value], number)
    return family
