"""Addresses that are sent alerts."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.tasks import closing
from dock_gateway.extension import Core, Extension
from dock_gateway.extensions.webhooks.metrics import webhook_metrics
from dock_gateway.extensions.webhooks.notifier import Notifier, make_notifier
from dock_gateway.extensions.webhooks.routes import router


@asynccontextmanager
async def open_webhooks(core: Core) -> AsyncIterator[Notifier]:
    """Send alerts to webhooks."""
    async with closing(make_notifier(core.history, core.alerts, core.labels, core.share)) as notifier:
        yield notifier


extension = Extension("webhooks", open_webhooks, routes=lambda _: (router,), metrics=webhook_metrics)
