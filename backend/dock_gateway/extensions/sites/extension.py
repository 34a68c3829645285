"""A hub of many sites, which reaches this gateway over NATS."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.extension import Extension
from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.extensions.sites.metrics import hub_metrics
from dock_gateway.extensions.sites.settings import SiteSettings
from dock_gateway.http.further_ways import FurtherWays
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from dock_gateway.storage import History


@asynccontextmanager
async def open_sites(parts: Parts) -> AsyncIterator[HubLink | None]:
    """Serve the requests of a hub, if there is one."""
    settings = parts[Settings].of(SiteSettings)
    if not settings.nats:
        yield None
        return
    from dock_gateway.extensions.sites.uplink import Uplink  # noqa: PLC0415 - NATS takes a tenth of a second

    link = HubLink(settings.site)
    with parts[FurtherWays].adding(Uplink(settings, parts[History], link)):
        yield link


extension = Extension("sites", open_sites, settings=SiteSettings, metrics=hub_metrics)
