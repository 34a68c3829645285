"""One alert."""

import hashlib
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from dock_gateway.core.versions import entity_tag
from dock_gateway.fleet.alert_kinds import AlertKind


@dataclass(frozen=True)
class Acknowledgement:
    """The acknowledgement of an alert: by whom, and when."""

    by: str
    acknowledged_at: datetime


@dataclass(frozen=True)
class Alert:
    """One alert. `started_at`: when it began. `detail`: what to do about it. `robot` None: it concerns the gateway.

    `urgent`: whether it is critical although others of its kind are not.
    """

    kind: AlertKind
    robot: str | None
    started_at: datetime
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

    def etag(self, acknowledgement: Acknowledgement | None) -> str:
        """Return the entity tag of the alert, which changes only with who has acknowledged it."""
        return entity_tag([self.id, acknowledgement])

    def document(self, acknowledgement: Acknowledgement | None) -> dict[str, Any]:
        """Return the alert as `GET /alerts` shows it, ready for `orjson`."""
        return {
            "id": self.id,
            "etag": self.etag(acknowledgement),
            "kind": self.kind.value,
            "robot": self.robot,
            "severity": "critical" if self.critical else "warning",
            "started_at": self.started_at,
            "title": self.title,
            "detail": self.detail,
            "goal_id": self.goal_id,
            "acknowledged": acknowledgement,
        }


def alert_id(kind: AlertKind, robot: str | None, goal_id: str | None = None) -> str:
    """Return the id of an alert, for use in a path."""
    return hashlib.sha256(f"{kind.value} {robot or ''} {goal_id or ''}".encode()).hexdigest()[:16]
