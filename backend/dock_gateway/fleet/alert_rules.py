"""What an operator has to know of: found by looking at the robots again and again. No ROS, no socket, no clock."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import StrEnum
from typing import Any

from dock_gateway.core.goal import LOST_FOR, Goal
from dock_gateway.fleet.robot_state import CHARGES, RobotState
from dock_gateway.history import Acknowledgement, Incident
from dock_gateway.robots.battery import PowerSupply

# A robot on its dock may be without power for so many seconds: contacts bounce, chargers begin slowly.
WITHOUT_POWER = 10.0
# From here on a battery is full, and need not be charged.
FULL = 0.99
# A battery is stale for so many seconds before that is worth an alert.
STALE_FOR = timedelta(seconds=5)
# A battery that was low has to be so much above the limit until it is not low any more.
MARGIN = 0.05


NO_DUPLICATES: Mapping[str, list[str]] = {}


class AlertKind(StrEnum):
    """Everything that is worth an alert."""

    STOP_LATCHED = "stop_latched"
    GOAL_LOST = "goal_lost"
    DISCHARGING_ON_DOCK = "discharging_on_dock"
    LOW_BATTERY = "low_battery"
    BATTERY_STALE = "battery_stale"
    HISTORY_LOST = "history_lost"
    DUPLICATE_ACTION_SERVER = "duplicate_action_server"

    @property
    def critical(self) -> bool:
        """Whether somebody has to act."""
        return self not in (AlertKind.LOW_BATTERY, AlertKind.BATTERY_STALE, AlertKind.HISTORY_LOST)


@dataclass(frozen=True)
class Alert:
    """One of them. `since` is when it began; `detail` says what to do about it. One of no `robot` is of the gateway."""

    kind: AlertKind
    robot: str | None
    since: datetime
    title: str
    detail: str
    goal_id: str | None = None

    @property
    def id(self) -> str:
        """The same at every gateway, and the same when it comes back."""
        return alert_id(self.kind, self.robot, self.goal_id)

    def document(self, acknowledgement: Acknowledgement | None) -> dict[str, Any]:
        """As `GET /alerts` shows it, ready for `orjson`."""
        return {
            "id": self.id,
            "kind": self.kind.value,
            "robot": self.robot,
            "severity": "critical" if self.kind.critical else "warning",
            "since": self.since,
            "title": self.title,
            "detail": self.detail,
            "goal_id": self.goal_id,
            "acknowledged": acknowledgement,
        }


def alert_id(kind: AlertKind, robot: str | None, goal_id: str | None = None) -> str:
    """What names an alert in a path."""
    return hashlib.sha256(f"{kind.value} {robot or ''} {goal_id or ''}".encode()).hexdigest()[:16]


class AlertRules:
    """Finds the alerts; remembers what it has to since when it looked last.

    Args:
        low_battery: Percentage (0 to 1) below which a battery is low.
    """

    def __init__(self, low_battery: float) -> None:
        self._low_battery = low_battery
        self._low_since: dict[str, datetime] = {}  # by robot
        self._without_power: dict[str, tuple[datetime, float]] = {}
        self._duplicate_since: dict[str, datetime] = {}  # by robot

    def look(
        self,
        states: list[RobotState],
        strays: Iterable[Goal],
        now: datetime,
        seconds: float,
        *,
        incident: Incident | None = None,
        duplicates: Mapping[str, list[str]] = NO_DUPLICATES,
    ) -> list[Alert]:
        """The alerts, critical ones first, then the oldest first.

        Args:
            states: The robots.
            strays: Lost goals on actions that belong to no robot.
            now: The time.
            seconds: The time on a clock that does not jump.
            incident: What happened to the history.
            duplicates: By robot, the actions that have more than one server.
        """
        alerts = [*_stops(states), *_lost(states, strays, now), *self._duplicates(duplicates, now)]
        if incident is not None:
            alerts.append(Alert(AlertKind.HISTORY_LOST, None, incident.since, "History lost", incident.detail))
        for state in states:
            alerts += self._discharging(state, now, seconds)
            alerts += self._low(state, now)
            alerts += _stale(state, now)
        return sorted(alerts, key=lambda alert: (not alert.kind.critical, alert.since, alert.id))

    def _duplicates(self, duplicates: Mapping[str, list[str]], now: datetime) -> Iterator[Alert]:
        self._duplicate_since = {robot: self._duplicate_since.get(robot, now) for robot in duplicates}
        for robot, actions in duplicates.items():
            names = " and ".join(sorted(actions))
            yield Alert(
                AlertKind.DUPLICATE_ACTION_SERVER,
                robot,
                self._duplicate_since[robot],
                "Two action servers",
                f"More than one action server serves {names}, and each of them moves the robot: end all but one.",
            )

    def _discharging(self, state: RobotState, now: datetime, seconds: float) -> Iterator[Alert]:
        reading = state.battery.reading
        discharges = reading.power_supply in (PowerSupply.DISCHARGING, PowerSupply.NOT_CHARGING)
        full = reading.percentage is not None and reading.percentage >= FULL
        if full or not discharges or not state.on_dock or state.docking(state.dock, state.undock):
            self._without_power.pop(state.name, None)
            return
        since, began = self._without_power.setdefault(state.name, (now, seconds))
        if seconds - began >= WITHOUT_POWER:
            yield Alert(
                AlertKind.DISCHARGING_ON_DOCK,
                state.name,
                since,
                "Not charging on the dock",
                f"{state.name} is docked, and its battery is not charged: look at the contacts and the charger, or "
                "undock the robot and dock it again.",
            )

    def _low(self, state: RobotState, now: datetime) -> Iterator[Alert]:
        reading, limit = state.battery.reading, self._low_battery
        if state.name in self._low_since:
            limit += MARGIN
        low = reading.percentage is not None and reading.percentage < limit and self._low_battery > 0
        if not low or reading.power_supply in CHARGES or state.docking(state.dock):
            self._low_since.pop(state.name, None)
            return
        yield Alert(
            AlertKind.LOW_BATTERY,
            state.name,
            self._low_since.setdefault(state.name, now),
            "Low battery",
            f"The battery of {state.name} has fallen below {self._low_battery:.0%} and is not charged: send the robot "
            "to its dock.",
        )


def _stops(states: list[RobotState]) -> Iterator[Alert]:
    """One for each robot that was stopped; those below are in it."""
    held = {state.name: state.stop for state in states if state.stop["latched"]}
    for name, stop in held.items():
        if any(above in held for above in _above(name)):
            continue
        unstored = "" if stop["persisted"] else " It is not stored: a restart of the gateway would forget it."
        others = sum(other != name and name in _above(other) for other in held)
        yield Alert(
            AlertKind.STOP_LATCHED,
            name,
            stop["since"],
            "Stopped",
            f"{stop['by'] or 'Somebody'} stopped {name}{f' and {others} below it' if others else ''}: no goal is sent. "
            f"See that the way is clear, then release the stop.{unstored}",
        )


def _above(name: str) -> list[str]:
    """The namespaces that a robot is in."""
    parts = name.strip("/").split("/") if name != "/" else []
    return [f"/{'/'.join(parts[:length])}" for length in range(len(parts))]


def _lost(states: list[RobotState], strays: Iterable[Goal], now: datetime) -> Iterator[Alert]:
    goals = [(state.name, goal) for state in states for goal in state.lost]
    goals += [(goal.action_name.rpartition("/")[0] or "/", goal) for goal in strays]
    for robot, goal in goals:
        since = goal.finished_at or goal.updated_at
        if now - since < LOST_FOR:
            reason = "" if goal.error is None else f": {goal.error.detail}"
            yield Alert(
                AlertKind.GOAL_LOST,
                robot,
                since,
                "Goal lost",
                f"Nobody knows how the goal on {goal.action_name} goes on{reason}. See that the robot stands still, "
                "then start its action server again.",
                goal.goal_id,
            )


def _stale(state: RobotState, now: datetime) -> Iterator[Alert]:
    since = state.battery.stale_since
    if since is not None and now - since > STALE_FOR:
        yield Alert(
            AlertKind.BATTERY_STALE,
            state.name,
            since,
            "No battery state",
            f"Nothing is heard on {state.battery_topic} any more: see whether {state.name} is switched on and in "
            "reach, and its battery driver runs.",
        )
