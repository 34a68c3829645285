"""The ASGI application of a gateway."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext

from fastapi import APIRouter, FastAPI

from dock_gateway.access import provider_routes, session_routes, token_routes, user_routes
from dock_gateway.application import Contents, build_app
from dock_gateway.assembly import open_gateway
from dock_gateway.audit import routes as audit_routes
from dock_gateway.automation import routes as automation_routes
from dock_gateway.cameras import routes as camera_routes
from dock_gateway.doors.rest import (
    action_routes,
    battery_routes,
    dock_routes,
    fleet_routes,
    goal_routes,
    parameter_routes,
    publish_routes,
    service_routes,
    stop_routes,
)
from dock_gateway.foxglove import routes as foxglove_routes
from dock_gateway.gateways import routes as gateway_routes
from dock_gateway.goals import approval_routes, export_routes, note_routes
from dock_gateway.goals import routes as history_routes
from dock_gateway.goals.schema import ACTION_EVENTS
from dock_gateway.graph import interface_routes
from dock_gateway.graph import routes as graph_routes
from dock_gateway.http.openapi import Union
from dock_gateway.http.parts import Parts
from dock_gateway.maps import routes as map_routes
from dock_gateway.observability import metrics_routes
from dock_gateway.observability import routes as health_routes
from dock_gateway.recordings import routes as recording_routes
from dock_gateway.robots import calibration_routes, simulator_routes
from dock_gateway.ros.messages.battery_schema import battery_schemas
from dock_gateway.rosbridge import routes as rosbridge_routes
from dock_gateway.settings import Settings
from dock_gateway.statistics import routes as statistics_routes
from dock_gateway.stop.schema import StopProblem
from dock_gateway.streams import events, socket, topics
from dock_gateway.streams.asyncapi import asyncapi_document
from dock_gateway.streams.command_schema import ANSWERS, COMMAND_SCHEMAS
from dock_gateway.streams.schema import EVENTS
from dock_gateway.streams.topic_schema import ECHO_EVENTS
from dock_gateway.webhooks import routes as webhook_routes

# What streams and `/ws` send, and what `/ws` reads.
UNIONS = (
    Union("Event", EVENTS, "A message of an event stream."),
    Union("ActionEvent", ACTION_EVENTS, "An event of a goal on an action other than docking."),
    Union("EchoEvent", ECHO_EVENTS, "A message of /ws/topics."),
    Union("Answer", ANSWERS, "The answer to a command of /ws.", discriminator=None),
    Union("Command", COMMAND_SCHEMAS, "A command of /ws.", "op", "validation", socket.OPERATIONS),
)
CONTENTS = Contents(
    description="Drive ROS 2 actions from a browser, curl or a WebSocket.",
    unions=UNIONS,
    models=(StopProblem,),
    messages=battery_schemas,
    asyncapi=asyncapi_document,
)


def api_routers() -> tuple[APIRouter, ...]:
    """Return the routers of the API, in the order in which they are asked."""
    return (
        goal_routes.dock,
        goal_routes.undock,
        dock_routes.router,
        stop_routes.router,
        events.router,
        export_routes.router,  # before goals: `export` and `tags` are not goal ids
        note_routes.router,
        recording_routes.router,
        history_routes.router,
        goal_routes.anywhere,
        statistics_routes.router,
        goal_routes.of_action,
        action_routes.router,
        approval_routes.router,
        interface_routes.router,
        graph_routes.router,
        service_routes.router,
        parameter_routes.router,
        publish_routes.router,
        battery_routes.router,
        map_routes.router,
        camera_routes.router,
        fleet_routes.router,
        gateway_routes.router,
        automation_routes.router,
        webhook_routes.router,
        calibration_routes.router,
        simulator_routes.router,
        session_routes.router,
        provider_routes.router,
        user_routes.router,
        token_routes.router,
        audit_routes.router,
        health_routes.router,
        metrics_routes.router,
        socket.router,
        topics.router,
        rosbridge_routes.router,
        foxglove_routes.router,
    )


def _agent_routers(settings: Settings) -> tuple[APIRouter, ...]:
    """Return the router of agents, if they are let in: `mcp` takes 0.5 s and 18 MB."""
    if not settings.mcp:
        return ()
    from dock_gateway.agents.routes import router  # noqa: PLC0415

    return (router,)


@asynccontextmanager
async def _serve_agents(parts: Parts) -> AsyncIterator[None]:
    from dock_gateway.agents.server import AgentServer  # noqa: PLC0415 - see above

    parts.add(AgentServer, server := AgentServer())
    async with server.running():
        yield


@asynccontextmanager
async def _open(settings: Settings, parts: Parts | None) -> AsyncIterator[Parts]:
    async with (
        open_gateway(settings) if parts is None else nullcontext(parts) as opened,
        _serve_agents(opened) if settings.mcp else nullcontext(),
    ):
        yield opened


def create_app(settings: Settings, parts: Parts | None = None) -> FastAPI:
    """Create the application.

    Args:
        settings: The settings.
        parts: Those of an open gateway. Without them, the application joins the ROS graph at startup and leaves it at
            shutdown.
    """
    routers = (*api_routers(), *_agent_routers(settings))
    return build_app(settings, routers, lambda: _open(settings, parts), CONTENTS)
