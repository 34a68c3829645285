"""The ASGI application."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext
from typing import TypedDict

from fastapi import APIRouter, Depends, FastAPI
from starlette.middleware.cors import CORSMiddleware

from dock_gateway import __version__
from dock_gateway.assembly import open_gateway
from dock_gateway.gateway import Gateway
from dock_gateway.observability.request_metrics import RequestMetrics
from dock_gateway.settings import Settings
from dock_gateway.web.access import authorize
from dock_gateway.web.audit import AuditTrail
from dock_gateway.web.dashboard import install_dashboard
from dock_gateway.web.docs import install_docs
from dock_gateway.web.methods import allowed_methods
from dock_gateway.web.openapi import install_openapi
from dock_gateway.web.origin import OriginGuard
from dock_gateway.web.problems import install_problems, problems
from dock_gateway.web.request_meter import RequestMeter
from dock_gateway.web.routes import (
    actions,
    audit,
    automation,
    battery,
    battery_history,
    calibration,
    dock,
    docks,
    exports,
    fleet,
    goals,
    graph,
    health,
    interfaces,
    labels,
    metrics,
    notes,
    provider,
    session,
    simulator,
    statistics,
    stop,
    tokens,
    users,
    webhooks,
)
from dock_gateway.web.streams import events, socket, topics

DESCRIPTION = "Drive ROS 2 actions from a browser, curl or a WebSocket."


class State(TypedDict):
    """State that lives as long as the app runs."""

    gateway: Gateway


def api_routers() -> tuple[APIRouter, ...]:
    """Return the routers of the API, in the order in which they are asked."""
    modules = (
        stop,
        events,
        exports,  # before goals: `export` and `tags` are not goal ids
        notes,
        goals,
        statistics,
        actions,
        interfaces,
        graph,
        battery,
        battery_history,
        fleet,
        labels,
        automation,
        webhooks,
        docks,
        calibration,
        simulator,
        session,
        provider,
        users,
        tokens,
        audit,
        health,
        metrics,
        socket,
        topics,
    )
    return (*dock.routers, *(module.router for module in modules))


def create_app(settings: Settings, gateway: Gateway | None = None) -> FastAPI:
    """Create the application.

    Args:
        settings: The settings.
        gateway: An open gateway. Without one, the application joins the ROS graph at startup and leaves it at shutdown.
    """

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[State]:
        async with open_gateway(settings) if gateway is None else nullcontext(gateway) as opened:
            yield {"gateway": opened}

    app = FastAPI(
        title="dock-gateway",
        version=__version__,
        description=DESCRIPTION,
        lifespan=lifespan,
        openapi_url=None,
        docs_url=None,
        redoc_url=None,
        swagger_ui_oauth2_redirect_url=None,
        generate_unique_id_function=lambda route: route.name,
    )
    routers = api_routers()
    for router in routers:
        app.include_router(router, dependencies=[Depends(authorize)], responses=problems(401, 403))
    install_openapi(app, authentication=settings.authentication)
    install_docs(app)
    install_dashboard(app, settings)
    allowed = allowed_methods([*(route for router in routers for route in router.routes), *app.routes])
    if settings.allowed_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.allowed_origins,
            allow_methods=("GET", "POST", "PUT", "DELETE"),
            allow_headers=(
                "Authorization",
                "Content-Type",
                "Idempotency-Key",
                "If-None-Match",
                "Last-Event-ID",
                "Prefer",
                "Traceparent",
                "Tracestate",
                "X-Request-ID",
            ),
            expose_headers=("Content-Disposition", "ETag", "Location", "Retry-After", "X-Request-ID"),
            allow_private_network=True,  # a robot's address is usually in one
        )
    app.add_middleware(AuditTrail)
    app.add_middleware(OriginGuard, settings=settings)
    install_problems(app, allowed)  # what is added last is the outermost
    app.state.requests = RequestMetrics()
    app.add_middleware(RequestMeter, metrics=app.state.requests)
    return app
