"""The shapes of the graph; as in `schemas`, nothing is validated or encoded with them at run time."""

from datetime import datetime
from typing import Any, Literal

from pydantic import BaseModel

from dock_gateway.web.schemas.events import ClosingEvent, DroppedEvent, HeartbeatEvent
from dock_gateway.web.schemas.goals import Schema


class TopicQuality(Schema):
    """Quality of service; a `depth` of null is not known, seconds of null are without limit."""

    reliability: str
    durability: str
    history: str
    depth: int | None
    deadline_s: float | None
    lifespan_s: float | None
    liveliness: str


class TopicEndpoint(Schema):
    """A publisher or a subscription; `node` is null for that of a DDS program which is no ROS node."""

    node: str | None
    qos: TopicQuality


class GraphNode(Schema):
    """A node, or `count` nodes of the same name, and the names of what it has."""

    name: str
    count: int
    publishers: list[str]
    subscribers: list[str]
    services: list[str]
    clients: list[str]
    action_servers: list[str]
    action_clients: list[str]
    hidden: bool


class GraphTopic(Schema):
    """A topic with everyone at it; more than one type is a mistake on the graph."""

    name: str
    types: list[str]
    publishers: list[TopicEndpoint]
    subscribers: list[TopicEndpoint]
    hidden: bool


class GraphService(Schema):
    """A service; without servers somebody waits for it."""

    name: str
    types: list[str]
    servers: list[str]
    hidden: bool


class GraphAction(Schema):
    """An action, in place of the topics and services that it is made of."""

    name: str
    types: list[str]
    servers: list[str]
    clients: list[str]


class Graph(Schema):
    """The ROS graph; what is `hidden` is there for ROS's own sake."""

    nodes: list[GraphNode]
    topics: list[GraphTopic]
    services: list[GraphService]
    actions: list[GraphAction]


class TopicEvent(Schema):
    """Who is at the topic: the first message of a stream, and again when that changes.

    Where messages cannot be read, because their package is not `installed` for example, `hint` says what to do.
    """

    type: Literal["topic"]
    time: datetime
    topic: GraphTopic
    message_type: str
    installed: bool
    hint: str | None


class MessageEvent(Schema):
    """A message of the topic; `time` is when it was published.

    `abbreviated` ones have the first 100 items of long arrays and 10,000 characters of long texts; `lengths` says how
    long they were, by the dotted path of the field.
    """

    type: Literal["message"]
    time: datetime
    topic: str
    message: dict[str, Any]
    abbreviated: bool
    lengths: dict[str, int]


class RateEvent(Schema):
    """How much is sent: over the last 3 s, and `messages` in all since somebody looks."""

    type: Literal["rate"]
    time: datetime
    topic: str
    hz: float
    bytes_per_s: int
    messages: int


ECHO_EVENTS: tuple[type[BaseModel], ...] = (
    TopicEvent,
    MessageEvent,
    RateEvent,
    HeartbeatEvent,
    DroppedEvent,
    ClosingEvent,
)
