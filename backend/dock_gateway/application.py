"""An ASGI application of routers, with all that those of one site and of many have in common."""

from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, TypedDict

from fastapi import APIRouter, Depends, FastAPI
from pydantic import BaseModel
from starlette.middleware.cors import CORSMiddleware
from starlette.routing import BaseRoute

from dock_gateway import __version__
from dock_gateway.access.authorization import authorize
from dock_gateway.audit.trail import AuditTrail
from dock_gateway.core.error_codes import CORE, ErrorCode
from dock_gateway.http.dashboard import install_dashboard
from dock_gateway.http.docs import install_docs
from dock_gateway.http.methods import AllowedMethods, HeadAsGet, allowed_methods
from dock_gateway.http.openapi import Models, Union, install_openapi, serve_document
from dock_gateway.http.operation import require_declared, require_distinct
from dock_gateway.http.origin import OriginGuard
from dock_gateway.http.parts import Parts
from dock_gateway.http.problems import install_problems
from dock_gateway.http.router_prefix import match_own_prefix
from dock_gateway.http.schema import Problem
from dock_gateway.http.upgrades import install_upgrades
from dock_gateway.observability.request_meter import RequestMeter
from dock_gateway.observability.request_metrics import RequestMetrics
from dock_gateway.settings import Settings

Document = dict[str, Any]


class State(TypedDict):
    """State that lives as long as the app runs."""

    parts: Parts


@dataclass(frozen=True)
class Contents:
    """The contents of an API's documents besides its routes.

    Attributes:
        description: What the API is for.
        unions: The messages of streams, which no route names.
        models: Further models that no route names.
        messages: Returns the schemas of ROS messages, by name.
        values: Further values of enumerations, by the name of the component.
        codes: Further error codes.
        fields: Further fields of components, by the name of the component: the model of each, which may be null.
        asyncapi: Makes the AsyncAPI document from the OpenAPI document, if there is one.
    """

    description: str
    unions: Sequence[Union] = ()
    models: Models = ()
    messages: Callable[[], Document] = dict
    values: Mapping[str, Sequence[str]] = field(default_factory=dict)
    codes: Sequence[ErrorCode] = ()
    fields: Mapping[str, Mapping[str, type[BaseModel]]] = field(default_factory=dict)
    asyncapi: Callable[[Document], Document] | None = None


def build_app(
    settings: Settings,
    routers: Sequence[APIRouter],
    open_parts: Callable[[], AbstractAsyncContextManager[Parts]],
    contents: Contents,
) -> FastAPI:
    """Build an application.

    Args:
        settings: The settings.
        routers: The routers of the API, in the order in which they are asked.
        open_parts: Opens the parts, which the routes find by their types, until the application has shut down.
        contents: What its documents say besides.

    Raises:
        BadRoute: A route does not say what it needs, would not be in the audit log, or is there twice.
    """

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[State]:
        async with open_parts() as parts:
            yield {"parts": parts}

    app = FastAPI(
        title="dock-gateway",
        version=__version__,
        description=contents.description,
        lifespan=lifespan,
        openapi_url=None,
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,  # `install_problems` does
        swagger_ui_oauth2_redirect_url=None,
        generate_unique_id_function=lambda route: route.name,
    )
    routes = _add_routes(app, routers)
    _add_documents(app, settings, contents)
    install_upgrades(app, routes)
    _add_middleware(app, settings, allowed_methods([*routes, *app.routes]))
    return app


def _add_routes(app: FastAPI, routers: Sequence[APIRouter]) -> list[BaseRoute]:
    routes = [route for router in routers for route in router.routes]
    require_distinct(routes)
    require_declared(routes)
    for router in routers:
        before = len(app.router.routes)
        app.include_router(router, dependencies=[Depends(authorize)])
        for included in app.router.routes[before:]:
            match_own_prefix(included, [getattr(route, "path", "") for route in router.routes])
    return routes


def _add_documents(app: FastAPI, settings: Settings, contents: Contents) -> None:
    install_openapi(
        app,
        authentication=settings.authentication,
        unions=contents.unions,
        models=(Problem, *contents.models),
        messages=contents.messages,
        values=contents.values,
        codes=[*CORE, *contents.codes],
        fields=contents.fields,
    )
    if (make := contents.asyncapi) is not None:
        serve_document(app, "/asyncapi.json", lambda: make(app.openapi()))
    install_docs(app)
    install_dashboard(app, settings)


def _add_middleware(app: FastAPI, settings: Settings, allowed: AllowedMethods) -> None:
    """Add what is around the routes; the last one added is the outermost."""
    if settings.allowed_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.allowed_origins,
            allow_methods=("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE"),
            # A page that may use the gateway may use all of it: a list of headers would miss new ones.
            allow_headers="*",
            expose_headers="*",
            allow_private_network=True,  # a robot's address is usually in one
        )
    app.add_middleware(AuditTrail)
    app.add_middleware(OriginGuard, settings=settings)
    install_problems(app, allowed, many_sites=settings.many_sites)
    app.state.requests = RequestMetrics()
    app.add_middleware(RequestMeter, metrics=app.state.requests)
    app.add_middleware(HeadAsGet)
