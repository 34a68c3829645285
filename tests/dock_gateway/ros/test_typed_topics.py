"""The gateway's endpoints on a topic: all of them, or none."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import pytest
from std_msgs.msg import Bool

from dock_gateway.ros.listener import Handler
from dock_gateway.ros.typed_topics import GatewayEndpoints, TypedTopic, TypedTopics
from robot_io.qos import LATCHED, LISTEN
from robot_io.rclpy_private import RCLError

HANDLER = Handler(lambda *_: None)


class FakeNode:
    """Notes its endpoints. ROS does not take the one that is numbered `refused`."""

    def __init__(self) -> None:
        self.refused: int | None = None
        self.endpoints: list[str] = []
        self.history: list[str] = []

    def _create(self, name: str) -> str:
        if len(self.endpoints) == self.refused:
            raise RCLError("the topic has another type")
        self.endpoints.append(name)
        self.history.append(f"+{name}")
        return name

    def _destroy(self, name: str) -> None:
        self.endpoints.remove(name)
        self.history.append(f"-{name}")

    def create_publisher(self, *_: object) -> str:
        return self._create(f"publisher {len(self.history)}")

    def subscribe(self, *_: object) -> str:
        return self._create(f"subscription {len(self.history)}")

    destroy_publisher = destroy_subscription = _destroy


@pytest.fixture
def node() -> FakeNode:
    return FakeNode()


def join(node: FakeNode, opened: list[bool]) -> TypedTopic:
    topics = TypedTopics(cast("Any", SimpleNamespace(node=node)))
    asyncio.run(topics.update({}))
    handlers = ((HANDLER, LATCHED), (HANDLER, LISTEN))
    endpoints = GatewayEndpoints(handlers, publish=LATCHED, on_open=lambda: opened.append(True))
    return topics.join("/stop_latched", Bool, "/stop_latched", endpoints)


@pytest.mark.parametrize("refused", [0, 1, 2])
def test_if_ros_refuses_an_endpoint_none_is_left_and_all_are_tried_again(node: FakeNode, refused: int) -> None:
    opened: list[bool] = []
    node.refused = refused
    topic = join(node, opened)
    assert not topic.open
    assert topic.publisher is None
    assert node.endpoints == []
    assert opened == []
    node.refused = None
    topic.follow(["std_msgs/msg/Bool"])
    assert topic.open
    assert len(node.endpoints) == 3
    assert opened == [True]
    topic.close()
    assert topic.publisher is None
    assert node.endpoints == []


def test_a_topic_always_has_a_publisher_while_it_is_replaced(node: FakeNode) -> None:
    topic = join(node, [])
    before, node.history = topic.publisher, []
    topic.replace_publisher()
    assert topic.publisher is not before
    assert node.history == [f"+{topic.publisher}", f"-{before}"]
