"""Counting the messages of a type that is not installed."""

import time
from collections.abc import Callable
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import LaserScan

from dock_gateway.ros.stand_in import stand_in

pytestmark = pytest.mark.ros


def test_messages_of_a_type_known_by_name_alone_come_as_bytes(domain: int) -> None:
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    node, talker = (rclpy.create_node(name, context=context) for name in ("listener", "talker"))
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    heard: list[bytes] = []
    try:
        publisher = talker.create_publisher(LaserScan, "scan", 10)
        message_class = stand_in("sensor_msgs/msg/LaserScan")
        for _ in range(2):  # again, once it is known
            subscription = node.create_subscription(message_class, "scan", heard.append, 10, raw=True)
            spin(executor, lambda: publisher.get_subscription_count() == 1)
            heard.clear()
            publisher.publish(LaserScan(ranges=[1.0] * 50_000))
            spin(executor, lambda: len(heard) == 1)
            assert len(heard[0]) > 200_000
            (info,) = talker.get_subscriptions_info_by_topic("scan")
            assert info.topic_type == "sensor_msgs/msg/LaserScan"
            node.destroy_subscription(subscription)
            spin(executor, lambda: publisher.get_subscription_count() == 0)
        real: list[Any] = []
        node.create_subscription(LaserScan, "scan", real.append, 10)
        spin(executor, lambda: publisher.get_subscription_count() == 1)
        publisher.publish(LaserScan(ranges=[1.0] * 3))
        spin(executor, lambda: len(real) == 1)
        assert list(real[0].ranges) == [1.0] * 3
    finally:
        executor.shutdown()
        node.destroy_node()
        talker.destroy_node()
        context.try_shutdown()


def spin(executor: SingleThreadedExecutor, condition: Callable[[], bool], timeout: float = 10.0) -> None:
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline
        executor.spin_once(0.05)


def test_there_is_one_for_each_name_and_none_for_what_is_no_name() -> None:
    assert stand_in("lift_msgs/msg/LiftState") is stand_in("lift_msgs/msg/LiftState")
    assert stand_in("lift_msgs/msg/LiftState") is not stand_in("lift_msgs/msg/LiftRequest")
    for name in ("", "Lift", "lift_msgs::msg::dds_::LiftState_", "a/b/c/d", "a//b"):
        assert stand_in(name) is None
