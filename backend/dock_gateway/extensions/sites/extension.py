"""A hub of many sites, which reaches this gateway over NATS."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.extension import Extension, GatewayCore
from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.extensions.sites.metrics import hub_metrics
from dock_gateway.extensions.sites.settings import SiteSettings


@asynccontextmanager
async def open_sites(core: GatewayCore) -> AsyncIterator[HubLink | None]:
    """Serve the requests of a hub, if there is one."""
    settings = core.settings.of(SiteSettings)
    if not settings.hub:
        yield None
        return
    from dock_gateway.extensions.sites.uplink import Uplink  # noqa: PLC0415 - NATS takes a tenth of a second

    link = HubLink(settings.site)
    core.ways.append(Uplink(settings, core.history, link))
    yield link


extension = Extension("sites", open_sites, settings=SiteSettings, metrics=hub_metrics)
