"""The state of a gateway's parts, read when it is scraped."""

from collections import Counter
from collections.abc import Iterator

from prometheus_client import Metric

from dock_gateway.goals.liveness import ServerState
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.observability.collector import PartsCollector, counter, gauge, gauges
from dock_gateway.observability.goal_metrics import VERBS, verb_of
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.stop.stopper import Stopper


class GatewayCollector(PartsCollector):
    """Reads the parts of an open gateway."""

    def collect(self) -> Iterator[Metric]:
        """Yield the metrics as they are now. Call it on the event loop."""
        yield from super().collect()
        yield from self._actions()
        yield from self._ros()
        yield from self._robots()

    def _actions(self) -> Iterator[Metric]:
        yield counter(
            "feedback_dropped",
            "Feedback messages that were too large or came too fast to be read",
            self.parts[ActionRegistry].feedback_dropped,
        )
        yield counter(
            "unknown_goals_ignored",
            "Goals in status messages, and feedback messages, beyond the limit of unknown goals of one node",
            self.parts[ActionRegistry].unknown_goals_ignored,
        )

    def _ros(self) -> Iterator[Metric]:
        bridge, actions = self.parts[Bridge], self.parts[ActionRegistry]
        yield gauge("ros_up", "Whether the ROS threads run", bridge.alive)
        yield gauge("dds_participants", "DDS participants of the gateway", 1 + len(bridge.branches))
        servers: Counter[str] = Counter(available=0, not_answering=0, unavailable=0)
        servers.update(_state_of(action.watch.state) for action in actions.all())
        servers["not_installed"] = len(actions.uninstalled())
        yield gauges("action_servers", "Action servers by state", "state", servers)
        for name, text, goals in (
            ("goals_running", "Goals that have not ended", actions.running()),
            ("goals_missing", "Goals that are lost and may return", actions.lost()),
        ):
            verbs = Counter(dict.fromkeys(VERBS, 0))
            verbs.update(verb_of(goal) for goal in goals)
            yield gauges(name, text, "verb", verbs)

    def _robots(self) -> Iterator[Metric]:
        parts = self.parts
        robots = parts[RobotRegistry].all()
        yield gauge("robots", "Robots that the gateway serves", len(robots))
        stopped = sum(parts[Stopper].state(robot.namespace)["latched"] for robot in robots)
        yield gauge("robots_stopped", "Robots held by a latched stop", stopped)


def _state_of(server: ServerState) -> str:
    if not server.available:
        return "unavailable"
    return "available" if server.answering else "not_answering"
