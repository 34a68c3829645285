"""Looking at the graph: once for everybody who asks, in pieces, never without being asked."""

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.node import NodeNameNonExistentError
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from dock_gateway.core.errors import NotFound, Unavailable
from dock_gateway.graph.cache import GraphCache
from dock_gateway.ros.graph import Survey


class FakeNode:
    """A graph of one node with one topic and one service, and one node that leaves meanwhile."""

    def __init__(self) -> None:
        self.looks = 0
        self.gid = bytes(16)

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        self.looks += 1
        return [("driver", "/"), ("twin", "/robot1"), ("twin", "/robot1"), ("leaving", "/")]

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [("/reset", ["std_srvs/srv/Empty"])]

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [("/battery", ["sensor_msgs/msg/BatteryState"]), ("/no-ros-name", ["x/msg/X"])]

    def get_publishers_info_by_topic(self, name: str) -> list[Any]:
        assert name == "/battery"
        qos = QoSProfile(depth=3, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE)
        unknown = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")
        return [endpoint("driver", "/", qos, self.gid), endpoint(*unknown, qos, self.gid)]

    def get_subscriptions_info_by_topic(self, _: str) -> list[Any]:
        return []

    def get_service_names_and_types_by_node(self, name: str, _: str) -> list[tuple[str, list[str]]]:
        if name == "leaving":
            raise NodeNameNonExistentError
        return [("/reset", ["std_srvs/srv/Empty"])] if name == "driver" else []

    def get_client_names_and_types_by_node(self, name: str, _: str) -> list[tuple[str, list[str]]]:
        return [("/reset", ["std_srvs/srv/Empty"])] if name == "twin" else []


def endpoint(name: str, namespace: str, qos: QoSProfile, gid: bytes) -> Any:
    return SimpleNamespace(
        node_name=name,
        node_namespace=namespace,
        topic_type="sensor_msgs/msg/BatteryState",
        qos_profile=qos,
        endpoint_gid=gid,
    )


class FakeBridge:
    """Runs everything at once; counts how often."""

    def __init__(self) -> None:
        self.node = FakeNode()
        self.calls = 0
        self.down = False
        self.now = 100.0

    async def call(self, function: Callable[[], Any], **_: object) -> Any:
        if self.down:
            raise Unavailable("down", code="ros_unavailable")
        self.calls += 1
        await asyncio.sleep(0)
        return function()


@pytest.fixture
def bridge() -> FakeBridge:
    return FakeBridge()


def looking(bridge: FakeBridge) -> GraphCache:
    return GraphCache(bridge, lambda: bridge.now)  # type: ignore[arg-type]


async def test_one_look_serves_everybody_for_a_second(bridge: FakeBridge) -> None:
    cache = looking(bridge)
    assert bridge.calls == 0
    views = await asyncio.gather(*(cache.graph() for _ in range(20)))
    assert bridge.node.looks == 1
    assert all(view is views[0] for view in views)
    bridge.now += 0.9
    assert await cache.graph() is views[0]
    bridge.now += 0.2
    again = await cache.graph()
    assert bridge.node.looks == 2
    assert again is views[0]  # who follows the graph sees at once that nothing has changed
    await cache.close()


async def test_what_the_document_does_not_show_is_a_change_too(bridge: FakeBridge) -> None:
    cache = looking(bridge)
    before = await cache.graph()
    bridge.node.gid = bytes(range(16))  # another participant, of the same name
    bridge.now += 1.1
    after = await cache.graph()
    assert after.seen != before.seen
    assert after.body == before.body


async def test_one_who_leaves_does_not_take_the_look_from_the_others(bridge: FakeBridge) -> None:
    cache = looking(bridge)
    leaving, staying = asyncio.create_task(cache.graph()), asyncio.create_task(cache.graph())
    await asyncio.sleep(0)
    leaving.cancel()
    assert (await staying).body.startswith(b'{"nodes"')
    assert leaving.cancelled()


async def test_it_recovers(bridge: FakeBridge) -> None:
    cache = looking(bridge)
    bridge.down = True
    with pytest.raises(Unavailable):
        await cache.graph()
    bridge.down = False
    bridge.now += 1.1
    assert (await cache.graph()).body


def test_a_survey_sees_everything_and_leaves_the_ros_thread_to_others_in_between() -> None:
    node = FakeNode()
    survey = Survey(node, piece=0.0)  # type: ignore[arg-type]
    pieces = 1
    while not survey.proceed():
        pieces += 1
    assert pieces >= 6  # one for each topic and each node
    seen = survey.seen
    assert seen.nodes == {"/driver": 1, "/robot1/twin": 2, "/leaving": 1}
    assert [publisher.node for publisher in seen.topics["/battery"].publishers] == ["/driver", None]
    quality = seen.topics["/battery"].publishers[0].qos
    assert (quality.reliability, quality.durability, quality.history, quality.depth) == (
        "best_effort",
        "volatile",
        "keep_last",
        3,
    )
    assert (quality.deadline_s, quality.lifespan_s) == (None, None)
    assert seen.topics["/no-ros-name"].types == []
    assert (seen.services["/reset"].servers, seen.services["/reset"].clients) == ({"/driver"}, {"/robot1/twin"})


@pytest.mark.parametrize("name", ["/no-ros-name", "/", "", "//", "/battery/", "/{node}", "/battery\0x", "battery"])
async def test_names_that_no_topic_can_have(bridge: FakeBridge, name: str) -> None:
    with pytest.raises(NotFound) as caught:
        await looking(bridge).topic(name)
    assert caught.value.code == "topic_not_found"


async def test_one_topic(bridge: FakeBridge) -> None:
    topic = await looking(bridge).topic("/battery")
    assert topic.types == ["sensor_msgs/msg/BatteryState"]
    assert bridge.calls == 1
