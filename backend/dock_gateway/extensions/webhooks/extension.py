"""Addresses that are sent alerts."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.alerts import Alerts
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.extensions.webhooks.error_codes import CODES
from dock_gateway.extensions.webhooks.metrics import webhook_metrics
from dock_gateway.extensions.webhooks.notifier import Notifier, make_notifier
from dock_gateway.extensions.webhooks.routes import router
from dock_gateway.http.parts import Parts
from dock_gateway.robots.robots import RobotLabels
from dock_gateway.storage import History


@asynccontextmanager
async def open_webhooks(parts: Parts) -> AsyncIterator[Notifier]:
    """Send alerts to webhooks."""
    notifier = make_notifier(parts[History], parts[Alerts], parts[RobotLabels], parts[Share])
    async with closing(notifier):
        yield notifier


extension = Extension("webhooks", open_webhooks, routes=lambda _: (router,), metrics=webhook_metrics, errors=CODES)
