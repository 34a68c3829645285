"""What holds of automatic docking whatever happens to the robots."""

import itertools
from collections import defaultdict
from datetime import datetime, timedelta

from hypothesis import given, settings
from hypothesis import strategies as st

from dock_gateway.extensions.automation.decision import DecisionEntry, DecisionOutcome, RuleMode
from dock_gateway.extensions.automation.past import MAX_ATTEMPTS, RETRY_INTERVAL
from dock_gateway.extensions.automation.policy import QUIET_PERIOD, STILL_FOR, RobotFacts
from dock_gateway.extensions.automation.rule import RuleEntry
from tests.extensions.automation.examples import AT_ONE, LOW_BATTERY, NOON, Site, changed

ages = st.sampled_from([None, 0.0, 5.0, 30.0, 59.0, 61.0, 200.0, 1000.0])
# Mostly what speaks for docking, so that it comes to that.
likely = st.sampled_from([False, False, False, False, True])
steps = st.tuples(
    st.sampled_from([1.0, 2.0, 20.0, 61.0, 299.0, 300.0, 600.0]),  # seconds since the step before
    st.sampled_from([0.05, 0.1, 0.1, 0.1, 0.19, 0.21, 0.26, 0.9, None]),
    likely,  # stale
    likely,  # docked
    likely,  # unreachable
    likely,  # goal running
    likely,  # stopped
    likely,  # stopped before, and nobody has let the rules go on
    ages,  # of stillness
    ages,  # of a person's doing
    st.sampled_from([DecisionOutcome.SENT, DecisionOutcome.REFUSED]),
)
modes = st.sampled_from([RuleMode.ON, RuleMode.ON, RuleMode.DRY_RUN, RuleMode.OFF])


@settings(max_examples=300, deadline=None)
@given(st.lists(steps, min_size=1, max_size=40), modes, modes)
def test_what_always_holds(history: list[tuple[object, ...]], low: RuleMode, lunch: RuleMode) -> None:
    rules = {"low": changed(LOW_BATTERY, mode=low), "lunch": changed(AT_ONE, mode=lunch)}
    site = Site(**rules)
    seconds = 0.0
    sent: list[tuple[datetime, DecisionEntry]] = []
    since_recovery: defaultdict[str, int] = defaultdict(int)
    for step in history:
        pause, battery, stale, docked, unreachable, goal, stopped, held, still, person, outcome = step
        seconds += pause  # type: ignore[operator]
        facts = RobotFacts(
            "/robot1",
            fresh=not stale,
            battery=battery,  # type: ignore[arg-type]
            docked=bool(docked),
            reachable=not unreachable,
            goal_running=bool(goal),
            stopped="stopped" if stopped else None,
            held=bool(held),
            still_since=None if still is None else seconds - still,  # type: ignore[operator]
            person_at=None if person is None else seconds - person,  # type: ignore[operator]
        )
        decisions = site.decide(seconds, facts, outcome=outcome)  # type: ignore[arg-type]
        if facts.fresh and (docked or (facts.battery or 0.0) >= 0.25):
            since_recovery.clear()
        assert len(decisions) <= 1
        for decision in decisions:
            rule = rules[decision.rule_id]
            assert rule.mode is not RuleMode.OFF
            assert decision.outcome is not DecisionOutcome.DRY_RUN or rule.mode is RuleMode.DRY_RUN
            if decision.outcome in (DecisionOutcome.SENT, DecisionOutcome.REFUSED):
                since_recovery[decision.rule_id] += 1
                sent.append((NOON + timedelta(seconds=seconds), decision))
                check_facts(rule, facts, seconds)
        assert since_recovery["low"] <= MAX_ATTEMPTS
    times = [time for time, _ in sent]
    assert all(later - time >= RETRY_INTERVAL for time, later in itertools.pairwise(times))
    due = [decision.scheduled_at for _, decision in sent if decision.scheduled_at is not None]
    assert len(set(due)) == len(due)


def check_facts(rule: RuleEntry, facts: RobotFacts, seconds: float) -> None:
    """What must speak for docking a robot."""
    assert rule.mode is RuleMode.ON
    assert facts.stopped is None
    assert not facts.held
    assert facts.fresh
    assert facts.reachable
    assert not facts.docked
    assert not facts.goal_running
    assert facts.person_at is None or seconds - facts.person_at >= QUIET_PERIOD
    assert facts.still_since is not None
    assert seconds - facts.still_since >= (STILL_FOR if rule.battery is None else rule.battery.idle_s)
    assert rule.battery is None or (facts.battery is not None and facts.battery < rule.battery.below)
