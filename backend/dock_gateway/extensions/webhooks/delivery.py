"""A delivery to a webhook. Plain data; `webhook.py` has the webhooks."""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from dock_gateway.core.goal import Json


class EventType(StrEnum):
    """The type of an event."""

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
        event_type: The type of the event.
        state: Whether it was delivered.
        alert_id: The alert; None for a test.
        created_at: When it happened.
        body: The body of the request.
        attempts: Number of attempts.
        next_at: When it is sent next; None unless it is pending.
        tried_at: When it was sent last.
        status_code: The HTTP status of the last answer, if there was one.
        error: Why the last attempt failed, if it did.
    """

    webhook_id: str
    event_type: EventType
    state: DeliveryState
    alert_id: str | None
    created_at: datetime
    body: Json
    attempts: int
    next_at: datetime | None
    tried_at: datetime | None
    status_code: int | None
    error: str | None
