"""The client for programs without asyncio."""

import time
from collections.abc import Iterator, Mapping
from typing import Any, Self, TypeVar, Unpack

import httpx2
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from dock_gateway.client import calls
from dock_gateway.client.connection import Attempts, Connection, ReadPosition
from dock_gateway.client.documents import Battery, Document, Event, Goal, Robot, StopReport
from dock_gateway.client.errors import succeeded

T = TypeVar("T")


class Client:
    """A client of a gateway. Close it, or use it in a `with` statement. Threads may share it.

    Every method raises `GatewayRefused` if the gateway refuses, `ClientTimeout` if it does not answer in time, and
    `GatewayUnreachable` if there is none. If the connection is lost, what can be repeated without harm is repeated
    until the client's patience ends.

    Args:
        url: Base URL of the gateway; by default that in DOCK_GATEWAY_URL, else http://127.0.0.1:8000.
        token: The token of a login; by default that in DOCK_GATEWAY_TOKEN, if any.
        certificate: A file with a client certificate and its key; by default that in DOCK_GATEWAY_CLIENT_CERT, if any.
        timeout: Seconds that an answer may take, in addition to the time that the gateway was asked to wait.
        patience: Seconds without the gateway after which a lost connection is given up.

    Raises:
        ClientError: The address or the certificate is wrong.
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
        self._http = httpx2.Client(**self.connection.http_options)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections. Goals go on."""
        self._http.close()

    def dock(
        self, goal: Mapping[str, Any] | None = None, *, robot: str | None = None, key: str | None = None
    ) -> "GoalHandle":
        """Send a robot to its charging dock.

        Args:
            goal: Fields of the goal, such as `{"dock_id": "lab"}`; by default CHARGING at the default dock.
            robot: Namespace, such as /robot1; by default the robot in the gateway's settings.
            key: A goal that was sent with the same key is returned instead; by default a new one.
        """
        return GoalHandle(self, self.call(calls.send("/dock", goal, robot, key)))

    def undock(
        self, goal: Mapping[str, Any] | None = None, *, robot: str | None = None, key: str | None = None
    ) -> "GoalHandle":
        """Drive a robot off its charging dock. The arguments are those of `dock`."""
        return GoalHandle(self, self.call(calls.send("/undock", goal, robot, key)))

    def send(self, action: str, goal: Mapping[str, Any], *, key: str | None = None) -> "GoalHandle":
        """Send a goal to any action, such as /fibonacci. `goal` has fields of its goal message."""
        return GoalHandle(self, self.call(calls.send(calls.goals_of(action), goal, None, key)))

    def goal(self, goal_id: str) -> "GoalHandle":
        """Return a goal that was sent by any client."""
        return GoalHandle(self, self.call(calls.goal(goal_id)))

    def robots(self) -> list[Robot]:
        """Return all robots on the ROS graph, by name."""
        return self.call(calls.robots())

    def battery(self, robot: str | None = None) -> Battery:
        """Return the latest battery state of a robot."""
        return self.call(calls.battery(robot))

    def stop(self, *robots: str, latch: bool = True, by: str | None = None) -> StopReport:
        """Stop robots, by default all: zero velocity, every goal is canceled.

        It is sent once: after an error the robots may not have stopped.

        Args:
            robots: Namespaces.
            latch: Whether new goals are refused until `release`.
            by: Who stops, shown to others.
        """
        return self.call(calls.stop(robots, by, latch=latch))

    def release(self, robot: str | None = None) -> None:
        """Release a stop: new goals are accepted again."""
        self.call(calls.release(robot))

    def call_service(self, name: str, request: Mapping[str, Any] | None = None, *, timeout: float = 5) -> Document:
        """Call a ROS service that the gateway's settings allow, and return its response.

        It is sent once: after an error the service may have been called.

        Args:
            name: Name on the ROS graph, such as /robot1/reset.
            request: Fields of the request; those that are left out have their default.
            timeout: Seconds to wait for the response.
        """
        return self.call(calls.call_service(name, request, timeout))

    def publish(self, topic: str, message: Mapping[str, Any], *, type_name: str | None = None) -> int:
        """Publish a message on a topic that the gateway's settings allow; return the number of its subscribers.

        Args:
            topic: Name on the ROS graph.
            message: Fields of the message; those that are left out have their default.
            type_name: Such as std_msgs/msg/String; needed only where no one is at the topic.
        """
        return self.call(calls.publish(topic, message, type_name))

    def parameters(self, node: str) -> Document:
        """Return the values of all parameters of a node, by name."""
        return self.call(calls.parameters(node))

    def set_parameters(self, node: str, values: Mapping[str, Any]) -> Document:
        """Set parameters of a node, all or none, if the gateway's settings allow it; return their values."""
        return self.call(calls.set_parameters(node, values))

    def events(self, *, after: str | None = None, **query: Unpack[calls.EventQuery]) -> Iterator[Event]:
        """Yield events as they happen, first a snapshot; forever. A lost connection resumes without a gap.

        Args:
            after: Id of the last event that is known. The events since then come first, instead of a snapshot.
            query: Selects events, as docs/streams.md says.
        """
        return self.read(ReadPosition(self.connection, query, after))

    def request(
        self,
        method: str,
        path: str,
        body: object = None,
        *,
        params: calls.Params | None = None,
        wait: int = 0,
        if_match: str | None = None,
    ) -> Any:
        """Send any other request of docs/api.md and return the decoded answer.

        Args:
            method: The HTTP method.
            path: The path, such as `/statistics`.
            body: The body, if there is one.
            params: The query.
            wait: Seconds that the gateway may wait before it answers, such as for the end of a goal (`Prefer: wait=…`).
            if_match: The `etag` of what is changed: a change that somebody else has made meanwhile is not lost.
        """
        return self.call(calls.request(method, path, body, params, wait, if_match=if_match))

    def call(self, call: calls.Call[T], deadline: float | None = None) -> T:
        """Send a request. Repeat it if the connection was lost and that does no harm, until the deadline."""
        attempts = Attempts(self.connection, call, deadline)
        while True:
            try:
                response = self._http.request(call.method, call.path, timeout=attempts.timeout, **call.options)
            except httpx2.TransportError as error:
                time.sleep(attempts.failed(error))
            else:
                return self.connection.read(response, call.read)

    def read(self, reading: ReadPosition) -> Iterator[Event]:
        """Yield the events of a stream, over any number of connections.

        Raises:
            ClientTimeout: Its deadline has passed.
        """
        while True:
            try:
                with connect(reading.url, **reading.options) as stream:
                    while True:
                        if (event := reading.read(stream.recv(reading.left))) is not None:
                            yield event
            except (WebSocketException, OSError) as error:
                time.sleep(reading.lost(error))


class GoalHandle:
    """A goal at a gateway. It goes on if the client ends. Iterating yields its feedback until it ends.

    Attributes:
        state: As the gateway last answered; `refresh` asks again.
    """

    def __init__(self, client: Client, state: Goal) -> None:
        self.state = state
        self._client = client

    @property
    def id(self) -> str:
        """The goal's UUID."""
        return self.state.goal_id

    def __iter__(self) -> Iterator[Document]:
        """Yield feedback messages from `state` on until the goal ends."""
        if not self.state.ended:
            for event in self.events(after=self.state.last_event_id):
                if event.type == "feedback":
                    yield event.document["feedback"]
            self.refresh()

    def events(
        self, *, after: str | None = None, timeout: float | None = None, **query: Unpack[calls.GoalEventQuery]
    ) -> Iterator[Event]:
        """Yield events until the goal ends, first a snapshot. The arguments are those of `Client.events`.

        Raises:
            ClientTimeout: It did not end within `timeout` seconds.
        """
        return self._events(after, query, _deadline(timeout))

    def _events(self, after: str | None, query: calls.GoalEventQuery, deadline: float | None) -> Iterator[Event]:
        reading = ReadPosition(self._client.connection, {**query, "goal_id": self.id}, after, deadline)
        for event in self._client.read(reading):
            yield event
            if event.ends_goal or (reading.to_be_checked(event) and self._refresh(deadline).ended):
                return

    def wait(self, timeout: float | None = None) -> Goal:
        """Wait until the goal ends, and return how.

        Raises:
            ClientTimeout: It did not end within `timeout` seconds.
        """
        deadline = _deadline(timeout)
        if not self.state.ended:
            for _ in self._events(None, {"feedback": False}, deadline):
                pass
            self._refresh(deadline)
        return self.state

    def result(self, timeout: float | None = None) -> Goal:
        """Wait until the goal has succeeded, and return its state with the result.

        Raises:
            GoalFailed: It ended otherwise.
            ClientTimeout: It did not end within `timeout` seconds.
        """
        return succeeded(self.wait(timeout))

    def cancel(self) -> Goal:
        """Ask the action server to cancel the goal. `wait` returns when it has ended."""
        self.state = self._client.call(calls.cancel(self.id))
        return self.state

    def refresh(self) -> Goal:
        """Ask the gateway for the state."""
        return self._refresh(None)

    def _refresh(self, deadline: float | None) -> Goal:
        self.state = self._client.call(calls.goal(self.id), deadline)
        return self.state


def _deadline(timeout: float | None) -> float | None:
    return None if timeout is None else time.monotonic() + timeout
