"""Webhooks and what is sent to them. Plain data."""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from dock_gateway.core.goal import Json
from dock_gateway.core.robot_choice import RobotChoice

SEVERITIES = ("critical", "warning")


@dataclass(frozen=True)
class Webhook(RobotChoice):
    """An address that receives alerts.

    Attributes:
        name: What people call it.
        url: The address, `http` or `https`.
        secret: Signs what is sent: `whsec_` and base64.
        enabled: Whether alerts are sent.
        severities: Those of the alerts that are sent, of `SEVERITIES`.
        every_robot: Whether the alerts of every robot are sent; otherwise of those of `robots` and `groups`.
        robots: Namespaces.
        groups: Groups, as `PUT /robots/label` sets them.
        changed_by: Who changed the webhook last, if known.
        changed_at: When that was.
    """

    name: str
    url: str
    secret: str
    enabled: bool
    severities: tuple[str, ...]
    every_robot: bool
    robots: tuple[str, ...]
    groups: tuple[str, ...]
    changed_by: str | None
    changed_at: datetime

    def wants(self, severity: str, robot: str | None, groups: tuple[str, ...]) -> bool:
        """Return whether an alert is sent. One without a robot concerns the gateway, and so everybody."""
        if not self.enabled or severity not in self.severities:
            return False
        return robot is None or self.covers(robot, groups)


class EventType(StrEnum):
    """What happened."""

    RAISED = "alert.raised"
    CLEARED = "alert.cleared"
    TEST = "test"


class DeliveryState(StrEnum):
    """Whether a delivery is still to be sent, was answered with success, or was given up."""

    PENDING = "pending"
    DELIVERED = "delivered"
    FAILED = "failed"


@dataclass(frozen=True)
class Delivery:
    """One event for one webhook.

    Attributes:
        webhook_id: The webhook.
        event_type: What happened.
        state: What came of it.
        alert_id: The alert; None for a test.
        at: When it happened.
        body: What is sent.
        attempts: How often it was sent.
        next_at: When it is sent next; None unless it is pending.
        tried_at: When it was sent last.
        status_code: The HTTP status of the last answer, if there was one.
        error: Why the last attempt failed, if it did.
    """

    webhook_id: str
    event_type: EventType
    state: DeliveryState
    alert_id: str | None
    at: datetime
    body: Json
    attempts: int
    next_at: datetime | None
    tried_at: datetime | None
    status_code: int | None
    error: str | None
