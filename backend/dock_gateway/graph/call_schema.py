"""The JSON shapes of services, parameters and topics."""

from typing import Any

from dock_gateway.http.schema import Schema


class Permission(Schema):
    """Whether the gateway's settings let clients use something; if not, `reason` is the sentence that says why."""

    allowed: bool
    reason: str | None


class ServiceInfo(Schema):
    """A service: its types on the graph, of which `type` is called, and the JSON Schema of what it takes and gives.

    The schemas are null if its package is missing; `hint` says what to install. If it only `reads`, no setting is
    needed to call it, and a stop does not hold for it.
    """

    service: str
    type: str
    types: list[str]
    reads: bool
    hint: str | None
    call: Permission
    request: dict[str, Any] | None
    response: dict[str, Any] | None


class ServiceAnswer(Schema):
    """The response of a service."""

    service: str
    type: str
    response: dict[str, Any]


class TopicInfo(Schema):
    """A topic: its types on the graph, of which `type` is published, and the JSON Schema of its messages.

    The schema is null if its package is missing; `hint` says what to install. If it only `reports` something, a stop
    does not hold for it.
    """

    topic: str
    type: str
    types: list[str]
    reports: bool
    hint: str | None
    publish: Permission
    message: dict[str, Any] | None


class PublishedMessage(Schema):
    """A message as it was published, and the number of subscriptions that it was sent to."""

    topic: str
    type: str
    subscribers: int
    message: dict[str, Any]


class ParameterRange(Schema):
    """What a number may be. `step` is 0 if there are no steps; an integer beyond ±(2^53 - 1) is a string."""

    minimum: int | float | str
    maximum: int | float | str
    step: int | float | str


class ParameterInfo(Schema):
    """A parameter. `value` is null if it is not set; so is a number that is NaN or infinite."""

    name: str
    type: str
    value: Any
    description: str
    constraints: str
    read_only: bool
    dynamic_typing: bool
    range: ParameterRange | None


class NodeParameters(Schema):
    """The parameters of a node, sorted by name."""

    node: str
    set: Permission
    parameters: list[ParameterInfo]


class ParameterChange(Schema):
    """The result for one parameter: `value` is its value now, `reason` is why the node refused it."""

    name: str
    successful: bool
    reason: str
    value: Any


class ParameterChanges(Schema):
    """The results for the parameters that were to be set."""

    node: str
    parameters: list[ParameterChange]
