"""The two sides of a connection, readers that do not read, and the end of a goal's stream."""

import asyncio
import logging
from collections.abc import AsyncGenerator
from copy import copy
from types import SimpleNamespace
from typing import Any

import orjson
import pytest
from starlette.types import Message

from dock_gateway.access.logins import Logins
from dock_gateway.core.access import ANYBODY
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.goals.goal_machine import GoalMachine
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.liveness import ServerState
from dock_gateway.goals.registry import ActionRegistry, DockingServerStates
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.robots import Robots
from dock_gateway.robots.simulator import Simulators
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History
from dock_gateway.streams.current_state import CurrentState
from dock_gateway.streams.events import EventStream, _sse_chunks, until_one_ends
from dock_gateway.streams.gateway_state import GatewayState
from dock_gateway.streams.includes import Includes
from tests.support.history import HistoryInMemory
from tests.support.tracking import A, S, Scene, scene

__all__ = ["scene"]

SCOPE = {"type": "http", "asgi": {"spec_version": "2.3"}}


async def never() -> Any:
    await asyncio.Event().wait()


class Chunks:
    """An endless stream that knows whether it was closed."""

    def __init__(self) -> None:
        self.closed = False

    async def __call__(self) -> AsyncGenerator[bytes]:
        try:
            while True:
                await asyncio.sleep(0)
                yield b"data: 1\n\n"
        finally:
            self.closed = True


@pytest.mark.parametrize("spec_version", ["2.3", "2.4"])
async def test_a_reader_of_server_sent_events_that_does_not_read_is_cut_off(spec_version: str) -> None:
    chunks, sent = Chunks(), list[Message]()

    async def send(message: Message) -> None:
        if len(sent) == 5:
            await never()
        sent.append(message)

    generator = chunks()
    first = await anext(generator)
    scope = {"type": "http", "asgi": {"spec_version": spec_version}}
    async with asyncio.timeout(25):
        await EventStream(first, generator, 0.05)(scope, never, send)
    assert chunks.closed
    assert sent[1]["body"] == first


async def test_the_stream_is_closed_when_its_reader_leaves() -> None:
    chunks = Chunks()
    generator = chunks()
    first = await anext(generator)

    async def receive() -> Message:
        return {"type": "http.disconnect"}

    async def send(_: Message) -> None:
        await asyncio.sleep(0)

    async with asyncio.timeout(25):
        await EventStream(first, generator, 30)(SCOPE, receive, send)
    assert chunks.closed


async def test_other_errors_of_a_stream_are_not_hidden() -> None:
    async def chunks() -> AsyncGenerator[bytes]:
        yield b"1"
        raise ZeroDivisionError

    async def send(_: Message) -> None: ...

    generator = chunks()
    with pytest.raises(ZeroDivisionError):
        await EventStream(await anext(generator), generator, 30)(SCOPE, never, send)


async def test_when_one_side_ends_the_other_is_canceled() -> None:
    ended = []

    async def side() -> None:
        try:
            await never()
        finally:
            ended.append(1)

    async with asyncio.timeout(25):
        await until_one_ends(side(), asyncio.sleep(0.01), side())
    assert len(ended) == 2


async def test_both_sides_end_with_the_connection() -> None:
    ended = []

    async def side() -> None:
        try:
            await never()
        finally:
            ended.append(1)

    both = asyncio.create_task(until_one_ends(side(), side()))
    await asyncio.sleep(0.01)
    both.cancel()
    with pytest.raises(asyncio.CancelledError):
        await both
    assert len(ended) == 2


@pytest.mark.parametrize(("error", "logged"), [(TimeoutError(), 0), (ZeroDivisionError(), 1)])
async def test_a_side_that_breaks_is_logged(caplog: pytest.LogCaptureFixture, error: Exception, logged: int) -> None:
    async def side() -> None:
        raise error

    with caplog.at_level(logging.ERROR):
        await until_one_ends(side(), never())
    assert len(caplog.records) == logged


class OneGoal(Parts):
    """What a stream asks of the gateway; its goal ends while it is looked up for the `ends_at`th time."""

    def __init__(self, scene: Scene, ends_at: int) -> None:
        self._scene, self._ends_at, self._looks = scene, ends_at, 0
        self._goal = scene.send(A)
        scene.tracker.apply(GoalMachine.move, self._goal, S.EXECUTING)
        part = SimpleNamespace(document=dict)
        robot = SimpleNamespace(namespace="/", battery=part, publisher=part)
        self.logins = Logins(HistoryInMemory())
        server = ServerState("/dock", "pkg/action/Dock", available=True, answering=True)
        super().__init__(
            {
                Settings: Settings(heartbeat_interval=60.0),
                Fanout: scene.fanout,
                Includes: Includes(),
                History: scene.history,
                Quotas: Quotas(Settings()),
                Logins: self.logins,
                Goals: SimpleNamespace(get=self._get, recent=self._recent),
                ActionRegistry: SimpleNamespace(servers_of=lambda _: DockingServerStates(server, server)),
                RobotRegistry: SimpleNamespace(get=lambda _: robot),
                Robots: SimpleNamespace(find=lambda _: "/"),
                RobotActions: SimpleNamespace(homed_in=lambda _: frozenset()),
                Stopper: SimpleNamespace(state=lambda _: None),
                Simulators: SimpleNamespace(document=lambda _: None),
            }
        )
        self.add(CurrentState, GatewayState(self))

    async def _get(self, _: str, __: Grant = UNLIMITED) -> Goal:
        self._looks += 1
        found = copy(self._goal)
        if self._looks == self._ends_at:
            self.end()
            await asyncio.sleep(0.01)  # what was found in the history is old when it is there
        return found

    async def _recent(self, event_filter: EventFilter) -> list[Goal]:
        return [await self._get(event_filter.goal_id or "")]

    def end(self) -> None:
        self._scene.tracker.apply(GoalMachine.end, self._goal, S.SUCCEEDED, result=b'{"n":1}')


BEFORE, LATER = 0, 99


@pytest.mark.parametrize("resumes", [False, True])
@pytest.mark.parametrize("ends_at", [BEFORE, 1, 2, 3, LATER])
async def test_a_goals_stream_ends_with_the_goal_whenever_that_is(scene: Scene, ends_at: int, resumes: bool) -> None:
    parts = OneGoal(scene, ends_at)
    executing = (await scene.subscriber.take(1))[0][-1].id
    if ends_at == BEFORE:
        parts.end()
        await asyncio.sleep(0.01)
    told = []
    async with asyncio.timeout(25):
        async for chunk in _sse_chunks(parts, ANYBODY, {"goal_id": A}, executing if resumes else None, None):
            told.append(orjson.loads(chunk.partition(b"data: ")[2]))
            parts.end()  # at the latest
    last = told[-1] if told[-1]["type"] == "result" else told[-1]["goals"][0]
    assert (last["status"], last["result"]) == ("succeeded", {"n": 1})
    assert len(scene.fanout) == 1  # the scene's own


async def test_who_has_had_the_end_of_a_goal_gets_nothing_more(scene: Scene) -> None:
    parts = OneGoal(scene, BEFORE)
    parts.end()
    await asyncio.sleep(0.01)
    end = (await scene.subscriber.take(1))[0][-1].id
    async with asyncio.timeout(25):
        told = [chunk async for chunk in _sse_chunks(parts, ANYBODY, {"goal_id": A}, end, None)]
    assert [orjson.loads(chunk.partition(b"data: ")[2])["type"] for chunk in told] == ["resumed"]


@pytest.mark.parametrize("resumes", [False, True])
async def test_a_reader_whose_login_ends_gets_none_of_what_was_already_there(scene: Scene, resumes: bool) -> None:
    """However slowly it reads: missed events, and those that wait in its queue."""
    parts = OneGoal(scene, LATER)
    executing = (await scene.subscriber.take(1))[0][-1].id
    token, secret = await parts.logins.create_token("cron", Grant(Role.VIEWER))
    principal = parts.logins.identify(secret)
    if resumes:
        for number in range(50):
            scene.feedback(number)
    chunks = _sse_chunks(parts, principal, {"goal_id": A}, executing if resumes else None, None)
    told = [await anext(chunks)]
    if not resumes:
        for number in range(50):
            scene.feedback(number)
    told.append(await anext(chunks))
    await parts.logins.revoke_token(token["id"])
    async with asyncio.timeout(25):
        told += [chunk async for chunk in chunks]
    types = [orjson.loads(chunk.partition(b"data: ")[2])["type"] for chunk in told]
    assert types == ["resumed" if resumes else "snapshot", "feedback", "closing"]
    assert b"invalid_token" in told[-1]
