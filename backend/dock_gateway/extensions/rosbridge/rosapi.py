"""`/rosapi/*`: what rosbridge's own services tell about the ROS graph, answered by the gateway from its graph cache."""

import asyncio
import os
import time
from collections.abc import Callable, Iterable
from typing import Any

from dock_gateway.core.errors import FieldError, InvalidField, NotFound
from dock_gateway.core.filters import is_hidden
from dock_gateway.core.grant import Grant
from dock_gateway.core.graph import Endpoint, GraphScan, Service, Topic, graph_document
from dock_gateway.extensions.rosbridge.typedefs import definition_texts, message_definitions, service_definitions
from dock_gateway.graph.cache import GraphCache
from dock_gateway.http.parts import Parts
from dock_gateway.ros.messages.interfaces import full_type

Json = dict[str, Any]

PREFIX = "/rosapi/"
# The arguments of the services, where they have one; a client may send them by name or in order.
ARGUMENTS = {
    "topics_for_type": "type",
    "topic_type": "topic",
    "publishers": "topic",
    "subscribers": "topic",
    "services_for_type": "type",
    "service_type": "service",
    "service_node": "service",
    "service_providers": "service",
    "node_details": "node",
    "message_details": "type",
    "service_request_details": "type",
    "service_response_details": "type",
}


async def answer(parts: Parts, grant: Grant, service: str, args: Any) -> Json:
    """Return the answer of a service of `/rosapi`, without what the user's grant does not include.

    Raises:
        InvalidField: An argument is missing or no text.
        NotFound: There is no such service, or no such type here.
        Unavailable: `ros_unavailable`, when the ROS thread is down.
    """
    name = service.removeprefix(PREFIX)
    if name in _TIMELESS:
        return _TIMELESS[name]()
    argument = _argument(ARGUMENTS[name], args) if name in ARGUMENTS else ""
    if name in _TYPES:
        try:
            return {"typedefs": await asyncio.to_thread(_TYPES[name], argument)}
        except (ImportError, TypeError) as error:
            raise NotFound(str(error), code="interface_not_found") from None
    if name not in _GRAPH:
        raise NotFound(f"the gateway has no service {service[:100]}", code="service_not_found")
    seen = (await parts[GraphCache].graph(grant)).seen
    return await asyncio.to_thread(_GRAPH[name], seen, argument)


def _argument(name: str, args: Any) -> str:
    value = args.get(name) if isinstance(args, dict) else args[0] if isinstance(args, list) and args else None
    if not isinstance(value, str):
        raise InvalidField(
            [FieldError(f"args.{name}", "a text", "got none" if value is None else "got something else")]
        )
    return value


def _topics(seen: GraphScan) -> dict[str, Topic]:
    return {name: topic for name, topic in sorted(seen.topics.items()) if topic.types and not is_hidden(name)}


def _services(seen: GraphScan) -> dict[str, Service]:
    return {name: each for name, each in sorted(seen.services.items()) if each.servers and not is_hidden(name)}


def _all_topics(seen: GraphScan, _: str) -> Json:
    topics = _topics(seen)
    return {"topics": list(topics), "types": [topic.types[0] for topic in topics.values()]}


def _topics_and_raw_types(seen: GraphScan, _: str) -> Json:
    answer = _all_topics(seen, "")
    return answer | {"typedefs_full_text": [definition_texts(name) for name in answer["types"]]}


def _topics_for_type(seen: GraphScan, name: str) -> Json:
    return {"topics": [topic for topic, each in _topics(seen).items() if full_type(name) in each.types]}


def _topic_type(seen: GraphScan, name: str) -> Json:
    topic = seen.topics.get(name)
    return {"type": topic.types[0] if topic is not None and topic.types else ""}


def _publishers(seen: GraphScan, name: str) -> Json:
    return {"publishers": _nodes(seen.topics[name].publishers) if name in seen.topics else []}


def _subscribers(seen: GraphScan, name: str) -> Json:
    return {"subscribers": _nodes(seen.topics[name].subscribers) if name in seen.topics else []}


def _nodes(endpoints: Iterable[Endpoint]) -> list[str]:
    return sorted({endpoint.node for endpoint in endpoints if endpoint.node is not None})


def _all_services(seen: GraphScan, _: str) -> Json:
    return {"services": list(_services(seen))}


def _services_for_type(seen: GraphScan, name: str) -> Json:
    return {"services": [each for each, service in _services(seen).items() if full_type(name, "srv") in service.types]}


def _service_type(seen: GraphScan, name: str) -> Json:
    service = seen.services.get(name)
    return {"type": service.types[0] if service is not None and service.types else ""}


def _service_node(seen: GraphScan, name: str) -> Json:
    service = seen.services.get(name)
    return {"node": min(service.servers, default="") if service is not None else ""}


def _service_providers(seen: GraphScan, name: str) -> Json:
    of_type = (each for each in _services(seen).values() if full_type(name, "srv") in each.types)
    return {"providers": sorted({node for service in of_type for node in service.servers})}


def _all_nodes(seen: GraphScan, _: str) -> Json:
    return {"nodes": sorted(name for name in seen.nodes if not is_hidden(name))}


def _node_details(seen: GraphScan, name: str) -> Json:
    if name not in seen.nodes:
        raise NotFound(f"there is no node {name[:200]} on the ROS graph", code="node_not_found")
    return {
        "subscribing": sorted(topic.name for topic in seen.topics.values() if name in _nodes(topic.subscribers)),
        "publishing": sorted(topic.name for topic in seen.topics.values() if name in _nodes(topic.publishers)),
        "services": sorted(service.name for service in seen.services.values() if name in service.servers),
    }


def _action_servers(seen: GraphScan, _: str) -> Json:
    return {"action_servers": [action["name"] for action in graph_document(seen)["actions"] if action["servers"]]}


def _interfaces(seen: GraphScan, _: str) -> Json:
    of_topics = {name for topic in seen.topics.values() for name in topic.types}
    of_services = {name for service in seen.services.values() for name in service.types}
    return {"interfaces": sorted(of_topics | of_services)}


def _time() -> Json:
    seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
    # roslibpy reads the names of ROS 1
    return {"time": {"sec": seconds, "nanosec": nanoseconds, "secs": seconds, "nsecs": nanoseconds}}


def _version() -> Json:
    return {"version": 2, "distro": os.environ.get("ROS_DISTRO", "jazzy")}


_TIMELESS: dict[str, Callable[[], Json]] = {"get_time": _time, "get_ros_version": _version}

_TYPES: dict[str, Callable[[str], list[Json]]] = {
    "message_details": message_definitions,
    "service_request_details": lambda name: service_definitions(name, "Request"),
    "service_response_details": lambda name: service_definitions(name, "Response"),
}

_GRAPH: dict[str, Callable[[GraphScan, str], Json]] = {
    "topics": _all_topics,
    "topics_and_raw_types": _topics_and_raw_types,
    "topics_for_type": _topics_for_type,
    "topic_type": _topic_type,
    "publishers": _publishers,
    "subscribers": _subscribers,
    "services": _all_services,
    "services_for_type": _services_for_type,
    "service_type": _service_type,
    "service_node": _service_node,
    "service_providers": _service_providers,
    "nodes": _all_nodes,
    "node_details": _node_details,
    "action_servers": _action_servers,
    "interfaces": _interfaces,
}

SERVICES = frozenset(PREFIX + name for name in (*_TIMELESS, *_TYPES, *_GRAPH))
