"""Rules and robots for the tests of automatic docking."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

from dock_gateway.automation.policy import DockingPolicy, RobotFacts, Verdict
from dock_gateway.core.automation import WEEKDAYS, Decision, Mode, Outcome, Rule, Wait

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)  # a Thursday
LOW_BATTERY = Rule("Low battery", Mode.ON, True, (), (), 0.2, 60.0, (), (), None, "Ada", NOON - timedelta(days=1))
AT_ONE = Rule("Lunch", Mode.ON, True, (), (), None, None, ("12:10",), WEEKDAYS, "UTC", "Ada", NOON - timedelta(days=1))
EMPTY = RobotFacts("/robot1", battery=0.1, still_since=0.0)


class Site:
    """One gateway and its robot: looks at a number of seconds past noon, and records what is decided."""

    def __init__(self, **rules: Rule) -> None:
        self.rules = rules
        self.policy = DockingPolicy()
        self.decisions: dict[str, Decision] = {}
        self.verdict = Verdict()

    def look(self, seconds: float, robot: RobotFacts = EMPTY, *, outcome: Outcome = Outcome.SENT) -> list[Outcome]:
        """Return the outcomes of new decisions; those to dock a robot have this outcome."""
        return [decision.outcome for decision in self.decide(seconds, robot, outcome=outcome)]

    def decide(self, seconds: float, *robots: RobotFacts, outcome: Outcome = Outcome.SENT) -> list[Decision]:
        now = NOON + timedelta(seconds=seconds)
        self.verdict = self.policy.look(self.rules, robots, self.decisions, now, seconds)
        for identity in self.verdict.recovered:
            self.decisions[identity] = replace(self.decisions[identity], open=False)
        for decision in self.verdict.decisions:
            final = replace(decision, outcome=outcome) if decision.outcome is Outcome.SENDING else decision
            self.decisions[str(len(self.decisions))] = final
        return [*self.decisions.values()][len(self.decisions) - len(self.verdict.decisions) :]

    def waits(self, rule: str = "low", robot: str = "/robot1") -> Wait | None:
        """What the rule waits for."""
        return self.verdict.waits.get((rule, robot))


def robot(**facts: Any) -> RobotFacts:
    """The robot with an empty battery, except for these facts."""
    return replace(EMPTY, **facts)
