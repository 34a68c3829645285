"""A webhook: what clients send and get, and what is stored. A new field is declared here alone."""

from datetime import datetime
from typing import Annotated, Literal, get_args

import httpx2
from pydantic import AfterValidator, ConfigDict, Field, JsonValue, field_validator

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.webhooks.sender import MAX_SECRET, MIN_SECRET, is_secret
from dock_gateway.http.bodies import Name60, expected
from dock_gateway.http.schema import RobotSelection, Schema

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
SEVERITIES: tuple[Severity, ...] = get_args(Severity)


class WebhookFields(Schema):
    """The fields of a webhook."""

    name: Name60
    url: Url
    enabled: bool = True
    severities: list[Severity] = Field([*SEVERITIES], min_length=1, max_length=2, description="Both by default")
    robots: Annotated[
        RobotSelection, Field(description="All by default. Alerts of the gateway itself are always sent")
    ] = RobotSelection(all=True)

    @field_validator("severities")
    @classmethod
    def _in_order(cls, severities: list[Severity]) -> list[Severity]:
        return [severity for severity in SEVERITIES if severity in severities]


class ChangedWebhook(WebhookFields):
    """A webhook, with who changed it last, if known, and when."""

    changed_by: str | None
    changed_at: datetime


class WebhookEntry(ChangedWebhook):
    """A webhook as it is stored. `secret` signs what is sent: `whsec_` and base64."""

    secret: str

    def wants(self, severity: str, robot: str | None, groups: tuple[str, ...]) -> bool:
        """Return whether an alert is sent. One without a robot concerns the gateway, and so everybody."""
        if not self.enabled or severity not in self.severities:
            return False
        return robot is None or self.robots.covers(robot, groups)


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

    def entry(self) -> WebhookEntry:
        """Return the webhook, changed now. Its secret is empty if the body has none."""
        fields = {name: getattr(self, name) for name in WebhookFields.model_fields}
        return WebhookEntry(**fields, secret=self.secret or "", changed_by=self.by, changed_at=utc_now())
