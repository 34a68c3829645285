"""Earlier decisions: which attempts count, and whether a new one is still free. Pure."""

from collections import defaultdict
from collections.abc import Mapping
from datetime import datetime, timedelta

from dock_gateway.core.errors import Conflict
from dock_gateway.extensions.automation.decision import ATTEMPTS, DecisionEntry, DecisionOutcome

# How long after an attempt, or after a failed docking, the next one may follow.
RETRY_INTERVAL = timedelta(minutes=5)
# Attempts until the battery has recovered or the robot has been docked.
MAX_ATTEMPTS = 3

Key = tuple[str, str]  # the id of a rule, and a robot


class Past:
    """Earlier decisions, in the order in which the policy asks for them."""

    def __init__(self, decisions: Mapping[str, DecisionEntry]) -> None:
        self.open: defaultdict[Key, list[DecisionEntry]] = defaultdict(list)
        self._attempted: dict[str, datetime] = {}  # by robot: the last attempt
        self._scheduled: set[tuple[Key, datetime]] = set()
        for decision in decisions.values():
            key = (decision.rule_id, decision.robot)
            if decision.open:
                self.open[key].append(decision)
            if decision.scheduled_at is not None:
                self._scheduled.add((key, decision.scheduled_at))
            if decision.outcome in ATTEMPTS:
                self._attempted[decision.robot] = max(
                    decision.decided_at, self._attempted.get(decision.robot, decision.decided_at)
                )

    def has(self, key: Key, outcome: DecisionOutcome) -> bool:
        """Return whether there is an open decision with this outcome."""
        return any(decision.outcome is outcome for decision in self.open[key])

    def attempts(self, key: Key) -> int:
        """Return the number of open attempts."""
        return sum(decision.outcome in ATTEMPTS for decision in self.open[key])

    def decided(self, key: Key, due: datetime) -> bool:
        """Return whether there is a decision for this time of day."""
        return (key, due) in self._scheduled

    def is_recent(self, robot: str, now: datetime) -> bool:
        """Return whether there was an attempt within the retry interval."""
        last = self._attempted.get(robot)
        return last is not None and abs(now - last) < RETRY_INTERVAL


def require_free(decision: DecisionEntry, stored: Mapping[str, DecisionEntry]) -> None:
    """Check a decision against those that all gateways have stored.

    Raises:
        Conflict: Another gateway was first.
    """
    past, key = Past(stored), (decision.rule_id, decision.robot)
    if decision.scheduled_at is not None:
        taken = past.decided(key, decision.scheduled_at)
    elif decision.outcome is DecisionOutcome.SENDING:
        taken = past.attempts(key) >= MAX_ATTEMPTS
    else:
        taken = past.has(key, decision.outcome)
    if decision.outcome is DecisionOutcome.SENDING:
        taken = taken or past.is_recent(decision.robot, decision.decided_at)
    if taken:
        raise Conflict("another gateway has decided already")
