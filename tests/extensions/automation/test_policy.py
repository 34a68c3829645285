"""When a rule docks a robot, when it does not, and how often it tries."""

from datetime import timedelta
from typing import Any

import pytest

from dock_gateway.core.errors import Conflict
from dock_gateway.extensions.automation.decision import DecisionOutcome, RuleMode, WaitReason
from dock_gateway.extensions.automation.past import MAX_ATTEMPTS, require_free
from dock_gateway.extensions.automation.rule import BatteryCondition
from dock_gateway.http.schema import RobotSelection
from tests.extensions.automation.examples import (
    AT_ONE,
    EMPTY,
    LOW_BATTERY,
    LUNCH,
    NOON,
    Site,
    changed,
    decision_entry,
    robot,
)

FULL = robot(battery=0.9)
DUE = 600.0  # the seconds past noon at which AT_ONE is due


@pytest.fixture
def site() -> Site:
    return Site(low=LOW_BATTERY)


def test_a_robot_docks_once_it_was_idle_with_a_low_battery(site: Site) -> None:
    assert site.look(0) == []
    assert (site.waits(), site.verdict.watched) == (WaitReason.NOT_IDLE, {"/robot1"})
    assert site.look(59.9) == []
    (decision,) = site.decide(60, EMPTY)
    assert (decision.outcome, decision.robot, decision.rule_name) == (DecisionOutcome.SENT, "/robot1", "Low battery")
    assert (decision.battery, decision.idle_since_at, decision.open) == (0.1, NOON, True)
    assert site.look(61) == []
    assert site.waits() is WaitReason.RETRY_LATER


def test_both_conditions_hold_for_the_whole_time(site: Site) -> None:
    site.look(0)
    site.look(30, FULL)  # one low value does not count
    assert (site.waits(), site.verdict.watched) == (WaitReason.BATTERY_OK, set())
    assert site.look(60) == site.look(119) == []
    assert site.look(119.5, robot(still_since=100.0)) == []
    assert site.look(120, robot(still_since=60.0)) == [DecisionOutcome.SENT]


@pytest.mark.parametrize(
    ("facts", "wait"),
    [
        ({"fresh": False}, WaitReason.BATTERY_UNKNOWN),
        ({"battery": None}, WaitReason.BATTERY_UNKNOWN),
        ({"battery": 0.2}, WaitReason.BATTERY_OK),
        ({"docked": True}, WaitReason.DOCKED),
        ({"reachable": False}, WaitReason.SERVER_UNAVAILABLE),
        ({"shares_dock": True}, WaitReason.SHARED_ACTION),
        ({"goal_running": True}, WaitReason.GOAL_RUNNING),
        ({"goal_lost": True}, WaitReason.GOAL_LOST),
        ({"at_work": True}, WaitReason.AT_WORK),
        ({"person_at": 1.0}, WaitReason.QUIET_PERIOD),
        ({"held": True}, WaitReason.STOPPED),
        ({"held": True, "person_at": 1.0}, WaitReason.STOPPED),
        ({"still_since": None}, WaitReason.NOT_IDLE),
        ({"still_since": 50.0}, WaitReason.NOT_IDLE),
        ({"failed_at": NOON}, WaitReason.RETRY_LATER),
    ],
)
def test_what_speaks_against_it(site: Site, facts: dict[str, Any], wait: WaitReason) -> None:
    site.look(0)
    assert site.look(60, robot(**facts)) == []
    assert site.waits() is wait


def test_a_latched_stop_holds_the_robot_and_is_recorded_once(site: Site) -> None:
    stopped = robot(stopped="stopped by Ada", person_at=0.0)
    site.look(0, stopped)
    (held,) = site.decide(60, stopped)
    assert (held.outcome, held.code, held.detail) == (DecisionOutcome.HELD, "stop_latched", "stopped by Ada")
    assert site.look(3600, stopped) == []
    assert site.waits() is WaitReason.STOP_LATCHED
    assert site.look(3601, robot(held=True, still_since=3601.0)) == []
    assert site.look(7200, robot(held=True, still_since=3601.0)) == []
    assert site.waits() is WaitReason.STOPPED
    assert site.look(7201, robot(still_since=3601.0)) == [DecisionOutcome.SENT]


def test_a_dry_run_records_once_and_sends_nothing(site: Site) -> None:
    site.rules["low"] = changed(LOW_BATTERY, mode=RuleMode.DRY_RUN)
    site.look(0)
    assert site.look(60) == [DecisionOutcome.DRY_RUN]
    assert site.look(7200) == []
    assert site.waits() is WaitReason.REPORTED
    site.look(7300, FULL)
    site.look(7301)
    assert site.look(7361) == [DecisionOutcome.DRY_RUN]


def test_a_rule_that_is_off_does_nothing(site: Site) -> None:
    site.rules["low"] = changed(LOW_BATTERY, mode=RuleMode.OFF)
    site.look(0)
    assert site.look(3600) == []
    assert site.verdict.watched == set()


def test_which_robots_a_rule_is_for(site: Site) -> None:
    site.rules["low"] = changed(LOW_BATTERY, robots=RobotSelection(names=("/robot1",), groups=("hall 1",)))
    robots = [EMPTY, robot(name="/robot2", groups=("hall 1", "new")), robot(name="/robot3", groups=("hall 2",))]
    site.decide(0, *robots)
    assert [decision.robot for decision in site.decide(60, *robots)] == ["/robot1", "/robot2"]


@pytest.mark.parametrize("outcome", [DecisionOutcome.SENT, DecisionOutcome.REFUSED])
def test_it_tries_three_times_and_gives_up_until_the_battery_has_recovered(
    site: Site, outcome: DecisionOutcome
) -> None:
    site.look(0, outcome=outcome)
    for attempt in range(MAX_ATTEMPTS):
        at = 60 + attempt * 300.0
        assert site.look(at, outcome=outcome) == [outcome]
        assert site.look(at + 299) == []
    assert site.look(960) == [DecisionOutcome.GAVE_UP]
    assert site.look(9000) == []
    assert site.waits() is WaitReason.GAVE_UP
    site.look(9001, robot(battery=0.21))  # around the limit is no recovery
    site.look(9002)
    assert site.look(9062) == []
    site.look(9100, robot(battery=0.25))
    site.look(9101)
    assert site.look(9161) == [DecisionOutcome.SENT]


def test_a_person_who_docks_the_robot_lets_it_begin_anew(site: Site) -> None:
    site.look(0)
    site.look(60)
    site.look(100, robot(docked=True))
    assert not any(decision.open for decision in site.decisions.values())


def test_a_failed_docking_is_retried_five_minutes_after_its_end(site: Site) -> None:
    site.look(0)
    site.look(60)
    failed = robot(failed_at=NOON + timedelta(seconds=200))
    assert site.look(499, failed) == []
    assert site.look(500, failed) == [DecisionOutcome.SENT]


def test_two_rules_do_not_dock_one_robot_twice(site: Site) -> None:
    site.rules["other"] = changed(LOW_BATTERY, name="Other", battery=BatteryCondition(below=0.5, idle_s=60))
    site.look(0)
    assert site.look(60) == [DecisionOutcome.SENT]
    assert site.look(61) == []
    assert site.look(360) == [DecisionOutcome.SENT]
    assert {decision.rule_id for decision in site.decisions.values()} == {"low"}


# ---------------------------------------------------------------------- times of day


def test_a_time_of_day_docks_once() -> None:
    site = Site(lunch=AT_ONE)
    rested = robot(battery=0.9, still_since=570.0)
    assert site.look(DUE - 31, rested) == []
    assert site.verdict.watched == set()
    assert site.look(DUE - 30, rested) == []
    assert (site.waits("lunch"), site.verdict.watched) == (WaitReason.NOT_DUE, {"/robot1"})
    (decision,) = site.decide(DUE, rested)
    assert (decision.outcome, decision.scheduled_at) == (DecisionOutcome.SENT, NOON + timedelta(minutes=10))
    assert [site.look(DUE + later, rested) for later in (1, 60, 119, 150)] == [[]] * 4
    assert site.look(DUE + 86_400, rested) == [DecisionOutcome.SENT]


def test_a_robot_that_is_busy_at_that_time_has_two_minutes() -> None:
    site = Site(lunch=AT_ONE)
    busy = robot(goal_running=True)
    assert site.look(DUE, busy) == []
    assert site.look(DUE + 119, robot(still_since=DUE + 105)) == [DecisionOutcome.SENT]
    site = Site(lunch=AT_ONE)
    assert site.look(DUE, busy) == site.look(DUE + 120, busy) == []
    (skipped,) = site.decide(DUE + 121, EMPTY)
    assert (skipped.outcome, skipped.code) == (DecisionOutcome.SKIPPED, "goal_running")
    assert site.look(DUE + 122) == []


def test_a_time_of_day_is_not_made_up_for() -> None:
    site = Site(lunch=AT_ONE)
    assert site.look(DUE + 121) == []  # after a restart, say
    assert site.waits("lunch") is WaitReason.NOT_DUE
    assert Site(lunch=AT_ONE).look(DUE + 120) == [DecisionOutcome.SENT]
    later = changed(AT_ONE, changed_at=NOON + timedelta(seconds=DUE + 1))
    assert Site(lunch=later).look(DUE + 2) == []


def test_a_stop_at_that_time_holds_the_robot() -> None:
    site = Site(lunch=AT_ONE)
    assert site.look(DUE, robot(stopped="stopped by Ada")) == [DecisionOutcome.HELD]
    assert site.look(DUE + 100) == []


def test_a_robot_that_is_docked_at_that_time_stays_where_a_person_drives_it() -> None:
    site = Site(lunch=AT_ONE)
    assert site.look(DUE, robot(docked=True)) == []
    assert site.look(DUE + 60) == []
    assert site.look(DUE + 130) == []


def test_what_was_never_seen_is_not_missed() -> None:
    site = Site(lunch=AT_ONE)
    ghost = robot(heard=False, fresh=False, battery=None, reachable=False)
    assert site.look(DUE, ghost) == site.look(DUE + 121, ghost) == []


# ---------------------------------------------------------------------- several gateways


@pytest.mark.parametrize(
    ("stored", "mine"),
    [
        ({"decided_at": NOON - timedelta(seconds=299)}, {}),
        ({"decided_at": NOON + timedelta(seconds=2)}, {}),  # by another gateway's clock
        ({"rule_id": "other", "open": False}, {}),
        ({"outcome": DecisionOutcome.DRY_RUN}, {"outcome": DecisionOutcome.DRY_RUN}),
        ({"outcome": DecisionOutcome.HELD}, {"outcome": DecisionOutcome.HELD}),
        ({"outcome": DecisionOutcome.GAVE_UP}, {"outcome": DecisionOutcome.GAVE_UP}),
        (
            {"scheduled_at": NOON, "decided_at": NOON - timedelta(hours=1), "outcome": DecisionOutcome.SKIPPED},
            {"scheduled_at": NOON, "open": False},
        ),
    ],
)
def test_one_gateway_decides(stored: dict[str, Any], mine: dict[str, Any]) -> None:
    with pytest.raises(Conflict):
        require_free(decision_entry(**mine), {"a": decision_entry(**stored)})


@pytest.mark.parametrize(
    "stored",
    [
        {"decided_at": NOON - timedelta(minutes=5)},
        {"decided_at": NOON + timedelta(minutes=5)},  # a clock was wrong
        {"robot": "/robot2"},
        {"outcome": DecisionOutcome.DRY_RUN},
        {"outcome": DecisionOutcome.HELD},
    ],
)
def test_a_decision_that_is_free(stored: dict[str, Any]) -> None:
    require_free(decision_entry(), {"a": decision_entry(**stored)})


def test_the_fourth_attempt_is_not_free() -> None:
    earlier = {
        str(n): decision_entry(decided_at=NOON - timedelta(hours=n), outcome=DecisionOutcome.SENT) for n in (1, 2, 3)
    }
    with pytest.raises(Conflict):
        require_free(decision_entry(), earlier)
    require_free(decision_entry(), {name: each.model_copy(update={"open": False}) for name, each in earlier.items()})


# ---------------------------------------------------------------------- just before the goal


@pytest.mark.parametrize(
    ("facts", "obstacle"),
    [
        ({}, None),
        ({"stopped": "stopped"}, WaitReason.STOP_LATCHED),
        ({"goal_running": True}, WaitReason.GOAL_RUNNING),
        ({"battery": 0.5}, WaitReason.BATTERY_OK),
        ({"fresh": False}, WaitReason.BATTERY_UNKNOWN),
        ({"person_at": 59.0, "still_since": 59.0}, WaitReason.QUIET_PERIOD),
    ],
)
def test_what_has_changed_since_the_decision(site: Site, facts: dict[str, Any], obstacle: WaitReason | None) -> None:
    site.look(0)
    assert site.look(60) == [DecisionOutcome.SENT]
    assert site.policy.obstacle("low", LOW_BATTERY, robot(**facts), 60.5) is obstacle


def test_a_rule_that_was_switched_off_since(site: Site) -> None:
    site.look(0)
    for rule in (None, changed(LOW_BATTERY, mode=RuleMode.OFF), changed(LOW_BATTERY, mode=RuleMode.DRY_RUN)):
        assert site.policy.obstacle("low", rule, EMPTY, 60.0) is WaitReason.OFF


@pytest.mark.parametrize(
    ("rule", "facts", "asked"),
    [
        ({}, {}, {"/robot1": 0.2}),
        ({"battery": BatteryCondition(below=0.95, idle_s=60)}, {}, {"/robot1": 0.2}),
        ({"battery": BatteryCondition(below=0.95, idle_s=60)}, {"battery": 0.2}, {}),
        ({"battery": BatteryCondition(below=0.15, idle_s=60)}, {}, {"/robot1": 0.15}),
        ({}, {"goal_running": True, "still_since": None}, {"/robot1": 0.2}),
        ({}, {"held": True}, {"/robot1": 0.2}),  # somebody has let its mission go on
        ({}, {"stopped": "stopped"}, {}),
        ({}, {"battery": 0.2}, {}),
        ({}, {"battery": None}, {}),
        ({}, {"fresh": False}, {}),
        ({}, {"at_work": False}, {}),
        ({"mode": RuleMode.DRY_RUN}, {}, {}),
        ({"battery": None, "schedule": LUNCH}, {}, {}),
    ],
)
def test_whose_mission_is_asked_to_let_its_robot_charge(
    rule: dict[str, Any], facts: dict[str, Any], asked: dict[str, float]
) -> None:
    site = Site(low=changed(LOW_BATTERY, **rule))
    assert site.look(100.0, robot(**{"at_work": True} | facts)) == []
    assert site.verdict.asked == asked


def test_the_higher_limit_of_two_rules_counts_for_a_mission() -> None:
    high = changed(LOW_BATTERY, battery=BatteryCondition(below=0.15, idle_s=60))
    site = Site(a=LOW_BATTERY, b=high)
    site.look(0.0, robot(at_work=True))
    assert site.verdict.asked == {"/robot1": 0.2}
