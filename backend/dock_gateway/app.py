"""The ASGI application of a gateway."""

from contextlib import AbstractAsyncContextManager, nullcontext
from functools import partial

from fastapi import APIRouter, FastAPI

from dock_gateway import extension_routes
from dock_gateway.access import session_routes, token_routes, user_routes
from dock_gateway.application import Contents, build_app
from dock_gateway.assembly import open_gateway
from dock_gateway.doors.rest import (
    action_routes,
    battery_routes,
    dock_routes,
    fleet_routes,
    parameter_routes,
    publish_routes,
    sent_goals,
    service_routes,
    stop_routes,
)
from dock_gateway.extension import Installed, extensions
from dock_gateway.gateways import routes as gateway_routes
from dock_gateway.goals import approval_routes, export_routes, history_routes, note_routes
from dock_gateway.goals.schema import ACTION_EVENTS
from dock_gateway.graph import interface_routes
from dock_gateway.graph import routes as graph_routes
from dock_gateway.http.openapi import Union
from dock_gateway.http.parts import Parts
from dock_gateway.observability import metrics_routes
from dock_gateway.observability import routes as health_routes
from dock_gateway.robots import calibration_routes
from dock_gateway.ros.messages.battery_schema import battery_schemas
from dock_gateway.settings import Settings
from dock_gateway.stop.schema import StopProblem
from dock_gateway.streams import events, socket, topics
from dock_gateway.streams.asyncapi import asyncapi_document
from dock_gateway.streams.command_schema import ANSWERS, COMMAND_SCHEMAS
from dock_gateway.streams.includes import type_of
from dock_gateway.streams.schema import EVENTS
from dock_gateway.streams.topic_schema import ECHO_EVENTS


def _contents(installed: Installed) -> Contents:
    """Return what the documents say besides the routes: what streams and `/ws` send, and what `/ws` reads."""
    further = installed.events
    return Contents(
        description="Drive ROS 2 actions from a browser, curl or a WebSocket.",
        unions=(
            Union("Event", (*EVENTS, *further), "A message of an event stream."),
            Union("ActionEvent", ACTION_EVENTS, "An event of a goal on an action other than docking."),
            Union("EchoEvent", ECHO_EVENTS, "A message of /ws/topics."),
            Union("Answer", ANSWERS, "The answer to a command of /ws.", discriminator=None),
            Union("Command", COMMAND_SCHEMAS, "A command of /ws.", "op", "validation", socket.OPERATIONS),
        ),
        models=(StopProblem,),
        messages=battery_schemas,
        values={
            "AlertKind": [kind.value for kind in installed.kinds],
            "Include": [type_of(event) for event in installed.events],
        },
        codes=installed.errors,
        fields=dict.fromkeys(("Goal", "ExportedGoal"), installed.goal_fields),
        asyncapi=partial(asyncapi_document, further=further),
    )


def api_routers(settings: Settings, installed: Installed) -> list[APIRouter]:
    """Return the routers of the API, in the order in which they are asked. No extension comes before a stop.

    Args:
        settings: Say which extensions serve.
        installed: The extensions.
    """
    return [
        sent_goals.dock,
        sent_goals.undock,
        dock_routes.router,
        stop_routes.router,
        events.router,
        *installed.routers(settings),
        export_routes.router,  # before goals: `export` and `tags` are not goal ids
        note_routes.router,
        history_routes.router,
        sent_goals.canceling,
        sent_goals.of_action,
        action_routes.router,
        approval_routes.router,
        interface_routes.router,
        graph_routes.router,
        service_routes.router,
        parameter_routes.router,
        publish_routes.router,
        battery_routes.router,
        fleet_routes.router,
        gateway_routes.router,
        calibration_routes.router,
        session_routes.router,
        user_routes.router,
        token_routes.router,
        health_routes.router,
        metrics_routes.router,
        extension_routes.router,
        socket.router,
        topics.router,
    ]


def create_app(settings: Settings, parts: Parts | None = None, installed: Installed | None = None) -> FastAPI:
    """Create the application.

    Args:
        settings: The settings.
        parts: Those of an open gateway. Without them, the application joins the ROS graph at startup and leaves it at
            shutdown.
        installed: The extensions; default: those of the parts, else all.
    """
    if installed is None:
        installed = extensions() if parts is None else parts[Installed]

    def opened() -> AbstractAsyncContextManager[Parts]:
        return open_gateway(settings, installed) if parts is None else nullcontext(parts)

    return build_app(settings, api_routers(settings, installed), opened, _contents(installed))
