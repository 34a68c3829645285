"""The connection graph that a viewer draws: publishers, subscribers and servers."""

from dataclasses import dataclass, field
from typing import Any

from dock_gateway.core.filters import is_hidden
from dock_gateway.core.grant import Grant
from dock_gateway.core.graph import Endpoint, GraphScan, narrow_graph

Nodes = dict[str, list[str]]


@dataclass(frozen=True)
class Connections:
    """The nodes at each topic and service that a user may see."""

    published: Nodes = field(default_factory=dict)
    subscribed: Nodes = field(default_factory=dict)
    services: Nodes = field(default_factory=dict)

    @classmethod
    def of(cls, seen: GraphScan, grant: Grant) -> "Connections":
        """Return those of a graph."""
        covered = narrow_graph(seen, grant)
        topics = [topic for name, topic in sorted(covered.topics.items()) if not is_hidden(name)]
        return cls(
            {topic.name: _names(topic.publishers) for topic in topics if topic.publishers},
            {topic.name: _names(topic.subscribers) for topic in topics if topic.subscribers},
            {
                name: sorted(service.servers)
                for name, service in sorted(covered.services.items())
                if service.servers and not is_hidden(name)
            },
        )

    def changes_since(self, before: "Connections") -> dict[str, Any] | None:
        """Return the message that tells a client of what has changed; None if nothing has."""
        topics = self.published.keys() | self.subscribed.keys()
        update = {
            "publishedTopics": _changes(before.published, self.published, "publisherIds"),
            "subscribedTopics": _changes(before.subscribed, self.subscribed, "subscriberIds"),
            "advertisedServices": _changes(before.services, self.services, "providerIds"),
            "removedTopics": sorted((before.published.keys() | before.subscribed.keys()) - topics),
            "removedServices": sorted(before.services.keys() - self.services.keys()),
        }
        return {"op": "connectionGraphUpdate", **update} if any(update.values()) else None


def _names(endpoints: list[Endpoint]) -> list[str]:
    """Return the nodes of endpoints; a DDS program that is no node has no name."""
    return sorted({endpoint.node or "?" for endpoint in endpoints})


def _changes(before: Nodes, now: Nodes, field_name: str) -> list[dict[str, Any]]:
    names = [name for name in sorted(before.keys() | now.keys()) if before.get(name) != now.get(name)]
    return [{"name": name, field_name: now.get(name, [])} for name in names]
