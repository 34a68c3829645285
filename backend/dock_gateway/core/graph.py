"""The ROS graph as nodes, topics, services and actions, built from one scan. Plain data."""

from collections import defaultdict
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from dock_gateway.core.filters import is_hidden
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Grant

ACTION_PART = "/_action/"
STATUS = "status"
FEEDBACK, FEEDBACK_TYPE = "feedback", "_FeedbackMessage"
SEND_GOAL, SEND_GOAL_TYPE = "send_goal", "_SendGoal"

# The type of transforms.
TRANSFORMS = "tf2_msgs/msg/TFMessage"
# Interfaces that ROS gives to every node: logs, parameters, type descriptions.
OWN_TYPES = ("rcl_interfaces/", "type_description_interfaces/")


@dataclass(frozen=True)
class Quality:
    """Quality of service, in ROS terms. `depth` None: unknown. Seconds None: no limit."""

    reliability: str
    durability: str
    history: str
    depth: int | None
    deadline_s: float | None
    lifespan_s: float | None
    liveliness: str


# A node, if it is one, and the DDS participant that it belongs to: nodes of the same name are different ones.
Peer = tuple[str | None, bytes]
# The bytes of the id of an endpoint that are those of its participant.
PARTICIPANT = 12


@dataclass(frozen=True)
class Endpoint:
    """A publisher or a subscription. `node` is None if it belongs to a DDS program that is not a ROS node."""

    node: str | None
    type: str
    qos: Quality
    gid: bytes = b""

    @property
    def peer(self) -> Peer:
        """The node that it belongs to."""
        return self.node, self.gid[:PARTICIPANT]

    def document(self) -> dict[str, Any]:
        """Return the document that the API shows."""
        return {"node": self.node, "qos": self.qos}


@dataclass
class Topic:
    """A topic with its publishers and subscribers."""

    name: str
    publishers: list[Endpoint]
    subscribers: list[Endpoint]

    @property
    def types(self) -> list[str]:
        """Its types, sorted. More than one is a mistake on the graph; none means that the topic is gone."""
        return sorted({endpoint.type for endpoint in (*self.publishers, *self.subscribers)})

    def types_but_of(self, nodes: Container[str | None]) -> set[str]:
        """Return the types that it has on other nodes than these."""
        return {endpoint.type for endpoint in (*self.publishers, *self.subscribers) if endpoint.node not in nodes}

    def document(self) -> dict[str, Any]:
        """Return the document that the API shows."""
        return {
            "name": self.name,
            "types": self.types,
            "publishers": _in_order(self.publishers),
            "subscribers": _in_order(self.subscribers),
            "hidden": is_noise(self.name, self.types),
        }


@dataclass
class Service:
    """A service. It may have clients only."""

    name: str
    types: list[str]
    servers: set[str] = field(default_factory=set)
    clients: set[str] = field(default_factory=set)


@dataclass
class GraphScan:
    """One scan of the graph: the number of nodes of each name, the topics and the services."""

    nodes: dict[str, int] = field(default_factory=dict)
    topics: dict[str, Topic] = field(default_factory=dict)
    services: dict[str, Service] = field(default_factory=dict)


@dataclass
class _Action:
    types: set[str] = field(default_factory=set)
    servers: set[str] = field(default_factory=set)
    clients: set[str] = field(default_factory=set)


class _Nodes:
    """The endpoints of each node, collected from topics, services and actions."""

    KINDS = ("publishers", "subscribers", "services", "clients", "action_servers", "action_clients")

    def __init__(self, counts: Mapping[str, int]) -> None:
        self._counts = counts
        self._parts: dict[str, dict[str, set[str]]] = {name: self._nothing() for name in counts}

    def _nothing(self) -> dict[str, set[str]]:
        return {kind: set() for kind in self.KINDS}

    def add(self, kind: str, thing: str, nodes: Iterable[str]) -> None:
        """Add a thing to nodes. A node that appeared during the scan counts, too."""
        for node in nodes:
            self._parts.setdefault(node, self._nothing())[kind].add(thing)

    def documents(self) -> list[dict[str, Any]]:
        """Return all nodes, sorted by name."""
        return [
            {
                "name": name,
                "count": self._counts.get(name, 1),
                **{kind: sorted(things) for kind, things in parts.items()},
                "hidden": is_noise(name, ()),
            }
            for name, parts in sorted(self._parts.items())
        ]


def is_noise(name: str, types: Iterable[str]) -> bool:
    """Return whether ROS itself uses it (logs, parameters and the like), or a part of its name begins with `_`."""
    return is_hidden(name) or (bool(types) and all(text.startswith(OWN_TYPES) for text in types))


def graph_document(seen: GraphScan) -> dict[str, Any]:
    """Return the graph as the API shows it. The same graph gives the same document.

    The topics and services of an action are shown as one action. As in rcl, its servers are the nodes that publish its
    feedback, its clients the nodes that subscribe to it.
    """
    nodes, actions = _Nodes(seen.nodes), _find_actions(seen)
    topics = [topic for name, topic in sorted(seen.topics.items()) if ACTION_PART not in name and topic.types]
    services = [service for name, service in sorted(seen.services.items()) if ACTION_PART not in name]
    for topic in topics:
        nodes.add("publishers", topic.name, _nodes_of(topic.publishers))
        nodes.add("subscribers", topic.name, _nodes_of(topic.subscribers))
    for service in services:
        nodes.add("services", service.name, service.servers)
        nodes.add("clients", service.name, service.clients)
    for name, action in actions.items():
        nodes.add("action_servers", name, action.servers)
        nodes.add("action_clients", name, action.clients)
    return {
        "nodes": nodes.documents(),
        "topics": [topic.document() for topic in topics],
        "services": [
            {
                "name": service.name,
                "types": sorted(service.types),
                "servers": sorted(service.servers),
                "hidden": is_noise(service.name, service.types),
            }
            for service in services
        ],
        "actions": [
            {
                "name": name,
                "types": sorted(action.types),
                "servers": sorted(action.servers),
                "clients": sorted(action.clients),
                "hidden": is_hidden(name),
            }
            for name, action in sorted(actions.items())
        ],
    }


def narrow_graph(seen: GraphScan, grant: Grant) -> GraphScan:
    """Return what a grant includes of a graph.

    The other nodes that use it are seen only as users of it.
    """

    def covers(name: str) -> bool:
        action, of_action, _ = name.partition(ACTION_PART)
        return grant.covers_action(action) if of_action else grant.covers_topic(name)

    def covers_service(name: str) -> bool:
        action, of_action, _ = name.partition(ACTION_PART)
        return grant.covers_action(action) if of_action else grant.covers_place(name)

    return GraphScan(
        nodes={name: count for name, count in seen.nodes.items() if grant.covers_place(name)},
        topics={name: topic for name, topic in seen.topics.items() if covers(name)},
        services={name: service for name, service in seen.services.items() if covers_service(name)},
    )


def _find_actions(seen: GraphScan) -> dict[str, _Action]:
    actions: dict[str, _Action] = defaultdict(_Action)
    for topic in seen.topics.values():
        name, separator, part = topic.name.partition(ACTION_PART)
        if not separator or not topic.types:
            continue
        action = actions[name]
        if part == FEEDBACK:
            action.types |= {text.removesuffix(FEEDBACK_TYPE) for text in topic.types}
            action.servers |= set(_nodes_of(topic.publishers))
            action.clients |= set(_nodes_of(topic.subscribers))
    for service in seen.services.values():
        name, separator, part = service.name.partition(ACTION_PART)
        if separator and part == SEND_GOAL:
            actions[name].types |= {text.removesuffix(SEND_GOAL_TYPE) for text in service.types}
    return actions


def _nodes_of(endpoints: Iterable[Endpoint]) -> Iterator[str]:
    return (endpoint.node for endpoint in endpoints if endpoint.node is not None)


def _in_order(endpoints: Iterable[Endpoint]) -> list[dict[str, Any]]:
    return sorted((endpoint.document() for endpoint in endpoints), key=encode)
