"""Read-only streams: `/ws/feedback` with one JSON text message per event, and Server-Sent Events."""

import asyncio
import logging
from collections.abc import AsyncGenerator, AsyncIterator, Coroutine
from typing import Any

from fastapi import APIRouter, Depends, WebSocket
from starlette.responses import Response, StreamingResponse
from starlette.websockets import WebSocketDisconnect

from dock_gateway.access.authorization import subscribed
from dock_gateway.core.access import Principal
from dock_gateway.core.event import Event
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.grant import Role
from dock_gateway.core.tasks import cancel
from dock_gateway.goals.goal_path import at_goal
from dock_gateway.goals.goals import Goals
from dock_gateway.http.edge.websocket import frame_writer
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import AllParts, Parts
from dock_gateway.http.principal import TICKET, ThePrincipal, principal_of
from dock_gateway.http.requests import GoalId
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.slow_clients import PacedResponse, send_in_time
from dock_gateway.http.unexpected import known_query
from dock_gateway.settings import Settings
from dock_gateway.streams.feed import begin, end_of, feed, follow, has_seen_end
from dock_gateway.streams.queries import (
    STREAM_QUERY,
    LastEventId,
    StreamQuery,
    read_after,
    read_event_filter,
    read_max_rate,
)

log = logging.getLogger(__name__)

router = APIRouter(route_class=ApiRoute, tags=["Events"])

CLOSE_CODES = {"shutting_down": 1012, "too_slow": 1013, "invalid_token": 4401}
SSE: dict[int | str, dict[str, Any]] = {
    200: {"description": "Events, each with its id", "content": {"text/event-stream": {}}},
    204: {"description": "The reader has seen the last event: an `EventSource` does not connect again"},
}


@router.websocket("/ws/feedback", dependencies=[Depends(known_query(*STREAM_QUERY, "after", "max_rate", TICKET))])
@operation(Role.VIEWER, Scope.LISTED)
async def feedback(websocket: WebSocket, parts: AllParts) -> None:
    """Send a snapshot, then every event as it happens.

    `?goal_id=`, `?action=` and `?robot=` filter the events; `?include=` asks for more than goals, by
    the types of events or by `system` and `fleet`, with commas or repeated; `?feedback=false` omits feedback,
    `?max_rate=` limits its rate; `?after=` resumes.
    """
    asked = websocket.query_params
    query = {**asked, "include": ",".join(asked.getlist("include"))}
    after, max_rate = read_after(query), read_max_rate(query)
    principal = principal_of(websocket)
    with subscribed(parts, principal, await read_event_filter(parts, query, principal.grant)) as subscriber:
        await websocket.accept()
        if max_rate is None:
            subscriber.writer = frame_writer(websocket)
        events = feed(parts, subscriber, after=after, max_rate=max_rate)
        await until_one_ends(write_events(websocket, parts, subscriber, events), ignore_input(websocket))


async def until_one_ends(*sides: Coroutine[Any, Any, None]) -> None:
    """Run the coroutines of a WebSocket, such as its reader and its writer, until the first of them ends."""
    tasks = [asyncio.create_task(side) for side in sides]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        await cancel(*tasks)
    for task in done:
        error = task.exception()
        if error is not None and not isinstance(error, WebSocketDisconnect | TimeoutError):
            log.error("a WebSocket broke", exc_info=error)


async def ignore_input(websocket: WebSocket) -> None:
    """Read and discard a client's messages until it disconnects."""
    while (await websocket.receive())["type"] != "websocket.disconnect":
        pass


async def write_events(
    websocket: WebSocket, parts: Parts, subscriber: Subscriber, events: AsyncIterator[Event]
) -> None:
    """Send a reader's events until they end, then close with the reason."""
    async for event in events:
        await send_text(websocket, parts, event.text)
    reason = end_of(subscriber)
    await websocket.close(CLOSE_CODES[reason], reason)


async def send_text(websocket: WebSocket, parts: Parts, text: str) -> None:
    """Send a message. Cut off a client that does not read for `subscriber_timeout` seconds.

    Raises:
        TimeoutError: The client did not read in time.
    """
    await send_in_time(websocket.send, {"type": "websocket.send", "text": text}, parts[Settings].subscriber_timeout)


class EventStream(PacedResponse):
    """Server-Sent Events."""

    def __init__(self, first: bytes, chunks: AsyncGenerator[bytes], timeout: float) -> None:
        super().__init__(first, chunks, timeout, media_type="text/event-stream", headers={"X-Accel-Buffering": "no"})


@at_goal(router, "GET", "/events", responses=SSE, response_class=StreamingResponse)
@operation(Role.VIEWER, Scope.GOAL, errors=(429,))
async def goal_events(
    goal_id: GoalId, parts: AllParts, principal: ThePrincipal, query: StreamQuery, last: LastEventId
) -> Response:
    """Stream the events of a goal as Server-Sent Events until it ends. `Last-Event-ID` resumes."""
    after, max_rate = read_after(query) if last is None else last, read_max_rate(query)
    goal = await parts[Goals].get(goal_id, principal.grant)
    if last is not None and has_seen_end(parts, goal, last):
        return Response(status_code=204)
    chunks = _sse_chunks(parts, principal, {**query, "goal_id": goal_id}, after, max_rate)
    first = await anext(chunks)  # errors are raised before the stream begins
    return EventStream(first, chunks, parts[Settings].subscriber_timeout)


async def _sse_chunks(
    parts: Parts, principal: Principal, query: dict[str, str], after: str | None, max_rate: float | None
) -> AsyncGenerator[bytes]:
    with subscribed(parts, principal, await read_event_filter(parts, query, principal.grant)) as subscriber:
        # The events that the client is sent show whether the goal has ended. It could end during a separate lookup.
        ended = False
        newest = parts[Fanout].newest
        async for event in begin(parts, subscriber, after):
            yield event.sse
            ended = event.ends_goal
        if ended:
            return
        async for event in follow(parts, subscriber, max_rate, newest):
            yield event.sse
            if event.ends_goal:
                return
