"""`/webhooks`: addresses that receive alerts."""

from typing import Annotated

import httpx2
from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.event import utc_now
from dock_gateway.core.webhook import SEVERITIES, Webhook
from dock_gateway.http.fields import (
    ROBOTS_REQUEST,
    SLUG_IN_PATH,
    read_choice,
    read_flag,
    read_robots,
    read_slug,
    read_texts,
)
from dock_gateway.http.openapi import body
from dock_gateway.http.principal import read_signed_json
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    LimitQuery,
    TheGateway,
    json_response,
    known_query,
    name_schema,
    read_name,
    read_object,
)
from dock_gateway.webhooks.schema import WEBHOOK_EXAMPLE, Delivery, DeliveryList, StoredWebhook, WebhookList
from dock_gateway.webhooks.sender import MAX_SECRET, MIN_SECRET, is_secret

router = APIRouter(tags=["Webhooks"], prefix="/webhooks")

NO_QUERY = Depends(known_query())
FIELDS = ("name", "url", "secret", "enabled", "severities", "robots", "by")
MAX_NAME, MAX_URL = 60, 2000
SCHEMES = ("http", "https")
WEBHOOK_REQUEST = {
    "type": "object",
    "required": ["name", "url"],
    "additionalProperties": False,
    "properties": {
        "name": name_schema(MAX_NAME),
        "url": {"type": "string", "maxLength": MAX_URL, "description": "`http` or `https`, without a password"},
        "secret": {
            "type": ["string", "null"],
            "description": f"Signs what is sent: `whsec_` and {MIN_SECRET} to {MAX_SECRET} bytes in base64. Without "
            "it, a webhook keeps its secret; a new one gets a random one",
        },
        "enabled": {"type": "boolean", "description": "`true` by default"},
        "severities": {
            "type": "array",
            "minItems": 1,
            "maxItems": len(SEVERITIES),
            "items": {"enum": list(SEVERITIES)},
            "description": "Both by default",
        },
        "robots": ROBOTS_REQUEST | {"description": "All by default. Alerts of the gateway itself are always sent"},
        "by": name_schema(MAX_NAME) | {"type": ["string", "null"], "description": "Who changes the webhook"},
    },
    "examples": [WEBHOOK_EXAMPLE],
}


async def _webhook_id_in_path(webhook_id: Annotated[str, SLUG_IN_PATH]) -> str:
    return read_slug(webhook_id, "webhook_id")


WebhookId = Annotated[str, Depends(_webhook_id_in_path)]


@router.get("", response_model=WebhookList, responses=problems(422, 503), dependencies=[NO_QUERY])
async def list_webhooks(gateway: TheGateway) -> Response:
    """List the webhooks by name, each with its last delivery. Secrets are not shown."""
    return json_response({"webhooks": await gateway.notifier.documents()})


@router.put(
    "/{webhook_id}",
    response_model=StoredWebhook,
    responses=problems(400, 408, 409, 413, 415, 422, 503),
    dependencies=[NO_QUERY],
    openapi_extra=body(WEBHOOK_REQUEST, required=True),
)
async def replace_webhook(webhook_id: WebhookId, request: Request, gateway: TheGateway) -> Response:
    """Store a webhook, new or changed, at every gateway that shares the history.

    It receives the present alerts, and then each that begins or ends.
    """
    return json_response(await gateway.notifier.replace(webhook_id, read_webhook(await read_signed_json(request))))


@router.delete("/{webhook_id}", status_code=204, responses=problems(404, 422, 503), dependencies=[NO_QUERY])
async def remove_webhook(webhook_id: WebhookId, gateway: TheGateway) -> Response:
    """Remove a webhook with its deliveries. What has not been sent yet is not sent."""
    await gateway.notifier.remove(webhook_id)
    return Response(status_code=204)


@router.post(
    "/{webhook_id}/test", response_model=Delivery, responses=problems(404, 409, 422, 503), dependencies=[NO_QUERY]
)
async def test_webhook(webhook_id: WebhookId, gateway: TheGateway) -> Response:
    """Send a test now, once, also to a webhook that is off. The answer says what came of it, after 10 s at most."""
    return json_response(await gateway.notifier.test(webhook_id))


@router.get(
    "/{webhook_id}/deliveries",
    response_model=DeliveryList,
    responses=problems(404, 422, 503),
    dependencies=[Depends(known_query("limit"))],
)
async def list_deliveries(webhook_id: WebhookId, gateway: TheGateway, limit: LimitQuery = 50) -> Response:
    """List what was and is to be sent to a webhook, newest first. The last 500 of all webhooks are kept."""
    return json_response({"deliveries": await gateway.notifier.deliveries(webhook_id, limit)})


def read_webhook(value: object) -> Webhook:
    """Read a webhook from a decoded body. Its secret is empty if the body has none.

    Raises:
        InvalidField: It is not a webhook.
    """
    fields = read_object(value, *FIELDS)
    by = fields.get("by")
    chosen = read_texts(
        fields.get("severities", list(SEVERITIES)), "severities", len(SEVERITIES), "severities", at_least=1
    )
    for index, severity in enumerate(chosen):
        read_choice(severity, SEVERITIES, f"severities.{index}")
    everyone, robots, groups = read_robots(fields.get("robots", {"all": True}))
    return Webhook(
        name=read_name(fields.get("name"), MAX_NAME, "name"),
        url=_read_url(fields.get("url")),
        secret=_read_secret(fields.get("secret")),
        enabled=read_flag(fields.get("enabled", True), "enabled"),
        severities=tuple(severity for severity in SEVERITIES if severity in chosen),
        every_robot=everyone,
        robots=robots,
        groups=groups,
        changed_by=None if by is None else read_name(by, MAX_NAME),
        changed_at=utc_now(),
    )


def _read_url(value: object) -> str:
    expected = f"an address with http or https, of up to {MAX_URL} characters"
    if not isinstance(value, str) or len(value) > MAX_URL:
        raise InvalidField([FieldError("url", expected, got(value))])
    try:
        url = httpx2.URL(value)
        invalid = url.scheme not in SCHEMES or not url.host or " " in value.strip() or "%20" in url.host
        invalid = invalid or not 0 < (url.port or 1) < 2**16
    except (httpx2.InvalidURL, ValueError):
        invalid = True
    if invalid:
        raise InvalidField([FieldError("url", expected, got(value))])
    if url.userinfo:
        raise InvalidField([FieldError("url", "an address without a user name and password", "got one with them")])
    return value.strip()


def _read_secret(value: object) -> str:
    if value is None:
        return ""
    if not isinstance(value, str) or not is_secret(value):
        expected = f"whsec_ and {MIN_SECRET} to {MAX_SECRET} bytes in base64"
        raise InvalidField([FieldError("secret", expected, "got something else")])
    return value
