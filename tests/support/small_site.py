"""A small site: it says hello to a hub and serves it with any app, without a gateway."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from uuid import UUID

import orjson
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from dock_gateway import __version__
from dock_gateway.core.errors import Unavailable
from dock_gateway.sites import subjects
from dock_gateway.sites.broker import Broker, BrokerOptions, open_broker
from dock_gateway.sites.identity import Signer, Verifier
from dock_gateway.sites.messages import Hello, Refusal, Welcome, read_answer
from dock_gateway.sites.tunnel.caller import TunnelAddress
from dock_gateway.sites.tunnel.channel import Timing
from dock_gateway.sites.tunnel.server import TunnelServer
from tests.support.waiting import until

ROBOT: dict[str, Any] = {
    "name": "/robot1",
    "display_name": "Left",
    "groups": ["hall"],
    "default": True,
    "docked": None,
    "charging": False,
    "simulated": True,
    "battery": {"percentage": 0.5},
    "battery_topic": "/robot1/battery_status",
    "battery_publisher": {"active": False, "rate_hz": None},
    "stop": {"latched": True, "stopped_at": None, "by": "Ada", "robots": ["/robot1"], "persisted": True},
    "dock": {
        "action_name": "/robot1/dock",
        "action_type": "t",
        "available": True,
        "answering": True,
        "duplicate": False,
    },
    "undock": None,
    "join": {"detail": "see /robot2", "settings": []},
    "goals": [],
    "last_goal": None,
}

ALERT = {
    "id": "0123456789abcdef",
    "etag": '"1"',
    "kind": "low_battery",
    "robot": "/robot1",
    "severity": "warning",
    "started_at": "2026-11-27T12:00:00Z",
    "title": "Low battery",
    "detail": "Send the robot to its dock.",
    "goal_id": None,
    "acknowledged": None,
}


async def say_hello(
    broker: Broker, site: str, instance: str, installation: int = 1, *, leaving: bool = False
) -> Welcome | Refusal:
    """Say hello once, as soon as the hub is there."""
    hello = Hello(
        installation=UUID(int=installation), instance=instance, version=__version__, at=time.time(), leaving=leaving
    )
    while True:
        with suppress(Unavailable, TimeoutError):
            return read_answer(await broker.request(subjects.hello(site), hello.encode(), 5))
        await asyncio.sleep(0.05)


@asynccontextmanager
async def broker_of(nats: str, site: str) -> AsyncIterator[Broker]:
    """The connection of a site."""
    options = BrokerOptions((nats,), None, None, site, subjects.inbox(site))
    async with open_broker(options) as broker:
        await until(lambda: broker.connected)
        yield broker


@asynccontextmanager
async def small_site(
    nats: str, signer: Signer, folder: Path, name: str = "berlin", timing: Timing | None = None
) -> AsyncIterator[str]:
    """Serve the hub; the value is the process's id."""
    keys = folder / f"{name}.keys"
    keys.write_bytes(orjson.dumps(signer.public_keys()))
    instance, verifier = subjects.new_id(), Verifier(keys, name)
    async with broker_of(nats, name) as broker:
        assert isinstance(await say_hello(broker, name, instance), Welcome)
        server = TunnelServer(
            broker,
            TunnelAddress(name, instance),
            APP,
            lambda token, method, path, content: verifier.verify(token, instance, method, path, time.time(), content),
            {},
            timing=timing,
        )
        await server.open()
        try:
            yield instance
        finally:
            await say_hello(broker, name, instance, leaving=True)
            await server.close()


async def _echo(request: Request) -> Response:
    who = request.scope["forwarded"]
    return JSONResponse(
        {
            "headers": dict(request.headers),
            "query": request.url.query,
            "body": (await request.body()).decode(),
            "name": who.name,
            "role": who.grant.role,
            "robots": who.grant.robots,
        }
    )


async def _elsewhere(_: Request) -> Response:
    return Response(status_code=202, headers={"Location": "/echo", "Set-Cookie": "dock-gateway=stolen"})


async def _acknowledge(request: Request) -> Response:
    by = f"{request.scope['forwarded'].name}, as {(await request.json())['by']}"
    return JSONResponse(ALERT | {"acknowledged": {"by": by, "acknowledged_at": ALERT["started_at"]}})


async def _never(_: Request) -> Response:
    await asyncio.Event().wait()
    return Response()


async def _stop(request: Request) -> Response:
    who = request.scope["forwarded"]
    return JSONResponse({"stopped": [], "name": who.name, "seen": who.grant.covers_robot("/robot1")})


async def _slow(request: Request) -> Response:
    """Answer after some seconds, as a goal that waits for a person."""
    await asyncio.sleep(float(request.query_params["seconds"]))
    return JSONResponse({"waited": True})


async def _goals(_: Request) -> Response:
    return JSONResponse({"goals": [], "next_cursor": None})


async def _feedback(websocket: WebSocket) -> None:
    """A stream of a site with one robot; what comes is sent back."""
    await websocket.accept()
    now = datetime.now(UTC).isoformat()
    more: dict[str, list[Any]] = {"goals": [], "alerts": [ALERT], "approvals": []}
    await websocket.send_json({"type": "snapshot", "time": now, "robots": [ROBOT], **more})
    with suppress(WebSocketDisconnect):
        while True:
            await websocket.send_text(await websocket.receive_text())


APP = Starlette(
    routes=[
        Route("/echo", _echo, methods=["GET", "POST"]),
        Route("/elsewhere", _elsewhere, methods=["POST"]),
        Route(f"/alerts/{ALERT['id']}/acknowledgement", _acknowledge, methods=["PUT"]),
        Route("/never", _never, methods=["POST"]),
        Route("/stop", _stop, methods=["POST"]),
        Route("/slow", _slow, methods=["GET", "POST"]),
        Route("/goals", _goals),
        Route("/healthz", _echo),
        Route("/alerts/{id}/acknowledgement", _echo, methods=["DELETE"]),
        WebSocketRoute("/ws", _feedback),
        WebSocketRoute("/ws/feedback", _feedback),
        WebSocketRoute("/a_new_door", _feedback),
    ]
)
