"""Metrics of ended goals."""

from prometheus_client import CollectorRegistry, Counter, Histogram

from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.observability.request_metrics import NAMESPACE
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings

# The label `verb` of goals: what they do to a robot. `other` is any action that is neither docking nor undocking.
OTHER = "other"
VERBS = ("dock", "undock", OTHER)

# From 1 s to 10 min.
BUCKETS = (1, 2, 5, 10, 20, 30, 45, 60, 90, 120, 180, 300, 600)
# The states in which a goal that was executed ends.
EXECUTED = (GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED)
LABELS = ("robot", "action", "verb")


def verb_of(goal: Goal) -> str:
    """Return the label `verb` of a goal."""
    return goal.verb or OTHER


class GoalMetrics:
    """Counts goals by action, and measures how long they take by verb.

    There are series for at most `max_actions` actions. If there are more, those that have left the graph are removed.
    """

    def __init__(self, registry: CollectorRegistry, parts: Parts) -> None:
        self._ended = Counter(
            "goals_ended", "Goals that ended", [*LABELS, "status"], namespace=NAMESPACE, registry=registry
        )
        self._lost = Counter(
            "goals_lost",
            "Goals whose action server was lost; one that returns also counts as ended later",
            LABELS,
            namespace=NAMESPACE,
            registry=registry,
        )
        self._retries = Counter(
            "goal_retries", "Retries that action servers reported", LABELS, namespace=NAMESPACE, registry=registry
        )
        self._duration = Histogram(
            "goal_duration_seconds",
            "Time from the creation of a goal to its end",
            ["verb", "status"],
            namespace=NAMESPACE,
            registry=registry,
            buckets=BUCKETS,
        )
        for verb in VERBS:
            for status in EXECUTED:
                self._duration.labels(verb, status.value)
        self._actions: set[str] = set()
        self._parts = parts
        parts[ActionRegistry].on_end.append(self._on_end)
        parts[ActionRegistry].on_lost.append(self._on_lost)

    def _on_end(self, goal: Goal) -> None:
        """Count a goal that ended."""
        if goal.status is GoalStatus.LOST:  # it is not expected back, and has been counted
            return
        labels = self._labels(goal)
        self._ended.labels(*labels, goal.status.value).inc()
        self._retries.labels(*labels).inc(goal.retries or 0)
        if goal.status in EXECUTED and goal.finished_at is not None:
            seconds = (goal.finished_at - goal.created_at).total_seconds()
            self._duration.labels(labels[-1], goal.status.value).observe(max(0.0, seconds))  # clocks differ

    def _on_lost(self, goal: Goal) -> None:
        """Count a goal that was lost."""
        self._lost.labels(*self._labels(goal)).inc()

    def _labels(self, goal: Goal) -> tuple[str, str, str]:
        action = goal.action_name
        if action not in self._actions and len(self._actions) >= self._parts[Settings].max_actions:
            self._remove_gone()
        self._actions.add(action)
        robot = self._parts[RobotRegistry].owner(action)
        return "" if robot is None else robot.namespace, action, verb_of(goal)

    def _remove_gone(self) -> None:
        for action in [name for name in self._actions if self._parts[ActionRegistry].get(name) is None]:
            self._actions.remove(action)
            for counter in (self._ended, self._lost, self._retries):
                counter.remove_by_labels({"action": action})
