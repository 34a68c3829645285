"""Rules and robots for the tests of automatic docking."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

from dock_gateway.extensions.automation.decision import DecisionEntry, DecisionOutcome, RuleMode, WaitReason
from dock_gateway.extensions.automation.policy import DockingPolicy, RobotFacts, Verdict
from dock_gateway.extensions.automation.rule import BatteryCondition, RuleEntry, Schedule
from dock_gateway.http.schema import RobotSelection
from dock_gateway.http.times_of_day import WEEKDAYS


def changed(rule: RuleEntry, **fields: Any) -> RuleEntry:
    """The rule with other fields."""
    return rule.model_copy(update=fields)


NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)  # a Thursday
LOW_BATTERY = RuleEntry(
    name="Low battery",
    mode=RuleMode.ON,
    robots=RobotSelection(all=True),
    battery=BatteryCondition(below=0.2, idle_s=60),
    changed_by="Ada",
    changed_at=NOON - timedelta(days=1),
)
LUNCH = Schedule(times=["12:10"], weekdays=[*WEEKDAYS], time_zone="UTC")
AT_ONE = changed(LOW_BATTERY, name="Lunch", battery=None, schedule=LUNCH)
EMPTY = RobotFacts("/robot1", battery=0.1, still_since=0.0)


class Site:
    """One gateway and its robot: looks at a number of seconds past noon, and records what is decided."""

    def __init__(self, **rules: RuleEntry) -> None:
        self.rules = rules
        self.policy = DockingPolicy()
        self.decisions: dict[str, DecisionEntry] = {}
        self.verdict = Verdict()

    def look(
        self, seconds: float, robot: RobotFacts = EMPTY, *, outcome: DecisionOutcome = DecisionOutcome.SENT
    ) -> list[DecisionOutcome]:
        """Return the outcomes of new decisions; those to dock a robot have this outcome."""
        return [decision.outcome for decision in self.decide(seconds, robot, outcome=outcome)]

    def decide(
        self, seconds: float, *robots: RobotFacts, outcome: DecisionOutcome = DecisionOutcome.SENT
    ) -> list[DecisionEntry]:
        now = NOON + timedelta(seconds=seconds)
        self.verdict = self.policy.decide(self.rules, robots, self.decisions, now, seconds)
        for identity in self.verdict.recovered:
            self.decisions[identity] = self.decisions[identity].model_copy(update={"open": False})
        for decision in self.verdict.decisions:
            sending = decision.outcome is DecisionOutcome.SENDING
            final = decision.model_copy(update={"outcome": outcome}) if sending else decision
            self.decisions[str(len(self.decisions))] = final
        return [*self.decisions.values()][len(self.decisions) - len(self.verdict.decisions) :]

    def waits(self, rule: str = "low", robot: str = "/robot1") -> WaitReason | None:
        """What the rule waits for."""
        return self.verdict.waits.get((rule, robot))


def robot(**facts: Any) -> RobotFacts:
    """The robot with an empty battery, except for these facts."""
    return replace(EMPTY, **facts)


def decision_entry(**fields: Any) -> DecisionEntry:
    """A decision of the rule `low` about the robot, at noon, except for these fields."""
    made: dict[str, Any] = {
        "rule_id": "low",
        "rule_name": "Low battery",
        "robot": "/robot1",
        "decided_at": NOON,
        "outcome": DecisionOutcome.SENDING,
        "battery": 0.1,
        "idle_since_at": NOON,
        "scheduled_at": None,
        "goal_id": None,
        "code": None,
        "detail": None,
        "open": True,
    }
    return DecisionEntry(**made | fields)
