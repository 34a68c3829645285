"""Decides which robots dock by themselves. Pure: facts in, decisions out; no I/O, and no clock of its own.

A robot docks only if all that is known about it is recent and speaks for it. Any doubt means that it stays where it is.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any

from dock_gateway.extensions.automation.decision import DecisionEntry, DecisionOutcome, RuleMode, WaitReason
from dock_gateway.extensions.automation.past import MAX_ATTEMPTS, RETRY_INTERVAL, Key, Past
from dock_gateway.extensions.automation.rule import RuleEntry
from dock_gateway.extensions.automation.schedule import last_due, next_due

# Seconds without automatic docking after a person canceled a goal of the robot.
QUIET_PERIOD = 60.0
# How far (0 to 1) the battery must rise above the limit to count as recovered.
RECOVERY_MARGIN = 0.05
# Seconds for which a robot must have stood still when a time of day is due.
STILL_FOR = 10.0
# How long after a time of day robots are docked that could not be docked at that time.
DUE_FOR = timedelta(minutes=2)
# How much longer it is recorded which of them were not docked.
RECORDED_FOR = timedelta(seconds=30)
# The charge (0 to 1) below which a rule asks a mission to let its robot charge, unless the rule's own limit is lower:
# a rule that keeps robots on their chargers does not call them from their work.
ASK_BELOW = 0.2
# How long before a time of day it is watched whether robots move.
WATCHED_BEFORE = timedelta(seconds=30)


@dataclass(frozen=True)
class RobotFacts:
    """The facts about a robot.

    Attributes:
        name: Its namespace.
        groups: The groups that it is in.
        heard: Whether it has a docking server or has ever sent a battery state.
        fresh: Whether its battery state is recent.
        battery: Its charge (0 to 1), if measured.
        docked: Whether it is docked or its battery is being charged.
        reachable: Whether its only docking server answers.
        shares_dock: Whether its docking action is that of other robots, too.
        goal_running: Whether a goal runs on one of its actions.
        goal_lost: Whether contact was lost during a goal, so that it may run.
        at_work: Whether it has work of which a goal is only a part, such as a mission.
        stopped: Which stop is latched for it, in words; None if none is.
        still_since: Since when it was not seen to move or to run a goal, in seconds on a monotonic clock;
            None if its velocity is not heard.
        held: Whether it was stopped, and no person has continued its automatic docking since.
        person_at: When a person last canceled a goal of it, on the same clock; None if never.
        failed_at: When its last docking goal ended, if it did not succeed.
    """

    name: str
    groups: tuple[str, ...] = ()
    heard: bool = True
    fresh: bool = True
    battery: float | None = None
    docked: bool = False
    reachable: bool = True
    shares_dock: bool = False
    goal_running: bool = False
    goal_lost: bool = False
    at_work: bool = False
    stopped: str | None = None
    held: bool = False
    still_since: float | None = None
    person_at: float | None = None
    failed_at: datetime | None = None


@dataclass
class Verdict:
    """The decision about a robot now.

    Attributes:
        decisions: New decisions, at most one for each robot. The robot of each that is `sending` is to be docked.
        recovered: The ids of open decisions that no longer count, as their battery has recovered, their robot is
            docked, or their rule is off or gone.
        waits: Why rules do not dock robots now.
        watched: The robots that are about to be docked, unless they move.
        asked: The robots at work whose battery is low, with the charge (0 to 1) below which that is so: a rule does not
            dock them, it asks their mission to let them charge.
    """

    decisions: list[DecisionEntry] = field(default_factory=list)
    recovered: list[str] = field(default_factory=list)
    waits: dict[Key, WaitReason] = field(default_factory=dict)
    watched: set[str] = field(default_factory=set)
    asked: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Case:
    """A rule that applies to a robot, now; arguments as for `DockingPolicy.decide`.

    `last_due` and `next_due` are the last and the next time of day of the rule, if it has any.
    """

    key: Key
    rule: RuleEntry
    robot: RobotFacts
    now: datetime
    seconds: float
    last_due: datetime | None
    next_due: datetime | None


class DockingPolicy:
    """Applies the rules. Keeps since when each battery has been low, and which times of day are done."""

    def __init__(self) -> None:
        self._low_since: dict[Key, float] = {}
        self._late: dict[Key, tuple[datetime, WaitReason]] = {}  # robots that could not be docked at a time of day
        self._at_dock: dict[Key, datetime] = {}  # robots that were docked at a time of day

    def decide(
        self,
        rules: Mapping[str, RuleEntry],
        robots: Iterable[RobotFacts],
        decisions: Mapping[str, DecisionEntry],
        now: datetime,
        seconds: float,
    ) -> Verdict:
        """Return what to do now.

        Args:
            rules: The rules, by id.
            robots: The robots.
            decisions: All earlier decisions that count, of all gateways.
            now: The current time.
            seconds: The current time on the monotonic clock of the facts.
        """
        verdict, past = Verdict(), Past(decisions)
        known = {robot.name: robot for robot in robots}
        verdict.recovered = [
            identity
            for identity, decision in decisions.items()
            if decision.open
            and decision.outcome is not DecisionOutcome.SENDING
            and _has_recovered(rules.get(decision.rule_id), known.get(decision.robot))
        ]
        looked_at: set[Key] = set()
        for rule_id, rule in sorted(rules.items()):
            schedule = None if rule.mode is RuleMode.OFF else rule.schedule
            last, coming = (None, None) if schedule is None else (last_due(schedule, now), next_due(schedule, now))
            for robot in known.values():
                if rule.mode is not RuleMode.OFF and rule.robots.covers(robot.name, robot.groups):
                    looked_at.add((rule_id, robot.name))
                    self._decide(verdict, past, Case((rule_id, robot.name), rule, robot, now, seconds, last, coming))
        memories: tuple[dict[Key, Any], ...] = (self._low_since, self._late, self._at_dock)
        for memory in memories:
            for key in memory.keys() - looked_at:
                del memory[key]
        return verdict

    def obstacle(self, rule_id: str, rule: RuleEntry | None, robot: RobotFacts, seconds: float) -> WaitReason | None:
        """Return what speaks against docking a robot right now, after it was decided; None if nothing does."""
        if rule is None or rule.mode is not RuleMode.ON or not rule.robots.covers(robot.name, robot.groups):
            return WaitReason.OFF
        if not robot.fresh:
            return WaitReason.BATTERY_UNKNOWN
        if rule.battery is not None and (robot.battery is None or robot.battery >= rule.battery.below):
            return WaitReason.BATTERY_OK
        if wait := _obstacle(rule, robot, self._low_since.get((rule_id, robot.name)), seconds):
            return wait
        return None if robot.stopped is None else WaitReason.STOP_LATCHED

    def _decide(self, verdict: Verdict, past: Past, case: Case) -> None:
        rule, robot, key = case.rule, case.robot, case.key
        due = None if rule.schedule is None else self._due(verdict, past, case)
        outcome = None
        wait = self._unmet(verdict, case, due)
        if wait is None and _asks(rule, robot):
            verdict.asked[robot.name] = max(_ask_below(rule), verdict.asked.get(robot.name, 0.0))
        low_since = self._low_since.get(key)
        if wait is None:
            wait = _obstacle(rule, robot, low_since, case.seconds)
            if wait is WaitReason.DOCKED and due is not None:
                self._at_dock[key] = due
        if wait is None:
            wait, outcome = _next_step(past, case)
        if due is not None:
            wait, outcome = self._in_time(case, due, wait, outcome)
        verdict.waits[key] = wait or WaitReason.DECIDING
        if outcome is None or any(decision.robot == robot.name for decision in verdict.decisions):
            return  # or another rule decides first
        since = None if robot.still_since is None else max(robot.still_since, low_since or robot.still_since)
        held = outcome is DecisionOutcome.HELD
        verdict.decisions.append(
            DecisionEntry(
                rule_id=key[0],
                rule_name=rule.name,
                robot=robot.name,
                decided_at=case.now,
                outcome=outcome,
                battery=robot.battery if robot.fresh else None,
                idle_since_at=None if since is None else case.now - timedelta(seconds=case.seconds - since),
                scheduled_at=due,
                goal_id=None,
                code=WaitReason.STOP_LATCHED.value if held else wait.value if wait is not None else None,
                detail=robot.stopped if held else None,
                open=due is None,
            )
        )

    # ------------------------------------------------------------------ conditions

    def _unmet(self, verdict: Verdict, case: Case, due: datetime | None) -> WaitReason | None:
        """Return why the condition of a rule is not met, or None."""
        robot, condition = case.robot, case.rule.battery
        if condition is None:
            if due is None:
                return WaitReason.NOT_DUE
            return None if robot.fresh else WaitReason.BATTERY_UNKNOWN
        if not robot.fresh or robot.battery is None or robot.battery >= condition.below:
            self._low_since.pop(case.key, None)
            return WaitReason.BATTERY_OK if robot.fresh and robot.battery is not None else WaitReason.BATTERY_UNKNOWN
        self._low_since.setdefault(case.key, case.seconds)
        if not robot.docked:
            verdict.watched.add(robot.name)
        return None

    def _due(self, verdict: Verdict, past: Past, case: Case) -> datetime | None:
        """Return the time of day that is still to be decided on, or None."""
        due = case.last_due
        if case.next_due is not None and case.next_due - case.now <= WATCHED_BEFORE:
            verdict.watched.add(case.robot.name)
        if due is None or case.now - due > DUE_FOR + RECORDED_FOR or due < case.rule.changed_at:
            return None
        if past.decided(case.key, due) or self._at_dock.get(case.key) == due:
            return None
        verdict.watched.add(case.robot.name)
        return due

    def _in_time(
        self, case: Case, due: datetime, wait: WaitReason | None, outcome: DecisionOutcome | None
    ) -> tuple[WaitReason | None, DecisionOutcome | None]:
        """Replace the decision on a time of day that has passed: the robot is not docked any more."""
        if case.now - due <= DUE_FOR:
            if wait is not None and case.robot.heard:
                self._late[case.key] = (due, wait)
            return wait, outcome
        late = self._late.pop(case.key, None)
        if late is None or late[0] != due or wait is WaitReason.DOCKED:
            return WaitReason.NOT_DUE, None
        return late[1], DecisionOutcome.SKIPPED if case.robot.stopped is None else DecisionOutcome.HELD


def _ask_below(rule: RuleEntry) -> float:
    """Return the charge below which a rule asks missions to let their robots charge."""
    return 0.0 if rule.battery is None or rule.mode is not RuleMode.ON else min(rule.battery.below, ASK_BELOW)


def _asks(rule: RuleEntry, robot: RobotFacts) -> bool:
    """Return whether a rule asks the mission of a robot to let it charge. That moves no robot by itself."""
    low = robot.battery is not None and robot.battery < _ask_below(rule)
    return low and robot.at_work and robot.stopped is None


def _obstacle(rule: RuleEntry, robot: RobotFacts, low_since: float | None, seconds: float) -> WaitReason | None:
    """Return why a robot whose condition is met cannot be docked, or None. A latched stop is another matter."""
    still_since = robot.still_since
    still_for = 0.0 if still_since is None else seconds - max(still_since, low_since or still_since)
    obstacles = {
        WaitReason.DOCKED: robot.docked,
        WaitReason.SERVER_UNAVAILABLE: not robot.reachable,
        WaitReason.SHARED_ACTION: robot.shares_dock,
        WaitReason.GOAL_RUNNING: robot.goal_running,
        WaitReason.GOAL_LOST: robot.goal_lost,
        WaitReason.AT_WORK: robot.at_work,
        WaitReason.STOPPED: robot.held and robot.stopped is None,
        WaitReason.QUIET_PERIOD: robot.stopped is None
        and robot.person_at is not None
        and seconds - robot.person_at < QUIET_PERIOD,
        WaitReason.NOT_IDLE: still_since is None
        or still_for < (STILL_FOR if rule.battery is None else rule.battery.idle_s),
    }
    return next((wait for wait, applies in obstacles.items() if applies), None)


def _next_step(past: Past, case: Case) -> tuple[WaitReason | None, DecisionOutcome | None]:
    """Return what to do with a robot that should dock, or what to wait for."""
    key, robot = case.key, case.robot
    if past.has(key, DecisionOutcome.GAVE_UP):
        return WaitReason.GAVE_UP, None
    if robot.stopped is not None:
        return WaitReason.STOP_LATCHED, None if past.has(key, DecisionOutcome.HELD) else DecisionOutcome.HELD
    if case.rule.mode is RuleMode.DRY_RUN:
        return (
            (WaitReason.REPORTED, None) if past.has(key, DecisionOutcome.DRY_RUN) else (None, DecisionOutcome.DRY_RUN)
        )
    failed = robot.failed_at is not None and abs(case.now - robot.failed_at) < RETRY_INTERVAL
    if failed or past.is_recent(robot.name, case.now):
        return WaitReason.RETRY_LATER, None
    if past.attempts(key) >= MAX_ATTEMPTS:
        return WaitReason.GAVE_UP, DecisionOutcome.GAVE_UP
    return None, DecisionOutcome.SENDING


def _has_recovered(rule: RuleEntry | None, robot: RobotFacts | None) -> bool:
    """Return whether a rule starts from the beginning with a robot."""
    if rule is None or rule.mode is RuleMode.OFF or rule.battery is None:
        return True
    if robot is None or not robot.fresh:
        return False
    charged = robot.battery is not None and robot.battery >= min(1.0, rule.battery.below + RECOVERY_MARGIN)
    return robot.docked or charged
