"""The part of a gateway's API that a hub uses, for a simulated site: documents and streams as those of a real one."""

import asyncio
import bisect
import contextlib
import time
from collections.abc import AsyncIterator
from typing import Any

import orjson
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from dock_gateway.core.event import Event, notice, stamp_of, stop_event
from dock_gateway.core.fanout import Subscriber
from dock_gateway.core.filters import EventFilter, WithoutFeedback
from dock_gateway.core.goal import Goal, encode
from dock_gateway.streams.includes import Includes
from tests.support.site_simulation import SimulatedSite

HEARTBEAT = 5.0


def _json(document: Any, status: int = 200) -> Response:
    return Response(encode(document), status, media_type="application/json")


def _problem(status: int, code: str, detail: str) -> Response:
    document = {"type": "about:blank", "title": code, "status": status, "code": code, "detail": detail}
    return Response(encode(document), status, media_type="application/problem+json")


class SiteApi:
    """The ASGI app of a site, `app`."""

    def __init__(self, site: SimulatedSite) -> None:
        self._site = site
        routes = [
            *(Route(path, self._plain) for path in ("/healthz", "/readyz", "/robots", "/alerts", "/approvals")),
            Route("/session", self._session),
            Route("/goals", self._goals),
            Route("/goals/{goal_id}", self._goal),
            Route("/dock", self._dock, methods=["POST"]),
            Route("/stop", self._stop, methods=["GET", "POST", "DELETE"]),
        ]
        self.app = Starlette(routes=[*routes, WebSocketRoute("/ws/feedback", self._feedback)])

    async def _plain(self, request: Request) -> Response:
        documents: dict[str, Any] = {
            "/healthz": {"status": "ok"},
            "/readyz": {"ready": True},
            "/alerts": {"alerts": []},
            "/approvals": {"approvals": []},
        }
        path = request.url.path
        return _json(documents[path] if path in documents else {"robots": self._site.robots()})

    async def _session(self, request: Request) -> Response:
        principal = request.scope.get("forwarded")
        return _json({"authentication": False, "hub": False, "name": getattr(principal, "name", None)})

    # ----------------------------------------------------------------- goals

    async def _goals(self, request: Request) -> Response:
        query = request.query_params
        limit, cursor, since = int(query.get("limit", "50")), query.get("cursor"), query.get("since")
        newest = sorted(self._site.goals.values(), key=lambda goal: (goal.created_at, goal.goal_id), reverse=True)
        if since is not None:
            newest = [goal for goal in newest if encode(goal.created_at)[1:-1].decode() >= since]
        if cursor is not None:
            place = next((index for index, goal in enumerate(newest) if goal.goal_id == cursor), len(newest))
            newest = newest[place + 1 :]
        page = newest[:limit]
        following = page[-1].goal_id if len(newest) > limit else None
        return _json({"goals": [_tagged(goal) for goal in page], "next_cursor": following})

    async def _goal(self, request: Request) -> Response:
        goal = self._site.goals.get(request.path_params["goal_id"])
        return _problem(404, "goal_not_found", "there is no such goal") if goal is None else _json(_tagged(goal))

    async def _dock(self, request: Request) -> Response:
        """Besides what a gateway takes: `seconds`, how long the goal runs, and `number`, which is noted."""
        body = orjson.loads(await request.body() or b"{}")
        robot = request.query_params.get("robot", "/robot1")
        if self._site.stop_state(robot)["latched"]:
            return _problem(409, "stop_latched", "a stop holds")
        key = request.headers.get("idempotency-key")
        goal = self._site.send(robot, body.get("seconds", 0.2), body.get("number"), key)
        return _json(goal.document(), 202)

    # ----------------------------------------------------------------- stops

    async def _stop(self, request: Request) -> Response:
        robots = request.query_params.getlist("robot")
        if request.method == "GET":
            return _json(self._site.latched_stops(robots[0] if robots else "/"))
        if request.method == "DELETE":
            return _json(self._site.release(robots[0] if robots else "/"))
        body = orjson.loads(await request.body() or b"{}")
        return _json(self._site.stop(robots, body.get("by")))

    # --------------------------------------------------------------- streams

    async def _feedback(self, websocket: WebSocket) -> None:
        query = websocket.query_params
        kind = EventFilter if query.get("feedback", "true") == "true" else WithoutFeedback
        event_filter = kind(topics=Includes().read(query.get("include", "")) | {"goals"})
        await websocket.accept()
        subscriber = self._site.fanout.subscribe(event_filter)
        writing = asyncio.create_task(self._write(websocket, subscriber, query.get("after")))
        try:
            while (await websocket.receive())["type"] != "websocket.disconnect":
                pass
        finally:
            writing.cancel()
            await asyncio.gather(writing, return_exceptions=True)
            self._site.fanout.unsubscribe(subscriber)

    async def _write(self, websocket: WebSocket, subscriber: Subscriber, after: str | None) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            async for event in self._events(subscriber, after):
                await websocket.send_text(event.text)

    async def _events(self, subscriber: Subscriber, after: str | None) -> AsyncIterator[Event]:
        for event in self._first(subscriber, after):
            yield event
        next_heartbeat = time.monotonic() + HEARTBEAT
        while True:
            events, _ = await subscriber.take(max(0.0, next_heartbeat - time.monotonic()))
            for event in events:
                yield event
            if time.monotonic() >= next_heartbeat:
                next_heartbeat = time.monotonic() + HEARTBEAT
                yield notice("heartbeat", self._site.now())

    def _first(self, subscriber: Subscriber, after: str | None) -> list[Event]:
        site, now = self._site, self._site.now()
        topics = subscriber.event_filter.topics
        fleet: dict[str, Any] = {"robots": site.robots(), "alerts": [], "approvals": []} if "robots" in topics else {}
        if after is None or stamp_of(after) > time.time() * 1e9 + 5e9:
            newest = sorted(site.goals.values(), key=lambda goal: goal.created_at, reverse=True)
            shown = [goal for index, goal in enumerate(newest) if index < 20 or not goal.status.terminal]
            first = notice(
                "snapshot", now, goals=[goal.document() for goal in shown], stop=site.stop_state("/"), **fleet
            )
            return [first] if after is None else [notice("gap", now, after=after, count=0), first]
        place = bisect.bisect_right(site.events, after, key=lambda event: event.id or "")
        missed = site.events[place:]
        present = [stop_event(site.stop_state("/"), None, robot="/")] if "stop" in topics else []
        state = [
            notice(kind, now, **{kind: value}, **({"gone": []} if kind == "robots" else {}))
            for kind, value in fleet.items()
        ]
        return [notice("resumed", now, after=after, count=len(missed)), *missed, *present, *state]


def _tagged(goal: Goal) -> dict[str, Any]:
    return {**goal.document(), "tags": []}
