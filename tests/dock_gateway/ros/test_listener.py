"""Subscriptions that are heard beside rclpy's executor."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.qos import QoSProfile
from std_msgs.msg import Int32, String
from std_srvs.srv import SetBool

from dock_gateway.ros.listener import AnswerListener, Handler, MessageListener, Unread
from dock_gateway.ros.listening_node import ListeningNode
from tests.support.waiting import PATIENCE

pytestmark = pytest.mark.ros

MAX_BYTES = 100_000


@pytest.fixture
def node(domain: int) -> Iterator[ListeningNode]:
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    messages, answers = MessageListener("messages", context, MAX_BYTES), AnswerListener("answers", context)
    node = ListeningNode("listening", None, context, messages, answers)
    for listener in (messages, answers):
        listener.start()
    yield node
    for listener in (messages, answers):
        assert listener.alive
        assert listener.close()
    node.destroy_node()
    context.try_shutdown()


def wait_for(condition: Callable[[], bool], timeout: float = PATIENCE) -> None:
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_every_message_is_heard_in_order_with_its_timestamp(node: ListeningNode) -> None:
    heard: list[tuple[int, int, str]] = []

    def hear(message: Any, info: dict[str, Any]) -> None:
        heard.append((message.data, info["source_timestamp"], threading.current_thread().name))
        if message.data == 7:
            raise ValueError("it goes on")

    publisher = node.create_publisher(Int32, "numbers", QoSProfile(depth=1000))
    node.subscribe(Int32, "numbers", Handler(hear), QoSProfile(depth=1000))
    wait_for(lambda: publisher.get_subscription_count() == 1)
    for number in range(500):
        publisher.publish(Int32(data=number))
    wait_for(lambda: len(heard) == 500)
    assert [number for number, _, _ in heard] == list(range(500))
    assert [stamp for _, stamp, _ in heard] == sorted(stamp for _, stamp, _ in heard)
    assert {thread for _, _, thread in heard} == {"messages"}


def test_subscriptions_come_and_go_while_messages_do(node: ListeningNode) -> None:
    publisher = node.create_publisher(Int32, "numbers", QoSProfile(depth=10))
    stop = threading.Event()

    def publish() -> None:
        while not stop.wait(0.0005):
            publisher.publish(Int32(data=1))

    heard: list[int] = []
    talking = threading.Thread(target=publish)
    talking.start()
    try:
        for _ in range(30):
            heard.clear()
            subscription = node.subscribe(Int32, "numbers", Handler(lambda message, _: heard.append(message.data)), 10)
            wait_for(lambda: len(heard) > 3)
            assert node.destroy_subscription(subscription)
    finally:
        stop.set()
        talking.join()


def test_subscriptions_without_guard_are_left_to_the_executor(node: ListeningNode) -> None:
    heard: list[int] = []
    publisher = node.create_publisher(Int32, "numbers", 10)
    subscription = node.create_subscription(Int32, "numbers", lambda message: heard.append(message.data), 10)
    wait_for(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Int32(data=3))
    time.sleep(0.2)
    assert heard == []
    executor = rclpy.executors.SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    wait_for(lambda: executor.spin_once(0.1) is None and heard == [3])
    executor.shutdown()
    assert node.destroy_subscription(subscription)


def test_a_message_that_is_too_large_is_not_read(node: ListeningNode) -> None:
    heard: list[int] = []
    unread: list[tuple[int, Unread]] = []
    callback = Handler(
        lambda message, _: heard.append(len(message.data)), lambda data, why: unread.append((len(data), why))
    )
    publisher = node.create_publisher(String, "texts", 10)
    node.subscribe(String, "texts", callback, 10)
    wait_for(lambda: publisher.get_subscription_count() == 1)
    for size in (MAX_BYTES - 100, MAX_BYTES + 100, 5):
        publisher.publish(String(data="x" * size))
    wait_for(lambda: len(heard) == 2)
    assert heard == [MAX_BYTES - 100, 5]
    ((size, why),) = unread
    assert size > MAX_BYTES
    assert why is Unread.TOO_LARGE


def test_messages_that_are_not_wanted_are_not_read(node: ListeningNode) -> None:
    heard: list[str] = []
    seen: list[tuple[bytes, bytes]] = []

    def wants(head: bytes, info: dict[str, Any]) -> bool:
        seen.append((head, info["publisher"]))
        return b"no" not in head

    publisher = node.create_publisher(String, "texts", 10)
    callback = Handler(lambda message, _: heard.append(message.data), wants=wants)
    node.subscribe(String, "texts", callback, 10)
    wait_for(lambda: publisher.get_subscription_count() == 1)
    for text in ("no", "yes", "no" * MAX_BYTES, "yes"):
        publisher.publish(String(data=text))
    wait_for(lambda: heard == ["yes", "yes"])
    assert [len(head) for head, _ in seen] == [11, 12, 32, 12]
    (info,) = node.get_publishers_info_by_topic("/texts")
    assert {gid for _, gid in seen} == {bytes(info.endpoint_gid)}


def test_large_messages_that_take_long_leave_most_of_the_time_to_others(node: ListeningNode) -> None:
    heard: list[int] = []
    unread: list[Unread] = []

    def hear(message: Any, _: dict[str, Any]) -> None:
        heard.append(len(message.data))
        until = time.thread_time() + 0.1
        while time.thread_time() < until:
            pass

    publisher = node.create_publisher(String, "texts", 10)
    node.subscribe(String, "texts", Handler(hear, lambda _, why: unread.append(why)), 10)
    wait_for(lambda: publisher.get_subscription_count() == 1)
    for size in (20_000, 20_000, 20_000, 5):
        publisher.publish(String(data="x" * size))
    wait_for(lambda: 5 in heard)
    assert heard == [20_000, 5]
    assert unread == [Unread.TOO_FAST] * 2


def test_bytes_that_are_no_message_harm_no_other(node: ListeningNode) -> None:
    heard: list[str] = []
    publisher = node.create_publisher(String, "texts", 10)
    node.subscribe(String, "texts", Handler(lambda message, _: heard.append(message.data)), 10)
    wait_for(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(b"\0\1\0\0\xff\xff\xff\xff")
    publisher.publish(String(data="hello"))
    wait_for(lambda: heard == ["hello"])


@pytest.fixture
def server(node: ListeningNode) -> Iterator[Any]:
    """A service on the same domain, spun by an executor of its own; it answers with the opposite."""

    def answer(request: Any, response: Any) -> Any:
        response.success, response.message = not request.data, "opposite"
        return response

    other = rclpy.create_node("server", context=node.context)
    service = other.create_service(SetBool, "opposite", answer)
    executor = rclpy.executors.SingleThreadedExecutor(context=node.context)
    executor.add_node(other)
    ended = threading.Event()

    def serve() -> None:
        while not ended.is_set():
            with suppress(SystemError):  # rclpy warns of a client that left before its answer, and pytest raises that
                executor.spin()

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    yield service
    ended.set()
    executor.shutdown()
    thread.join(5)
    other.destroy_node()


def test_answers_come_to_whom_they_are_for(node: ListeningNode, server: Any) -> None:
    client = node.create_client(SetBool, "opposite")
    wait_for(client.service_is_ready)
    futures = [client.call_async(SetBool.Request(data=number % 2 == 0)) for number in range(8)]
    wait_for(lambda: all(future.done() for future in futures))
    assert [future.result().success for future in futures] == [number % 2 == 1 for number in range(8)]
    assert node.destroy_client(client)


def test_an_answer_that_nobody_waits_for_harms_nobody(node: ListeningNode, server: Any) -> None:
    client = node.create_client(SetBool, "opposite")
    wait_for(client.service_is_ready)
    forgotten = client.call_async(SetBool.Request(data=True))
    client.remove_pending_request(forgotten)
    awaited = client.call_async(SetBool.Request(data=True))
    wait_for(awaited.done)
    assert not forgotten.done()


def test_clients_come_and_go_while_answers_do(node: ListeningNode, server: Any) -> None:
    for _ in range(20):
        client = node.create_client(SetBool, "opposite")
        wait_for(client.service_is_ready)
        futures: list[Any] = []

        def answered(futures: list[Any] = futures, client: Any = client) -> bool:
            futures.append(client.call_async(SetBool.Request(data=True)))  # the first may be lost to discovery
            return any(future.done() for future in futures)

        wait_for(answered)
        assert node.destroy_client(client)


def test_publishers_give_the_executor_nothing_to_look_at(node: ListeningNode) -> None:
    before = len(list(node.waitables))
    node.create_publisher(Int32, "numbers", 10)
    assert len(list(node.waitables)) == before


def test_a_second_answer_is_noticed(domain: int, node: ListeningNode, server: Any) -> None:
    client = node.create_client(SetBool, "opposite")
    wait_for(client.service_is_ready)
    future = client.call_async(SetBool.Request(data=True))
    wait_for(future.done)
    assert node.answers.answered_twice_at(client) < 0
    other = rclpy.create_node("another_server", context=node.context)
    other.create_service(SetBool, "opposite", lambda _, response: response)
    executor = rclpy.executors.SingleThreadedExecutor(context=node.context)
    executor.add_node(other)
    enough = threading.Event()

    def answer() -> None:
        while not enough.is_set():
            executor.spin_once(timeout_sec=0.1)

    thread = threading.Thread(target=answer, daemon=True)
    thread.start()

    def noticed() -> bool:
        client.call_async(SetBool.Request(data=True))
        return node.answers.answered_twice_at(client) > 0

    wait_for(noticed)
    enough.set()
    thread.join()
    executor.shutdown()
    other.destroy_node()
