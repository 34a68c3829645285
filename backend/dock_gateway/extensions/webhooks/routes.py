"""`/webhooks`: addresses that receive alerts."""

from typing import Annotated

from fastapi import APIRouter, Depends
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.extensions.webhooks.schema import Delivery, DeliveryList, StoredWebhook, Webhook, WebhookList
from dock_gateway.extensions.webhooks.webhook import WebhookBody
from dock_gateway.extensions.webhooks.webhooks import Webhooks
from dock_gateway.http.bodies import SignedBody
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import ADMIN_IF_FORWARDED
from dock_gateway.http.requests import (
    SLUG_IN_PATH,
    Answer,
    CursorQuery,
    LimitQuery,
    end_of_page,
    json_response,
    read_slug,
)
from dock_gateway.http.resource import ChangeCondition, Item, WriteCondition, item_response, removed
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Webhooks"], prefix="/webhooks", dependencies=[ADMIN_IF_FORWARDED])


async def _webhook_id_in_path(webhook_id: Annotated[str, SLUG_IN_PATH]) -> str:
    return read_slug(webhook_id, "webhook_id")


WebhookId = Annotated[str, Depends(_webhook_id_in_path)]


@router.get("")
@operation(Role.SUPERVISOR, Scope.EVERY)
async def list_webhooks(webhooks: Part[Webhooks]) -> Answer[WebhookList]:
    """List the webhooks by name, each with its last delivery. Secrets are not shown."""
    return json_response({"webhooks": await webhooks.documents()})


@router.get("/{webhook_id}")
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(404,))
async def get_webhook(webhook_id: WebhookId, webhooks: Part[Webhooks]) -> Item[Webhook]:
    """Return a webhook with its last delivery. Its secret is not shown."""
    return item_response(await webhooks.document(webhook_id))


@router.put("/{webhook_id}")
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(409,))
async def replace_webhook(
    webhook_id: WebhookId, body: SignedBody[WebhookBody], webhooks: Part[Webhooks], condition: WriteCondition
) -> Item[StoredWebhook]:
    """Store a webhook, new or changed, at every gateway that shares the history.

    It receives the present alerts, and then each that begins or ends.
    """
    webhook, new = await webhooks.replace(webhook_id, body.entry(), condition)
    return item_response(webhook, f"{router.prefix}/{webhook_id}" if new else None)


@router.delete("/{webhook_id}", status_code=204)
@operation(Role.SUPERVISOR, Scope.EVERY)
async def remove_webhook(webhook_id: WebhookId, webhooks: Part[Webhooks], condition: ChangeCondition) -> Response:
    """Remove a webhook with its deliveries. What has not been sent yet is not sent."""
    return await removed(webhooks.remove(webhook_id, condition))


@router.post("/{webhook_id}/test")
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(404, 409))
async def test_webhook(webhook_id: WebhookId, webhooks: Part[Webhooks]) -> Answer[Delivery]:
    """Send a test now, once, also to a webhook that is off. The answer says what came of it, after 10 s at most."""
    return json_response(await webhooks.test(webhook_id))


@router.get("/{webhook_id}/deliveries")
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(404,))
async def list_deliveries(
    webhook_id: WebhookId, webhooks: Part[Webhooks], limit: LimitQuery = 50, cursor: CursorQuery = None
) -> Answer[DeliveryList]:
    """List what was and is to be sent to a webhook, newest first. The last 500 of all webhooks are kept."""
    found, end = await webhooks.deliveries(webhook_id, limit, end_of_page(cursor))
    return json_response({"deliveries": found, "next_cursor": end and end.encode()})
