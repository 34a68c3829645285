"""One alert, and the kinds that there are."""

import hashlib
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from typing import Any

from dock_gateway.fleet.findings import FindingKind


@dataclass(frozen=True)
class Acknowledgement:
    """Who has acknowledged an alert, and when."""

    by: str
    at: datetime


class AlertKind(StrEnum):
    """The kinds of alerts."""

    STOP_LATCHED = "stop_latched"
    GOAL_LOST = "goal_lost"
    DISCHARGING_ON_DOCK = "discharging_on_dock"
    LOW_BATTERY = "low_battery"
    BATTERY_IMPLAUSIBLE = "battery_implausible"
    BATTERY_STALE = "battery_stale"
    HISTORY_LOST = "history_lost"
    RECORDINGS_FAILED = "recordings_failed"
    DUPLICATE_ACTION_SERVER = "duplicate_action_server"
    AUTOMATIC_DOCKING_FAILED = "automatic_docking_failed"
    SPLIT_ROBOT = "split_robot"
    WRONG_TOPIC_TYPE = FindingKind.WRONG_TOPIC_TYPE.value
    DUPLICATE_BASE = FindingKind.DUPLICATE_BASE.value
    ROBOT_SEEN_TWICE = FindingKind.ROBOT_SEEN_TWICE.value
    ROBOTS_CLAIMED_TWICE = FindingKind.ROBOTS_CLAIMED_TWICE.value
    COMMANDS_LOST = FindingKind.COMMANDS_LOST.value
    # Of what spans several sites.
    SITE_UNREACHABLE = "site_unreachable"
    SITE_REFUSED = "site_refused"

    @property
    def critical(self) -> bool:
        """Whether an operator must act, if the alert itself does not say."""
        return self not in WARNINGS


# Faults on the ROS graph.
ON_GRAPH = frozenset(map(AlertKind, (*FindingKind, AlertKind.DUPLICATE_ACTION_SERVER, AlertKind.SPLIT_ROBOT)))
WARNINGS = frozenset(
    {
        AlertKind.LOW_BATTERY,
        AlertKind.BATTERY_IMPLAUSIBLE,
        AlertKind.BATTERY_STALE,
        AlertKind.HISTORY_LOST,
        AlertKind.RECORDINGS_FAILED,
        AlertKind.ROBOT_SEEN_TWICE,
        AlertKind.SPLIT_ROBOT,
        AlertKind.WRONG_TOPIC_TYPE,
        AlertKind.SITE_UNREACHABLE,
        AlertKind.SITE_REFUSED,
    }
)


@dataclass(frozen=True)
class Alert:
    """One alert. `since`: when it began. `detail`: what to do about it. `robot` None: it concerns the gateway.

    `urgent`: whether it is critical although others of its kind are not.
    """

    kind: AlertKind
    robot: str | None
    since: datetime
    title: str
    detail: str
    goal_id: str | None = None
    urgent: bool = False

    @property
    def critical(self) -> bool:
        """Whether an operator must act."""
        return self.urgent or self.kind.critical

    @property
    def id(self) -> str:
        """The id, which is the same at every gateway and when the alert recurs."""
        return alert_id(self.kind, self.robot, self.goal_id)

    def document(self, acknowledgement: Acknowledgement | None) -> dict[str, Any]:
        """Return the alert as `GET /alerts` shows it, ready for `orjson`."""
        return {
            "id": self.id,
            "kind": self.kind.value,
            "robot": self.robot,
            "severity": "critical" if self.critical else "warning",
            "since": self.since,
            "title": self.title,
            "detail": self.detail,
            "goal_id": self.goal_id,
            "acknowledged": acknowledgement,
        }


def alert_id(kind: AlertKind, robot: str | None, goal_id: str | None = None) -> str:
    """Return the id of an alert, for use in a path."""
    return hashlib.sha256(f"{kind.value} {robot or ''} {goal_id or ''}".encode()).hexdigest()[:16]
