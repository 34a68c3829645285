"""A ROS node in the test process that listens to topics, publishes, calls services, and sends goals."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from docking.ros.process import Spinner, ros_context
from robot_io.rclpy_private import goal_id_text
from tests.support.waiting import PATIENCE, wait_until

T = TypeVar("T")

EVERYTHING = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.VOLATILE)


class Recording:
    """What came on one topic, oldest first."""

    def __init__(self, observer: "Observer", topic: str) -> None:
        self.messages: list[Any] = []
        self._observer = observer
        self._topic = topic

    def wait_for(self, predicate: Callable[[Any], bool], since: int = 0, timeout: float = PATIENCE) -> Any:
        """The first message from index `since` on that fulfils the predicate."""
        found = wait_until(
            lambda: [message for message in self.messages[since:] if predicate(message)],
            f"the message awaited on {self._topic}, among {self.messages[-3:]}",
            timeout,
        )
        return found[0]

    def wait_for_publisher(self, timeout: float = PATIENCE) -> None:
        """Wait until someone publishes on the topic, so that nothing of what follows is missed."""
        node = self._observer.node
        wait_until(lambda: node.count_publishers(self._topic), f"a publisher of {self._topic}", timeout)


class GoalOfTest:
    """A goal sent by a test."""

    def __init__(self, observer: "Observer", client: ActionClient, goal: Any, timeout: float) -> None:
        self.feedback: list[Any] = []
        self._observer = observer
        sent = observer.call(lambda: client.send_goal_async(goal, self._receive_feedback))
        self.handle = observer.result_of(sent, "the answer to the goal", timeout)
        self.accepted: bool = self.handle.accepted
        self.goal_id = goal_id_text(self.handle.goal_id)
        self._result = observer.call(self.handle.get_result_async) if self.accepted else None

    def _receive_feedback(self, message: Any) -> None:
        self.feedback.append(message.feedback)

    def result(self, timeout: float = PATIENCE) -> Any:
        """Wait for the end: the response with `status` (action_msgs/GoalStatus) and `result`."""
        assert self._result is not None, "the goal was rejected"
        return self._observer.result_of(self._result, "the result", timeout)

    def cancel(self, timeout: float = PATIENCE) -> bool:
        """Ask for a cancel; whether the server goes along."""
        response = self._observer.call(self.handle.cancel_goal_async)
        return bool(self._observer.result_of(response, "the answer to the cancel", timeout).goals_canceling)

    @property
    def ended(self) -> bool:
        """Whether the result is there."""
        return self._result is not None and self._result.done()


class Observer:
    """A node of the test process in a ROS context of its own, spun in a thread of its own."""

    def __init__(self, node: Node, spinner: Spinner) -> None:
        self.node = node
        self._spinner = spinner
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, ActionClient] = {}
        self._services: dict[str, Any] = {}

    def call(self, function: Callable[[], T], timeout: float = PATIENCE) -> T:
        """Run a function in the thread that spins the node, and return what it returns."""
        return self._spinner.call(function).result(timeout)

    def result_of(self, future: Any, what: str, timeout: float = PATIENCE) -> Any:
        """Wait for an rclpy future."""
        wait_until(future.done, what, timeout)
        return future.result()

    def record(self, message_type: type, topic: str, qos: QoSProfile = EVERYTHING) -> Recording:
        """Subscribe, and collect what comes."""
        recording = Recording(self, topic)
        self.call(lambda: self.node.create_subscription(message_type, topic, recording.messages.append, qos))
        return recording

    def close(self) -> None:
        """Leave the ROS graph with the action clients, too, which a node does not destroy by itself."""
        for client in self._clients.values():
            client.destroy()

    def publish(self, message: Any, topic: str, qos: QoSProfile | int = 10) -> None:
        """Publish one message, once there is a subscriber."""
        publisher = self._publisher(message, topic, qos)
        wait_until(publisher.get_subscription_count, f"a subscriber of {topic}")
        self.call(lambda: publisher.publish(message))

    def _publisher(self, message: Any, topic: str, qos: QoSProfile | int = 10) -> Any:
        if topic not in self._publishers:
            self._publishers[topic] = self.call(lambda: self.node.create_publisher(type(message), topic, qos))
        return self._publishers[topic]

    @contextmanager
    def publishing(self, message: Any, topic: str, period: float = 0.1, *, heard: bool = True) -> Iterator[None]:
        """Publish a message again and again, from now to the end of the block.

        Args:
            message: The message.
            topic: Where to publish it.
            period: Between two messages, in s.
            heard: Whether to wait for a subscriber first.
        """
        publisher = self._publisher(message, topic)
        if heard:
            self.publish(message, topic)
        timer = self.call(lambda: self.node.create_timer(period, lambda: publisher.publish(message)))
        try:
            yield
        finally:
            self.call(lambda: self.node.destroy_timer(timer))

    def ask(self, service_type: type, name: str, request: Any) -> Any:
        """Call a service, once it is there; the future of its answer."""
        if name not in self._services:
            self._services[name] = self.call(lambda: self.node.create_client(service_type, name))
            wait_until(self._services[name].service_is_ready, f"the service {name}")
            time.sleep(0.3)  # until the server has found the client, too: else its answer may get lost
        return self.call(lambda: self._services[name].call_async(request))

    def request(self, service_type: type, name: str, request: Any, timeout: float = PATIENCE) -> Any:
        """Call a service, and wait for its answer."""
        return self.result_of(self.ask(service_type, name, request), f"the answer of {name}", timeout)

    def set_parameter(self, node: str, name: str, value: Any) -> str:
        """Set a parameter of another node; the reason why it was refused, empty where it was not."""
        request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        result = self.request(SetParameters, f"{node}/set_parameters", request).results[0]
        return "" if result.successful else result.reason or "refused"

    def send_goal(self, action_type: type, action_name: str, goal: Any, timeout: float = PATIENCE) -> GoalOfTest:
        """Send a goal, once a server is there, and wait until it is accepted or rejected."""
        if action_name not in self._clients:
            self._clients[action_name] = self.call(lambda: ActionClient(self.node, action_type, action_name))
            wait_until(self._clients[action_name].server_is_ready, f"an action server {action_name}", timeout)
            time.sleep(0.3)  # until the server has found the client, too
        return GoalOfTest(self, self._clients[action_name], goal, timeout)


@contextmanager
def ros_nodes(domain: int, *ros_args: str) -> Iterator[Context]:
    """A ROS context on a domain, on this machine only, for nodes in the test process.

    Args:
        domain: The ROS domain.
        ros_args: What would follow `--ros-args` on a command line.
    """
    with ros_context(["test", "--ros-args", *ros_args], domain_id=domain) as context:
        yield context


@contextmanager
def ros_observer(domain: int, name: str = "observer") -> Iterator[Observer]:
    """An Observer on a ROS domain."""
    with ros_nodes(domain) as context:
        node = Node(name, context=context, enable_rosout=False)
        with Spinner(context, [node]) as spinner:
            observer = Observer(node, spinner)
            try:
                yield observer
            finally:
                spinner.call(observer.close).result(PATIENCE)
