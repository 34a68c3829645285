"""A delivery to a webhook. A new field is declared here alone."""

from datetime import datetime
from enum import StrEnum
from typing import Any

from pydantic import ConfigDict

from dock_gateway.http.schema import Schema

Document = dict[str, Any]


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


class DeliveryFields(Schema):
    """One event for one webhook.

    Attributes:
        webhook_id: The webhook.
        type: The type of the event.
        created_at: When it happened.
        state: Whether it was delivered.
        attempts: Number of attempts.
        next_at: When it is sent next; None unless it is pending.
        tried_at: When it was sent last.
        status_code: The HTTP status of the last answer, if there was one.
        error: Why the last attempt failed, if it did.
    """

    model_config = ConfigDict(frozen=True)

    webhook_id: str
    type: EventType
    created_at: datetime
    state: DeliveryState
    attempts: int
    next_at: datetime | None
    tried_at: datetime | None
    status_code: int | None
    error: str | None


class DeliveryEntry(DeliveryFields):
    """A delivery as it is stored.

    Attributes:
        alert_id: The alert; None for a test.
        event: The event as it is sent: JSON, whose times are texts.
    """

    alert_id: str | None
    event: Document

    def document(self, identity: str) -> Document:
        """Return the delivery as the API shows it."""
        return {"id": identity, **self.model_dump(exclude={"alert_id"})}
