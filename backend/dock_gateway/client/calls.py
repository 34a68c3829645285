"""The requests of both clients."""

import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypedDict, TypeVar
from urllib.parse import quote

import orjson

from dock_gateway.client.documents import Battery, Document, Goal, Robot, StopReport

T = TypeVar("T")
# Seconds that an agent's goal waits for a person, and that a slow node may take to show its parameters, or to set them.
APPROVAL, PARAMETERS, SET_PARAMETERS = 60.0, 15.0, 25.0
Params = Mapping[str, str | int | float | bool | list[str]]


class GoalEventQuery(TypedDict, total=False):
    """What a stream of one goal has besides the goal's events, as docs/streams.md says.

    Attributes:
        robot: The robot that included events are about; by default the one that the gateway is configured for.
        include: Types of further events, such as `["battery", "stop"]`.
        feedback: Whether there is feedback, which is the default.
        max_rate: The most events of feedback, battery, velocity and scene in a second, each.
    """

    robot: str | None
    include: Sequence[str]
    feedback: bool
    max_rate: float | None


class EventQuery(GoalEventQuery, total=False):
    """Selects events: those of one goal, of one action or of the actions of one robot; by default those of all."""

    goal_id: str | None
    action: str | None


@dataclass(frozen=True)
class Call(Generic[T]):
    """A request, and how its answer is read.

    Attributes:
        repeatable: Whether it may be sent again if the connection was lost before the answer came.
        wait: Seconds that the gateway may wait before it answers, as it was asked to or until it gives up.
        rejoins: Seconds that an answer may take in addition, where a repeated request goes on with the first one.
    """

    method: str
    path: str
    read: Callable[[Any], T]
    body: object = None
    params: Params = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    repeatable: bool = False
    wait: float = 0.0
    rejoins: float = 0.0

    @property
    def options(self) -> dict[str, Any]:
        """Arguments of an HTTP client's request."""
        if self.body is None:
            return {"params": self.params, "headers": self.headers}
        headers = {"Content-Type": "application/json", **self.headers}
        return {"content": orjson.dumps(self.body), "params": self.params, "headers": headers}


def send(path: str, goal: Mapping[str, Any] | None, robot: str | None, key: str | None) -> Call[Goal]:
    """Send a goal. The key makes sure that it is sent once, however often the request is repeated."""
    headers = {"Idempotency-Key": key or str(uuid.uuid4())}
    return Call("POST", path, Goal.read, goal, _of(robot), headers, repeatable=True, rejoins=APPROVAL)


def goals_of(action: str) -> str:
    """Return the path of an action's goals."""
    return f"/actions/{quote(action.strip('/'))}/goals"


def goal(goal_id: str) -> Call[Goal]:
    """Ask for a goal."""
    return Call("GET", _goal(goal_id), Goal.read, repeatable=True)


def cancel(goal_id: str) -> Call[Goal]:
    """Cancel a goal."""
    return Call("POST", f"{_goal(goal_id)}/cancel", Goal.read, repeatable=True)


def robots() -> Call[list[Robot]]:
    """Ask for all robots."""
    return Call("GET", "/robots", lambda answer: [Robot.read(each) for each in answer["robots"]], repeatable=True)


def battery(robot: str | None) -> Call[Battery]:
    """Ask for a robot's battery."""
    return Call("GET", "/battery", Battery.read, params=_of(robot), repeatable=True)


def stop(robots: tuple[str, ...], by: str | None, *, latch: bool) -> Call[StopReport]:
    """Stop robots. Not repeated: who asks for it must know at once that it was not delivered."""
    params: Params = {"robot": list(robots)} if robots else {}
    return Call("POST", "/stop", StopReport.read, {"latch": latch, "by": by}, params, _prefer(2), wait=2)


def release(robot: str | None) -> Call[Document]:
    """Release a stop."""
    return Call("DELETE", "/stop", dict, params=_of(robot))


def call_service(name: str, request: Mapping[str, Any] | None, timeout: float) -> Call[Document]:
    """Call a service. Not repeated: the first call may have been carried out."""
    return Call(
        "POST",
        f"/services/{quote(name.strip('/'))}",
        lambda answer: answer["response"],
        request or {},
        {"timeout_s": timeout},
        wait=timeout,
    )


def publish(topic: str, message: Mapping[str, Any], type_name: str | None) -> Call[int]:
    """Publish a message."""
    params: Params = {} if type_name is None else {"type": type_name}
    return Call("POST", f"/topics/{quote(topic.strip('/'))}", lambda answer: answer["subscribers"], message, params)


def parameters(node: str) -> Call[Document]:
    """Ask for the values of a node's parameters."""
    return Call("GET", _parameters(node), _read_values, repeatable=True, wait=PARAMETERS)


def set_parameters(node: str, values: Mapping[str, Any]) -> Call[Document]:
    """Set parameters of a node."""
    return Call("PATCH", _parameters(node), _read_values, values, wait=SET_PARAMETERS)


def request(
    method: str, path: str, body: object, params: Params | None, wait: int, *, if_match: str | None = None
) -> Call[Any]:
    """Send any other request."""
    headers = {**(_prefer(wait) if wait else {}), **({} if if_match is None else {"If-Match": if_match})}
    return Call(method, path, lambda answer: answer, body, params or {}, headers, wait=wait)


def _prefer(wait: int) -> Mapping[str, str]:
    return {"Prefer": f"wait={wait}"}


def _parameters(node: str) -> str:
    return f"/nodes/{quote(node.strip('/'))}/parameters"


def _read_values(answer: Any) -> Document:
    return {parameter["name"]: parameter["value"] for parameter in answer["parameters"]}


def _goal(goal_id: str) -> str:
    return f"/goals/{quote(goal_id, safe='')}"


def _of(robot: str | None) -> Params:
    return {} if robot is None else {"robot": robot}
