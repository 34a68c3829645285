"""The state of the gateway's parts, read when it is scraped."""

from collections import Counter
from collections.abc import Iterator, Mapping

from prometheus_client import Metric
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from dock_gateway.core.fanout import Fanout
from dock_gateway.core.webhook import DeliveryState
from dock_gateway.fleet.alerts import AlertBoard
from dock_gateway.goals.liveness import ServerState
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.observability.goal_metrics import VERBS, verb_of
from dock_gateway.observability.request_metrics import NAMESPACE
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History
from dock_gateway.webhooks.notifier import Notifier
from dock_gateway.webhooks.webhook import SEVERITIES

OUTCOMES = {
    DeliveryState.DELIVERED: "delivered",
    DeliveryState.PENDING: "to_be_repeated",
    DeliveryState.FAILED: "given_up",
}


class GatewayCollector(Collector):
    """Reads the parts of an open gateway."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts

    def collect(self) -> Iterator[Metric]:
        """Yield the metrics as they are now. Call it on the event loop."""
        yield from self._streams()
        yield from self._history()
        yield from self._ros()
        yield from self._fleet()

    def _streams(self) -> Iterator[Metric]:
        fanout = self._parts[Fanout]
        yield _gauge("stream_subscribers", "Readers of event streams, and WebSockets at /ws", len(fanout))
        yield _counters(
            "events_published", "Events by kind; feedback is that received from ROS", "kind", fanout.published
        )
        yield _counters("events_sent", "Events handed to readers of streams, by kind", "kind", fanout.sent)
        yield _counter("events_dropped", "Events that slow readers did not get", fanout.dropped)
        yield _counter(
            "feedback_unread",
            "Feedback messages that were too large or came too fast to be read",
            self._parts[ActionRegistry].feedback_dropped,
        )
        yield _counter(
            "unknown_goals_ignored",
            "Goals in status messages, and feedback messages, beyond the limit of unknown goals of one node",
            self._parts[ActionRegistry].unknown_goals_ignored,
        )

    def _history(self) -> Iterator[Metric]:
        stats = self._parts[History].stats()
        yield _gauge("history_waiting", "Entries in memory that are not in the database yet", stats.waiting)
        yield _gauge("history_spooled", "Entries on disk that are not in the database yet", stats.spooled)
        yield _counter("history_dropped", "Feedback and battery events that were not stored", stats.dropped)
        yield _gauge("database_reachable", "Whether the database answers", stats.database_reachable)

    def _ros(self) -> Iterator[Metric]:
        bridge, actions = self._parts[Bridge], self._parts[ActionRegistry]
        yield _gauge("ros_up", "Whether the ROS threads run", bridge.alive)
        yield _gauge("dds_participants", "DDS participants of the gateway", 1 + len(bridge.branches))
        servers: Counter[str] = Counter(available=0, not_answering=0, unavailable=0)
        servers.update(_state_of(action.watch.state) for action in actions.all())
        servers["not_installed"] = len(actions.uninstalled())
        yield _gauges("action_servers", "Action servers by state", "state", servers)
        for name, text, goals in (
            ("running_goals", "Goals that have not ended", actions.running()),
            ("lost_goals", "Goals that are lost and may return", actions.lost()),
        ):
            verbs = Counter(dict.fromkeys(VERBS, 0))
            verbs.update(verb_of(goal) for goal in goals)
            yield _gauges(name, text, "verb", verbs)

    def _fleet(self) -> Iterator[Metric]:
        parts = self._parts
        robots = parts[RobotRegistry].all()
        yield _gauge("robots", "Robots that the gateway serves", len(robots))
        stopped = sum(parts[Stopper].state(robot.namespace)["latched"] for robot in robots)
        yield _gauge("robots_stopped", "Robots held by a latched stop", stopped)
        alerts = Counter({str(severity): 0 for severity in SEVERITIES})
        alerts.update(alert["severity"] for alert in parts[AlertBoard].documents())
        yield _gauges("alerts", "Active alerts", "severity", alerts)
        attempts = {outcome: parts[Notifier].attempts.get(state, 0) for state, outcome in OUTCOMES.items()}
        yield _counters("webhook_attempts", "Attempts to send an alert to a webhook", "outcome", attempts)


def _state_of(server: ServerState) -> str:
    if not server.available:
        return "unavailable"
    return "available" if server.answering else "not_answering"


def _gauge(name: str, text: str, value: float) -> Metric:
    return GaugeMetricFamily(f"{NAMESPACE}_{name}", text, value)


def _gauges(name: str, text: str, label: str, values: Mapping[str, float]) -> Metric:
    return _filled(GaugeMetricFamily(f"{NAMESPACE}_{name}", text, labels=[label]), values)


def _counter(name: str, text: str, value: float) -> Metric:
    return CounterMetricFamily(f"{NAMESPACE}_{name}", text, value)


def _counters(name: str, text: str, label: str, values: Mapping[str, float]) -> Metric:
    return _filled(CounterMetricFamily(f"{NAMESPACE}_{name}", text, labels=[label]), values)


def _filled(family: GaugeMetricFamily | CounterMetricFamily, values: Mapping[str, float]) -> Metric:
    """Return a metric with a series for each value of its label."""
    for value, number in values.items():
        family.add_metric([value], number)
    return family
