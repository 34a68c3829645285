"""What the API returns about webhooks, and what these receive."""

from datetime import datetime

from dock_gateway.extensions.webhooks.delivery import DeliveryFields, EventType
from dock_gateway.extensions.webhooks.webhook import ChangedWebhook
from dock_gateway.fleet.schema import Alert
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import Identified, Schema


class NotifiedAlert(Alert):
    """An alert as a webhook gets it: with the name and the groups of its robot."""

    display_name: str | None
    groups: list[str]


class EmptyAlert(Schema):
    """What a test is about."""


class WebhookEvent(Schema):
    """The body that a webhook gets. `text` says the same in a line."""

    type: EventType
    timestamp: datetime
    text: str
    data: NotifiedAlert | EmptyAlert


class Delivery(DeliveryFields, Identified):
    """One event for one webhook. `id` is the header `webhook-id`, the same at each attempt.

    `next_at` is when it is sent next; null unless it is pending. `status_code` and `error` are those of the last
    attempt.
    """

    event: WebhookEvent


class DeliveryList(Schema):
    """A page of deliveries, newest first. `next_cursor` leads to older ones; null: there are none."""

    deliveries: list[Delivery]
    next_cursor: str | None


class Webhook(ChangedWebhook, Versioned):
    """An address that receives alerts. `pending` counts the deliveries that are still to be sent."""

    id: str
    pending: int
    last_delivery: Delivery | None


class StoredWebhook(Webhook):
    """A webhook that was stored. `secret` is there only if the gateway has just made it, and is not shown again."""

    secret: str | None


class WebhookList(Schema):
    """The webhooks, by name."""

    webhooks: list[Webhook]
