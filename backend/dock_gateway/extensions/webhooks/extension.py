"""Addresses that alerts are sent to."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

from dock_gateway.core.alerts import Alerts
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import closed_by
from dock_gateway.extension import Extension
from dock_gateway.extensions.webhooks.delivery import DeliveryEntry
from dock_gateway.extensions.webhooks.error_codes import CODES
from dock_gateway.extensions.webhooks.metrics import webhook_metrics
from dock_gateway.extensions.webhooks.notifier import Notifier
from dock_gateway.extensions.webhooks.outbox import Outbox
from dock_gateway.extensions.webhooks.routes import router
from dock_gateway.extensions.webhooks.webhook import WebhookEntry
from dock_gateway.extensions.webhooks.webhooks import MAX_WEBHOOKS, Webhooks
from dock_gateway.http.parts import Parts
from dock_gateway.robots.robots import RobotLabels
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries


@asynccontextmanager
async def open_webhooks(parts: Parts) -> AsyncIterator[Webhooks]:
    """Send alerts to webhooks."""
    async with AsyncExitStack() as stack:
        history, alerts = parts[History], parts[Alerts]
        book = SharedBook(history.documents("webhook", WebhookEntry), "webhook", MAX_WEBHOOKS)
        outbox = closed_by(stack, Outbox(book, SharedEntries(history.documents("delivery", DeliveryEntry))))
        notifier = closed_by(stack, Notifier(alerts, parts[RobotLabels], book, outbox, parts[Share]))
        stack.enter_context(alerts.on_change.adding(notifier.compare))
        notifier.start()
        yield Webhooks(book, outbox, notifier)


extension = Extension("webhooks", open_webhooks, routes=lambda _: (router,), metrics=webhook_metrics, errors=CODES)
