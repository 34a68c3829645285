"""`/ws/feedback`: connect and read, one JSON text message an event."""

import asyncio
import logging
import time

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect

from dock_gateway.api.answers import TheGateway
from dock_gateway.api.interests import QUERY, read_interest
from dock_gateway.api.problems import problem_response
from dock_gateway.api.requests import known_query
from dock_gateway.errors import GatewayError
from dock_gateway.events import notice, utc_now
from dock_gateway.gateway import Gateway
from dock_gateway.hub import Subscriber

log = logging.getLogger(__name__)

router = APIRouter()

POLICY_VIOLATION, SERVICE_RESTART, TRY_AGAIN_LATER = 1008, 1012, 1013


@router.websocket("/ws/feedback")
async def feedback(websocket: WebSocket, gateway: TheGateway) -> None:
    """A snapshot, then every event as it happens.

    `?goal_id=`, `?action=` and `?robot=` narrow it; `?include=battery,cmd_vel,system` asks for more than goals.
    """
    try:
        known_query(*QUERY)(websocket)
        subscriber = gateway.hub.subscribe(await read_interest(gateway, websocket.query_params))
    except GatewayError as error:
        await websocket.send_denial_response(problem_response(error))
        return
    try:
        await websocket.accept()
        await _serve(websocket, gateway, subscriber)
    finally:
        gateway.hub.unsubscribe(subscriber)


async def _serve(websocket: WebSocket, gateway: Gateway, subscriber: Subscriber) -> None:
    """Write until the reader leaves, does not read, or the gateway closes; its input is ignored."""
    writer = asyncio.create_task(_write(websocket, gateway, subscriber))
    reader = asyncio.create_task(_ignore_input(websocket))
    done, pending = await asyncio.wait((writer, reader), return_when=asyncio.FIRST_COMPLETED)
    for task in pending:
        task.cancel()
    await asyncio.gather(*pending, return_exceptions=True)
    for task in done:
        error = task.exception()
        if error is not None and not isinstance(error, WebSocketDisconnect | TimeoutError):
            log.error("a stream broke", exc_info=error)


async def _ignore_input(websocket: WebSocket) -> None:
    while (await websocket.receive())["type"] != "websocket.disconnect":
        pass


async def _write(websocket: WebSocket, gateway: Gateway, subscriber: Subscriber) -> None:
    interval = gateway.settings.heartbeat_interval
    subscriber.clear()  # all that happened up to now is in the snapshot
    await _send(websocket, gateway, await _snapshot(gateway, subscriber))
    next_heartbeat = time.monotonic() + interval
    while not (gateway.hub.closing or subscriber.overrun):
        events, dropped = await subscriber.take(max(0.0, next_heartbeat - time.monotonic()))
        if dropped:
            await _send(websocket, gateway, notice("dropped", utc_now(), count=dropped))
        for event in events:
            await _send(websocket, gateway, event.text)
        if time.monotonic() >= next_heartbeat:
            await _send(websocket, gateway, notice("heartbeat", utc_now()))
            next_heartbeat = time.monotonic() + interval
    reason, code = ("too_slow", TRY_AGAIN_LATER) if subscriber.overrun else ("shutting_down", SERVICE_RESTART)
    await _send(websocket, gateway, notice("closing", utc_now(), reason=reason))
    await websocket.close(code, reason)


async def _send(websocket: WebSocket, gateway: Gateway, text: str) -> None:
    """Send a message; a client that does not read for so long is cut off."""
    try:
        async with asyncio.timeout(gateway.settings.subscriber_timeout):
            await websocket.send({"type": "websocket.send", "text": text})
    except TimeoutError:
        log.info("a subscriber did not read for %g s and is cut off", gateway.settings.subscriber_timeout)
        raise


async def _snapshot(gateway: Gateway, subscriber: Subscriber) -> str:
    interest = subscriber.interest
    goals = await gateway.recent_goals(interest)
    robot = gateway.robots.get(interest.robot)
    return notice(
        "snapshot",
        utc_now(),
        goals=[goal.document() for goal in goals],
        battery=robot.battery.document(),
        battery_publisher=robot.publisher.document(),
        action_server=gateway.dock.watch.state,
    )
