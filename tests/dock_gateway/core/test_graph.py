"""The graph put together from what was seen."""

from typing import Any

import orjson
import pytest
from rclpy.validate_full_topic_name import validate_full_topic_name

from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.graph import Endpoint, GraphScan, Quality, Service, Topic, graph_document, is_noise, narrow_graph
from dock_gateway.http.requests import is_known_tag
from dock_gateway.ros.graph import scan

QOS = Quality("reliable", "volatile", "unknown", None, None, None, "automatic")
SENSOR = Quality("best_effort", "volatile", "unknown", None, 0.5, None, "automatic")
FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"


def at(node: str | None, kind: str, qos: Quality = QOS) -> Endpoint:
    return Endpoint(node, kind, qos)


def seen(*topics: Topic, services: tuple[Service, ...] = (), **nodes: int) -> GraphScan:
    return GraphScan(
        {f"/{name}": count for name, count in nodes.items()},
        {topic.name: topic for topic in topics},
        {service.name: service for service in services},
    )


def battery() -> Topic:
    kind = "sensor_msgs/msg/BatteryState"
    return Topic("/battery_status", [at("/driver", kind, SENSOR)], [at("/dock", kind), at("/gateway", kind)])


def fibonacci() -> tuple[tuple[Topic, ...], tuple[Service, ...]]:
    feedback = Topic(
        "/fibonacci/_action/feedback",
        [at("/server", f"{FIBONACCI}_FeedbackMessage")],
        [at("/gateway", f"{FIBONACCI}_FeedbackMessage")],
    )
    status = Topic(
        "/fibonacci/_action/status",
        [at("/server", "action_msgs/msg/GoalStatusArray")],
        [at("/looker", "action_msgs/msg/GoalStatusArray")],
    )
    send = Service("/fibonacci/_action/send_goal", [f"{FIBONACCI}_SendGoal"], {"/server"}, {"/gateway"})
    cancel = Service("/fibonacci/_action/cancel_goal", ["action_msgs/srv/CancelGoal"], {"/server"}, {"/gateway"})
    return (feedback, status), (send, cancel)


def test_a_topic_and_the_nodes_at_its_ends() -> None:
    document = graph_document(seen(battery(), driver=1, dock=1, gateway=2))
    (topic,) = document["topics"]
    assert topic["types"] == ["sensor_msgs/msg/BatteryState"]
    assert topic["publishers"] == [{"node": "/driver", "qos": SENSOR}]
    assert [entry["node"] for entry in topic["subscribers"]] == ["/dock", "/gateway"]
    nodes = {node["name"]: node for node in document["nodes"]}
    assert nodes["/driver"]["publishers"] == ["/battery_status"]
    assert nodes["/driver"]["subscribers"] == []
    assert nodes["/dock"]["subscribers"] == ["/battery_status"]
    assert {name: node["count"] for name, node in nodes.items()} == {"/dock": 1, "/driver": 1, "/gateway": 2}


def test_what_makes_up_an_action_is_one_action() -> None:
    topics, services = fibonacci()
    document = graph_document(seen(*topics, services=services, server=1, gateway=1, looker=1))
    assert (document["topics"], document["services"]) == ([], [])
    assert document["actions"] == [
        {"name": "/fibonacci", "types": [FIBONACCI], "servers": ["/server"], "clients": ["/gateway"], "hidden": False}
    ]
    nodes = {node["name"]: node for node in document["nodes"]}
    assert nodes["/server"]["action_servers"] == nodes["/gateway"]["action_clients"] == ["/fibonacci"]
    assert nodes["/gateway"]["clients"] == nodes["/server"]["services"] == nodes["/looker"]["subscribers"] == []


def test_an_action_of_which_only_a_client_is_there_is_known_by_its_services() -> None:
    services = (Service("/fibonacci/_action/send_goal", [f"{FIBONACCI}_SendGoal"], set(), {"/client"}),)
    document = graph_document(seen(services=services, client=1))
    assert document["actions"] == [
        {"name": "/fibonacci", "types": [FIBONACCI], "servers": [], "clients": [], "hidden": False}
    ]


def test_the_same_graph_gives_the_same_document_in_whatever_order_it_was_seen() -> None:
    def topic(*nodes: str) -> Topic:
        return Topic("/t", [at(node, "std_msgs/msg/Bool") for node in nodes], [])

    def services(*names: str) -> tuple[Service, ...]:
        return tuple(Service(name, ["std_srvs/srv/Empty"], set(names), set()) for name in names)

    one = seen(battery(), topic("/a", "/b", "/c"), services=services("/x", "/y"), a=1, b=1)
    other = seen(topic("/c", "/a", "/b"), battery(), services=services("/y", "/x"), b=1, a=1)
    assert encode(graph_document(one)) == encode(graph_document(other))
    assert encode(graph_document(one)) != encode(graph_document(seen(battery(), topic("/a", "/b"), a=1, b=1)))


def test_programs_that_are_no_nodes_and_topics_that_went_meanwhile() -> None:
    bare = Topic("/bare", [at(None, "std_msgs/msg/Bool")], [])
    document = orjson.loads(encode(graph_document(seen(bare, Topic("/gone", [], [])))))
    assert document["nodes"] == []
    (topic,) = document["topics"]
    assert topic["publishers"][0]["node"] is None
    assert topic["publishers"][0]["qos"] == {
        "reliability": "reliable",
        "durability": "volatile",
        "history": "unknown",
        "depth": None,
        "deadline_s": None,
        "lifespan_s": None,
        "liveliness": "automatic",
    }


def test_a_node_that_came_while_the_look_went_on_is_there() -> None:
    (node,) = graph_document(seen(Topic("/t", [at("/new", "std_msgs/msg/Bool")], [])))["nodes"]
    assert (node["name"], node["count"], node["publishers"]) == ("/new", 1, ["/t"])


@pytest.mark.parametrize(
    ("name", "types", "noise"),
    [
        ("/rosout", ["rcl_interfaces/msg/Log"], True),
        ("/parameter_events", ["rcl_interfaces/msg/ParameterEvent"], True),
        ("/dock/set_parameters_atomically", ["rcl_interfaces/srv/SetParametersAtomically"], True),
        ("/dock/get_type_description", ["type_description_interfaces/srv/GetTypeDescription"], True),
        ("/robot1/_internal/state", ["std_msgs/msg/Bool"], True),
        ("/add/_service_event", ["test_msgs/srv/Empty_Event"], True),
        ("/_ros2cli_1234", [], True),
        ("/battery_status", ["sensor_msgs/msg/BatteryState"], False),
        ("/under_score_", ["std_msgs/msg/Bool"], False),
        ("/diagnostics", ["diagnostic_msgs/msg/DiagnosticArray"], False),
        ("/mixed", ["rcl_interfaces/msg/Log", "std_msgs/msg/Bool"], False),
        ("/node", [], False),
    ],
)
def test_noise(name: str, types: list[str], noise: bool) -> None:
    assert is_noise(name, types) is noise


@pytest.mark.parametrize(
    ("condition", "known"),
    [
        (None, False),
        ("", False),
        ('"abc"', True),
        ('W/"abc"', True),
        ('"x", "abc"', True),
        ("*", True),
        ('"abcd"', False),
        ("abc", False),
    ],
)
def test_conditions(condition: str | None, known: bool) -> None:
    assert is_known_tag(condition, '"abc"') is known


class OddNode:
    """Sees topics as programs of DDS that are no ROS nodes may name them."""

    def __init__(self, *names: str) -> None:
        self._names = names

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [(name, [f"{FIBONACCI}_FeedbackMessage"]) for name in self._names]

    @staticmethod
    def count_publishers(name: str) -> int:
        validate_full_topic_name(name)  # as the real one does
        return 1


def test_odd_names_keep_nothing_from_being_found() -> None:
    odd = ("/a b", "/0robot", "//", "/robot/", "/röbot", "", "/" + "x" * 300, "/a__b")
    names = (name + part for name in (*odd, "/fibonacci") for part in ("/_action/feedback", "/battery_status"))
    node: Any = OddNode(*names)
    found = scan(node)
    assert list(found.actions) == ["/a__b", "/fibonacci"] or list(found.actions) == ["/fibonacci"]
    assert "/fibonacci/battery_status" in found.topics
    assert not [name for name in found.topics if " " in name or "//" in name]


def of(robot: str) -> tuple[list[Topic], list[Service], str]:
    """A robot with a node, a topic that the gateway reads, a service and an action."""
    node, kind = f"{robot}/driver", "sensor_msgs/msg/BatteryState"
    topics = [
        Topic(f"{robot}/battery_status", [at(node, kind)], [at("/gateway", kind)]),
        Topic(f"{robot}/fibonacci/_action/feedback", [at(node, f"{FIBONACCI}_FeedbackMessage")], []),
    ]
    services = [
        Service(f"{robot}/driver/get_parameters", ["rcl_interfaces/srv/GetParameters"], {node}),
        Service(f"{robot}/fibonacci/_action/send_goal", [f"{FIBONACCI}_SendGoal"], {node}),
    ]
    return topics, services, node.lstrip("/")


@pytest.mark.parametrize("limits", [{"robots": ("/robot1",)}, {"robots": ("/robot1",), "topics": ("*/odom",)}])
def test_a_limited_grant_has_its_own_part(limits: dict[str, Any]) -> None:
    parts = [of("/robot1"), of("/robot10"), of("")]
    topics, services = ([thing for part in parts for thing in part[index]] for index in (0, 1))
    nodes = dict.fromkeys([*(name for _, _, name in parts), "gateway"], 1)
    graph = seen(*topics, services=tuple(services), **nodes)  # type: ignore[arg-type]
    document = graph_document(narrow_graph(graph, Grant(Role.VIEWER, **limits)))
    assert [action["name"] for action in document["actions"]] == ["/robot1/fibonacci"]
    assert [service["name"] for service in document["services"]] == ["/robot1/driver/get_parameters"]
    if "topics" in limits:
        assert document["topics"] == []
        assert [node["name"] for node in document["nodes"]] == ["/robot1/driver"]
    else:
        assert [topic["name"] for topic in document["topics"]] == ["/robot1/battery_status"]
        assert [node["name"] for node in document["nodes"]] == ["/gateway", "/robot1/driver"]
        assert document["nodes"][0]["subscribers"] == ["/robot1/battery_status"]
    assert b"/robot10" not in encode(document)


def test_without_an_action_its_parts_are_left_out() -> None:
    topics, services, _ = of("/robot1")
    grant = Grant(Role.VIEWER, actions=("*/dock",))
    document = graph_document(narrow_graph(seen(*topics, services=tuple(services)), grant))
    assert document["actions"] == []
    assert [topic["name"] for topic in document["topics"]] == ["/robot1/battery_status"]
