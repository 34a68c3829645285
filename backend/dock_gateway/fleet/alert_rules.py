"""The rules that decide when to raise an alert, checked periodically. No ROS, no socket, no clock."""

from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime, timedelta

from dock_gateway.core.battery import CHARGES_NEGATIVE
from dock_gateway.core.filters import is_hidden, lineage, parent_of
from dock_gateway.core.goal import LOST_FOR, Goal
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.findings import Finding
from dock_gateway.fleet.robot_state import DRAINS, RobotState
from dock_gateway.goals.hints import Join
from dock_gateway.storage import Incident

# Seconds that a docked robot may be without power: contacts bounce, chargers start slowly.
WITHOUT_POWER = 10.0
# Seconds that a docking server and a battery may be in two namespaces: while robots start, not everything is there.
SPLIT_FOR = 15.0
# Charge (0 to 1) from which a battery counts as full and need not be charged.
FULL = 0.99
# How long a battery state must be stale before an alert is raised.
STALE_FOR = timedelta(seconds=5)
# Hysteresis: how far (0 to 1) a low battery must rise above the limit before its alert ends.
MARGIN = 0.05
# Seconds for which an alert about a low battery lasts while its charge is unknown.
UNKNOWN_FOR = 30.0


NO_DUPLICATES: Mapping[str, list[str]] = {}


class AlertRules:
    """Finds alerts. Keeps the state that it needs between checks.

    Args:
        low_battery: Charge (0 to 1) below which a battery is low.
    """

    def __init__(self, low_battery: float) -> None:
        self._low_battery = low_battery
        self._low_since: dict[str, datetime] = {}  # by robot
        self._low_at: dict[str, float] = {}  # when it was known last
        self._implausible_since: dict[str, datetime] = {}
        self._without_power: dict[str, tuple[datetime, float]] = {}
        self._duplicate_since: dict[str, datetime] = {}  # by robot
        self._split_since: dict[tuple[str, str], tuple[datetime, float]] = {}  # by the namespaces of both parts
        self._found_since: dict[tuple[str, str | None], datetime] = {}  # by kind and robot

    def evaluate(
        self,
        states: list[RobotState],
        strays: Iterable[Goal],
        now: datetime,
        seconds: float,
        *,
        incident: Incident | None = None,
        duplicates: Mapping[str, list[str]] = NO_DUPLICATES,
        findings: Iterable[Finding] = (),
        split: Iterable[Join] = (),
        further: Iterable[Alert] = (),
    ) -> list[Alert]:
        """Return the alerts, critical ones first, then oldest first.

        Args:
            states: The robots.
            strays: Lost goals on actions that belong to no robot.
            now: The current time.
            seconds: The current time on a monotonic clock, in seconds.
            incident: The incident of the history, if there is one.
            duplicates: By robot, the actions that have more than one server.
            findings: Faults on the ROS graph, once for each kind and robot.
            split: Robots that are probably in two namespaces.
            further: What extensions have found.
        """
        alerts = [*_stops(states), *_lost(states, strays, now), *self._duplicates(duplicates, now)]
        alerts += [*self._found(list(findings), now), *self._split(list(split), now, seconds)]
        if incident is not None:
            alerts.append(Alert(alert_kinds.HISTORY_LOST, None, incident.since, "History lost", incident.detail))
        alerts += further
        for state in states:
            alerts += self._discharging(state, now, seconds)
            alerts += self._low(state, now, seconds)
            alerts += self._implausible(state, now)
            alerts += _stale(state, now)
        return sorted(alerts, key=lambda alert: (not alert.critical, alert.started_at, alert.id))

    def _duplicates(self, duplicates: Mapping[str, list[str]], now: datetime) -> Iterator[Alert]:
        self._duplicate_since = {robot: self._duplicate_since.get(robot, now) for robot in duplicates}
        for robot, actions in duplicates.items():
            names = " and ".join(sorted(actions))
            yield Alert(
                alert_kinds.DUPLICATE_ACTION_SERVER,
                robot,
                self._duplicate_since[robot],
                "Two action servers",
                f"More than one action server serves {names}, and each of them moves the robot. Shut down all but one.",
            )

    def _split(self, joins: list[Join], now: datetime, seconds: float) -> Iterator[Alert]:
        keys = ((each.robot, each.other) for each in joins)
        self._split_since = {key: self._split_since.get(key, (now, seconds)) for key in keys}
        for each in joins:
            since, began = self._split_since[each.robot, each.other]
            if seconds - began >= SPLIT_FOR:
                yield Alert(
                    alert_kinds.SPLIT_ROBOT,
                    each.robot,
                    since,
                    "One robot in two namespaces?",
                    f"{each.robot} has a battery and no docking server, {each.other} has a docking server and no "
                    f"battery. {each.detail}",
                )

    def _found(self, findings: list[Finding], now: datetime) -> Iterator[Alert]:
        keys = ((each.kind.value, each.robot) for each in findings)
        self._found_since = {key: self._found_since.get(key, now) for key in keys}
        for each in findings:
            since = self._found_since[each.kind.value, each.robot]
            kind = alert_kinds.OF_FINDINGS[each.kind]
            yield Alert(kind, each.robot, since, each.title, each.detail, urgent=each.critical)

    def _discharging(self, state: RobotState, now: datetime, seconds: float) -> Iterator[Alert]:
        full = state.battery.reading.percentage is not None and state.battery.reading.percentage >= FULL
        if full or state.charging is not False or not state.on_dock or state.docking(state.dock, state.undock):
            self._without_power.pop(state.name, None)
            return
        since, began = self._without_power.setdefault(state.name, (now, seconds))
        if seconds - began >= WITHOUT_POWER:
            yield Alert(
                alert_kinds.DISCHARGING_ON_DOCK,
                state.name,
                since,
                "Not charging on the dock",
                f"{state.name} is docked, but its battery is not charging. Check the contacts and the charger, or "
                f"undock the robot and dock it again.{_about_current(state)}",
            )

    def _low(self, state: RobotState, now: datetime, seconds: float) -> Iterator[Alert]:
        reading, name, limit = state.battery.reading, state.name, self._low_battery
        if name in self._low_since:
            limit += MARGIN
        low = reading.percentage is not None and reading.percentage < limit and self._low_battery > 0
        if low:
            self._low_at[name] = seconds
        elif reading.percentage is None and reading.doubts and name in self._low_since:  # one wrong value ends nothing
            low = seconds - self._low_at[name] < UNKNOWN_FOR
        # A docked robot whose battery does not tell what it does is where it should be.
        helped = state.charging or (state.charging is None and state.on_dock)
        if not low or helped or state.docking(state.dock):
            self._low_since.pop(name, None)
            self._low_at.pop(name, None)
            return
        since = self._low_since.setdefault(name, now)
        yield Alert(alert_kinds.LOW_BATTERY, name, since, "Low battery", self._about_low(state))

    def _about_low(self, state: RobotState) -> str:
        """Return what the battery was, what to do, and when the alert ends; not what it is now, which changes."""
        charging = "" if state.charging is None else " and is not charging"
        advice = (
            f", although it is docked. Check the contacts and the charger.{_about_current(state)}"
            if state.on_dock
            else ". Send the robot to its dock."
        )
        return (
            f"The battery of {state.name} fell below {self._low_battery:.0%}{charging}{advice} "
            f"This alert ends at {self._low_battery + MARGIN:.0%}, when a docking goal runs, or when it charges."
        )

    def _implausible(self, state: RobotState, now: datetime) -> Iterator[Alert]:
        named = state.battery.reading.named
        if not named:
            self._implausible_since.pop(state.name, None)
            return
        yield Alert(
            alert_kinds.BATTERY_IMPLAUSIBLE,
            state.name,
            self._implausible_since.setdefault(state.name, now),
            "Implausible battery state",
            f"Values on {state.battery_topic} cannot be right and are not used. "
            f"{' '.join(doubt.sentence for doubt in named)}",
        )


def _about_current(state: RobotState) -> str:
    """Return what tells that a docked robot is not charging, if it is its current alone."""
    if state.battery.reading.power_supply in DRAINS:
        return ""
    return (
        " Its status is UNKNOWN, but current flows out of it. If its driver counts a charging current as negative, "
        f"set {CHARGES_NEGATIVE} for the robot."
    )


def _stops(states: list[RobotState]) -> Iterator[Alert]:
    """Yield one alert for each stopped robot; it includes the robots below."""
    held = {state.name: state.stop for state in states if state.stop["latched"]}
    for name, stop in held.items():
        if any(above in held for above in _above(name)):
            continue
        unstored = "" if stop["persisted"] else " It is not stored: a restart of the gateway would lose it."
        others = sum(other != name and name in _above(other) for other in held)
        names = f"{name}{f' and {others} below it' if others else ''}"
        stopped = f"{stop['by']} stopped {names}" if stop["by"] else f"{names} was stopped"
        yield Alert(
            alert_kinds.STOP_LATCHED,
            name,
            stop["stopped_at"],
            "Stopped",
            f"{stopped}: goals are refused. Check that the area is clear, then release the stop.{unstored}",
        )


def _above(name: str) -> list[str]:
    """Return the namespaces that contain a robot."""
    return [each for each in lineage(name) if each != name]


def _seen_once(lost: list[Goal]) -> list[Goal]:
    """Leave out goals on hidden actions, to which a relay passes on the goals of others, if there are others."""
    return [goal for goal in lost if not is_hidden(goal.action_name)] or lost


def _lost(states: list[RobotState], strays: Iterable[Goal], now: datetime) -> Iterator[Alert]:
    goals = [(state.name, goal) for state in states for goal in _seen_once(state.lost)]
    goals += [(parent_of(goal.action_name), goal) for goal in strays]
    for robot, goal in goals:
        since = goal.finished_at or goal.updated_at
        if now - since < LOST_FOR:
            reason = "" if goal.error is None else f": {goal.error.detail}"
            yield Alert(
                alert_kinds.GOAL_LOST,
                robot,
                since,
                "Goal lost",
                f"Lost contact during the goal on {goal.action_name}; the state of the robot is unknown{reason}. "
                "Check that it stands still, then start its action server again. The alert ends with the next goal "
                "that the server accepts.",
                goal.goal_id,
            )


def _stale(state: RobotState, now: datetime) -> Iterator[Alert]:
    since = state.battery.stale_since
    if since is not None and now - since > STALE_FOR:
        yield Alert(
            alert_kinds.BATTERY_STALE,
            state.name,
            since,
            "No battery state",
            f"There are no messages on {state.battery_topic}. Check that {state.name} is switched on and in range, "
            "and that its battery driver runs.",
        )
