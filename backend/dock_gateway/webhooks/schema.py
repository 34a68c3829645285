"""The JSON shapes of webhooks, which receive alerts, and of what was sent to them."""

from datetime import datetime
from typing import Annotated, Literal

import httpx2
from pydantic import AfterValidator, ConfigDict, Field, JsonValue, field_validator

from dock_gateway.core import webhook as stored
from dock_gateway.core.event import utc_now
from dock_gateway.core.webhook import SEVERITIES, DeliveryState, EventType
from dock_gateway.fleet.schema import Alert
from dock_gateway.http.bodies import Name60, expected
from dock_gateway.http.schema import RobotSelection, Schema
from dock_gateway.webhooks.sender import MAX_SECRET, MIN_SECRET, is_secret

MAX_URL = 2000
SCHEMES = ("http", "https")

WEBHOOK_EXAMPLE: JsonValue = {
    "name": "Control room",
    "url": "https://hooks.example.com/robots",
    "enabled": True,
    "severities": ["critical"],
    "robots": {"all": False, "names": ["/robot1"], "groups": ["hall 1"]},
    "by": "Ada",
}


class NotifiedAlert(Alert):
    """An alert as a webhook gets it: with the name and the groups of its robot."""

    display_name: str | None
    groups: list[str]


class NoAlert(Schema):
    """What a test is about."""


class WebhookEvent(Schema):
    """The body that a webhook gets. `text` says the same in a line."""

    type: EventType
    timestamp: datetime
    text: str
    data: NotifiedAlert | NoAlert


class Delivery(Schema):
    """One event for one webhook. `id` is the header `webhook-id`, the same at each attempt.

    `next_at` is when it is sent next; null unless it is pending. `status_code` and `error` are those of the last
    attempt.
    """

    id: str
    webhook_id: str
    type: EventType
    at: datetime
    event: WebhookEvent
    state: DeliveryState
    attempts: int
    next_at: datetime | None
    tried_at: datetime | None
    status_code: int | None
    error: str | None


class DeliveryList(Schema):
    """Deliveries, newest first."""

    deliveries: list[Delivery]


def _check_url(value: str) -> str:
    what = f"an address with http or https, of up to {MAX_URL} characters"
    try:
        url = httpx2.URL(value)
        invalid = url.scheme not in SCHEMES or not url.host or " " in value.strip() or "%20" in url.host
        invalid = invalid or len(value) > MAX_URL or not 0 < (url.port or 1) < 2**16
    except (httpx2.InvalidURL, ValueError):
        raise expected(what) from None
    if invalid:
        raise expected(what)
    if url.userinfo:
        raise expected("an address without a user name and password", "got one with them")
    return value.strip()


Url = Annotated[
    str,
    AfterValidator(_check_url),
    Field(description="`http` or `https`, without a password", json_schema_extra={"maxLength": MAX_URL}),
]
Severity = Literal["critical", "warning"]


class WebhookFields(Schema):
    """What makes a webhook."""

    name: Name60
    url: Url
    enabled: bool = True
    severities: list[Severity] = Field(
        ["critical", "warning"], min_length=1, max_length=2, description="Both by default"
    )
    robots: Annotated[
        RobotSelection, Field(description="All by default. Alerts of the gateway itself are always sent")
    ] = RobotSelection(all=True)


class WebhookBody(WebhookFields):
    """A webhook that is stored. Without a `secret`, it keeps its own; a new one gets a random one."""

    model_config = ConfigDict(json_schema_extra={"examples": [WEBHOOK_EXAMPLE]})

    secret: Annotated[
        str | None,
        Field(description=f"Signs what is sent: `whsec_` and {MIN_SECRET} to {MAX_SECRET} bytes in base64"),
    ] = None
    by: Name60 | None = None

    @field_validator("secret")
    @classmethod
    def _is_secret(cls, value: str | None) -> str | None:
        if value is not None and not is_secret(value):
            raise expected(f"whsec_ and {MIN_SECRET} to {MAX_SECRET} bytes in base64", "got something else")
        return value

    def webhook(self) -> stored.Webhook:
        """Return the webhook, changed now. Its secret is empty if the body has none."""
        return stored.Webhook(
            name=self.name,
            url=self.url,
            secret=self.secret or "",
            enabled=self.enabled,
            severities=tuple(severity for severity in SEVERITIES if severity in self.severities),
            every_robot=self.robots.all,
            robots=self.robots.names,
            groups=self.robots.groups,
            changed_by=self.by,
            changed_at=utc_now(),
        )


class Webhook(WebhookFields):
    """An address that receives alerts. `pending` counts the deliveries that are still to be sent."""

    id: str
    changed_by: str | None
    changed_at: datetime
    pending: int
    last_delivery: Delivery | None


class StoredWebhook(Webhook):
    """A webhook that was stored. `secret` is there only if the gateway has just made it, and is not shown again."""

    secret: str | None


class WebhookList(Schema):
    """The webhooks, by name."""

    webhooks: list[Webhook]
