"""Schemas of the ROS graph, for the OpenAPI document: nothing is validated or encoded with them at run time."""

from dock_gateway.http.schema import Schema


class TopicQuality(Schema):
    """Quality of service. A null `depth` is unknown; null seconds are unlimited."""

    reliability: str
    durability: str
    history: str
    depth: int | None
    deadline_s: float | None
    lifespan_s: float | None
    liveliness: str


class TopicEndpoint(Schema):
    """A publisher or subscription; `node` is null for a DDS program that is not a ROS node."""

    node: str | None
    qos: TopicQuality


class GraphNode(Schema):
    """A node, or `count` nodes of the same name, and the names of its topics, services and actions."""

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
    """A topic with its publishers and subscribers. More than one type is an error on the graph."""

    name: str
    types: list[str]
    publishers: list[TopicEndpoint]
    subscribers: list[TopicEndpoint]
    hidden: bool


class GraphService(Schema):
    """A service. If it has no servers, a client is waiting for it."""

    name: str
    types: list[str]
    servers: list[str]
    hidden: bool


class GraphAction(Schema):
    """An action, listed in place of its topics and services."""

    name: str
    types: list[str]
    servers: list[str]
    clients: list[str]
    hidden: bool


class Graph(Schema):
    """The ROS graph; `hidden` entries are ROS internals, or a part of their name begins with `_`."""

    nodes: list[GraphNode]
    topics: list[GraphTopic]
    services: list[GraphService]
    actions: list[GraphAction]
