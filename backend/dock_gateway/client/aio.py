"""The client for programs with asyncio."""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Generator, Mapping
from contextlib import aclosing
from typing import Any, Self, TypeVar, Unpack

import httpx2
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

from dock_gateway.client import calls
from dock_gateway.client.connection import Attempts, Connection, ReadPosition
from dock_gateway.client.documents import Battery, Document, Event, Goal, Robot, StopReport
from dock_gateway.client.errors import succeeded

T = TypeVar("T")


class AsyncClient:
    """A client of a gateway, to be used in an `async with` statement. What it can do is described at `Client`.

    Limit the time of anything with `asyncio.timeout`.
    """

    def __init__(
        self,
        url: str | None = None,
        *,
        token: str | None = None,
        certificate: str | None = None,
        timeout: float = 15.0,
        patience: float = 60.0,
    ) -> None:
        self.connection = Connection(url, token, certificate, timeout, patience)
        self._http = httpx2.AsyncClient(**self.connection.http_options)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()

    async def aclose(self) -> None:
        """Close the connections. Goals go on."""
        await self._http.aclose()

    async def dock(
        self, goal: Mapping[str, Any] | None = None, *, robot: str | None = None, key: str | None = None
    ) -> "AsyncGoalHandle":
        """Send a robot to its charging dock."""
        return AsyncGoalHandle(self, await self.call(calls.send("/dock", goal, robot, key)))

    async def undock(
        self, goal: Mapping[str, Any] | None = None, *, robot: str | None = None, key: str | None = None
    ) -> "AsyncGoalHandle":
        """Drive a robot off its charging dock."""
        return AsyncGoalHandle(self, await self.call(calls.send("/undock", goal, robot, key)))

    async def send(self, action: str, goal: Mapping[str, Any], *, key: str | None = None) -> "AsyncGoalHandle":
        """Send a goal to any action."""
        return AsyncGoalHandle(self, await self.call(calls.send(calls.goals_of(action), goal, None, key)))

    async def goal(self, goal_id: str) -> "AsyncGoalHandle":
        """Return a goal that was sent by any client."""
        return AsyncGoalHandle(self, await self.call(calls.goal(goal_id)))

    async def robots(self) -> list[Robot]:
        """Return all robots on the ROS graph, by name."""
        return await self.call(calls.robots())

    async def battery(self, robot: str | None = None) -> Battery:
        """Return the latest battery state of a robot."""
        return await self.call(calls.battery(robot))

    async def stop(self, *robots: str, latch: bool = True, by: str | None = None) -> StopReport:
        """Stop robots. It is sent once: after an error they may not have stopped."""
        return await self.call(calls.stop(robots, by, latch=latch))

    async def release(self, robot: str | None = None) -> None:
        """Release a stop."""
        await self.call(calls.release(robot))

    async def call_service(
        self, name: str, request: Mapping[str, Any] | None = None, *, timeout: float = 5
    ) -> Document:
        """Call a ROS service, and return its response. It is sent once."""
        return await self.call(calls.call_service(name, request, timeout))

    async def publish(self, topic: str, message: Mapping[str, Any], *, type_name: str | None = None) -> int:
        """Publish a message on a topic; return the number of its subscribers."""
        return await self.call(calls.publish(topic, message, type_name))

    async def parameters(self, node: str) -> Document:
        """Return the values of all parameters of a node, by name."""
        return await self.call(calls.parameters(node))

    async def set_parameters(self, node: str, values: Mapping[str, Any]) -> Document:
        """Set parameters of a node, all or none; return their values."""
        return await self.call(calls.set_parameters(node, values))

    def events(self, *, after: str | None = None, **query: Unpack[calls.EventQuery]) -> AsyncGenerator[Event]:
        """Yield events as they happen, first a snapshot; forever."""
        return self.read(ReadPosition(self.connection, query, after))

    async def request(
        self,
        method: str,
        path: str,
        body: object = None,
        *,
        params: calls.Params | None = None,
        wait: int = 0,
        if_match: str | None = None,
    ) -> Any:
        """Send any other request of docs/api.md and return the decoded answer."""
        return await self.call(calls.request(method, path, body, params, wait, if_match=if_match))

    async def call(self, call: calls.Call[T]) -> T:
        """Send a request. Repeat it if the connection was lost and that does no harm."""
        attempts = Attempts(self.connection, call)
        while True:
            try:
                response = await self._http.request(call.method, call.path, timeout=attempts.timeout, **call.options)
            except httpx2.TransportError as error:
                await asyncio.sleep(attempts.failed(error))
            else:
                return self.connection.read(response, call.read)

    async def read(self, reading: ReadPosition) -> AsyncGenerator[Event]:
        """Yield the events of a stream, over any number of connections."""
        while True:
            try:
                async with connect(reading.url, **reading.options) as stream:
                    while True:
                        if (event := reading.read(await stream.recv())) is not None:
                            yield event
            except (WebSocketException, OSError) as error:
                await asyncio.sleep(reading.lost(error))


class AsyncGoalHandle:
    """A goal at a gateway, as `GoalHandle`. Awaiting it gives what its `result` returns, iterating its feedback."""

    def __init__(self, client: AsyncClient, state: Goal) -> None:
        self.state = state
        self._client = client

    @property
    def id(self) -> str:
        """The goal's UUID."""
        return self.state.goal_id

    def __await__(self) -> Generator[Any, None, Goal]:
        return self.result().__await__()

    async def __aiter__(self) -> AsyncIterator[Document]:
        """Yield feedback messages from `state` on until the goal ends."""
        if not self.state.ended:
            async with aclosing(self.events(after=self.state.last_event_id)) as events:
                async for event in events:
                    if event.type == "feedback":
                        yield event.document["feedback"]
            await self.refresh()

    async def events(self, *, after: str | None = None, **query: Unpack[calls.GoalEventQuery]) -> AsyncGenerator[Event]:
        """Yield events until the goal ends, first a snapshot."""
        reading = ReadPosition(self._client.connection, {**query, "goal_id": self.id}, after)
        async with aclosing(self._client.read(reading)) as events:
            async for event in events:
                yield event
                if event.ends_goal or (reading.to_be_checked(event) and (await self.refresh()).ended):
                    return

    async def wait(self) -> Goal:
        """Wait until the goal ends, and return how."""
        if not self.state.ended:
            async with aclosing(self.events(feedback=False)) as events:
                async for _ in events:
                    pass
            await self.refresh()
        return self.state

    async def result(self) -> Goal:
        """Wait until the goal has succeeded, and return its state with the result.

        Raises:
            GoalFailed: It ended otherwise.
        """
        return succeeded(await self.wait())

    async def cancel(self) -> Goal:
        """Ask the action server to cancel the goal. `wait` returns when it has ended."""
        self.state = await self._client.call(calls.cancel(self.id))
        return self.state

    async def refresh(self) -> Goal:
        """Ask the gateway for the state."""
        self.state = await self._client.call(calls.goal(self.id))
        return self.state
