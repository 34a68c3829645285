"""The ASGI application of a hub."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext
from dataclasses import replace

from fastapi import APIRouter, FastAPI

from dock_gateway.access import session_routes, token_routes, user_routes
from dock_gateway.application import Contents, build_app
from dock_gateway.extension import Installed
from dock_gateway.goals import export_routes, history_routes
from dock_gateway.http.dashboard import page_of
from dock_gateway.http.openapi import Union
from dock_gateway.http.operation import public_operation
from dock_gateway.http.parts import Parts
from dock_gateway.observability import metrics_routes
from dock_gateway.settings import Settings
from dock_gateway.streams import events
from dock_gateway.streams.schema import (
    ClosingEvent,
    DroppedEvent,
    GapEvent,
    HeartbeatEvent,
    ResultEvent,
    ResumedEvent,
    StatusEvent,
)
from dock_hub import forwarding, routes, stop_routes
from dock_hub.assembly import open_hub
from dock_hub.error_codes import CODES
from dock_hub.extensions import hub_extensions
from dock_hub.schema import (
    GOAL_FIELDS,
    HubAlertsEvent,
    HubApprovalsEvent,
    HubRobotsEvent,
    HubSnapshotEvent,
    SitesEvent,
)
from dock_hub.settings import HubSettings, hub_settings_type
from dock_hub.stop_schema import HubReleaseProblem, HubStopProblem

EVENTS = (
    HubSnapshotEvent,
    StatusEvent,
    ResultEvent,
    HubRobotsEvent,
    HubAlertsEvent,
    HubApprovalsEvent,
    SitesEvent,
    HeartbeatEvent,
    DroppedEvent,
    ResumedEvent,
    GapEvent,
    ClosingEvent,
)
CONTENTS = Contents(
    description="Many sites behind one hub. `/sites/{site}/…` is the API of a site, with the site's own names; all "
    "else spans the sites, with names that have the site in front: `/berlin/robot1`.",
    unions=(Union("Event", EVENTS, "A message of an event stream of the hub."),),
    models=(HubStopProblem, HubReleaseProblem),
    codes=CODES,
    fields=dict.fromkeys(("Goal", "ExportedGoal"), GOAL_FIELDS),
)
ROUTERS = tuple(
    module.router
    for module in (
        stop_routes,
        routes,
        events,
        export_routes,  # before goals: `export` is not a goal id
        history_routes,
        session_routes,
        user_routes,
        token_routes,
        metrics_routes,
    )
)


def create_hub_app(settings: HubSettings | None = None, parts: Parts | None = None) -> FastAPI:
    """Create the application.

    Args:
        settings: The settings; by default, those of the environment.
        parts: Those of an open hub. Without them, the application opens one at startup and closes it at shutdown.
    """
    settings = settings or hub_settings_type()()
    installed = hub_extensions() if parts is None else parts[Installed]

    @asynccontextmanager
    async def opened() -> AsyncIterator[Parts]:
        async with open_hub(settings, installed) if parts is None else nullcontext(parts) as found:
            yield found

    routers = (*ROUTERS, *installed.routers(settings), _pages_of_sites(settings), forwarding.router)
    contents = replace(CONTENTS, codes=[*CONTENTS.codes, *installed.errors])
    return build_app(settings, routers, opened, contents)


def _pages_of_sites(settings: Settings) -> APIRouter:
    """Serve the dashboard of a site, which is the hub's own build: it finds the site in its address."""
    router, page = APIRouter(), public_operation()(page_of(settings))
    for path in ("/sites/{site}/", "/sites/{site}/ui/{path:path}"):
        router.add_api_route(path, page, methods=["GET"], include_in_schema=False)
    return router
