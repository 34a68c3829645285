"""The node of the gateway: where its subscriptions, publishers and clients are made."""

from typing import Any

from rclpy.client import Client
from rclpy.context import Context
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from dock_gateway.core.errors import Conflict
from dock_gateway.core.own_topics import OwnTopics
from dock_gateway.ros.graph import read_topic
from dock_gateway.ros.listener import AnswerListener, Handler, MessageListener
from dock_gateway.ros.messages.types import type_name
from robot_io.endpoints import WithoutEvents
from robot_io.rclpy_private import NotForExecutors


class ListeningNode(WithoutEvents, Node):  # type: ignore[misc]
    """A node whose clients and subscriptions are served by listeners, and its services by the executor."""

    def __init__(
        self,
        name: str,
        namespace: str | None,
        context: Context,
        messages: MessageListener,
        answers: AnswerListener,
        *,
        own_topics: OwnTopics | None = None,
        **options: Any,
    ) -> None:
        self.answers = answers
        self._own_topics = own_topics
        self._messages = messages
        super().__init__(name, namespace=namespace, context=context, **options)

    def create_publisher(self, msg_type: Any, topic: str, *args: Any, **options: Any) -> Publisher:
        """Like rclpy's.

        Raises:
            Conflict: `topic_in_use`: it is a topic of the gateway, which has another type.
        """
        self._require_own_type(msg_type, topic)
        return super().create_publisher(msg_type, topic, *args, **options)

    def subscribe(
        self, kind: Any, topic: str, handler: Handler, quality: QoSProfile | int, *, raw: bool = False, **options: Any
    ) -> Subscription:
        """Subscribe to a topic: a listener takes its messages. The only way in which the gateway reads a topic.

        Args:
            kind: The class of its messages.
            topic: Absolute name, or one relative to the node.
            handler: Gets each message that is not too large.
            quality: The quality of service, or the number of messages that wait for the listener at most.
            raw: Whether the handler gets bytes (CDR), however many.
            options: Further options, as rclpy names them.

        Raises:
            Conflict: `topic_in_use`: it is a topic of the gateway, which has another type.
        """
        self._require_own_type(kind, topic)
        options["callback_group"] = NotForExecutors()
        subscription = self.create_subscription(kind, topic, handler, quality, raw=raw, **options)
        self._messages.add(subscription)
        return subscription

    def _require_own_type(self, msg_type: Any, topic: str) -> None:
        own = None if self._own_topics is None else self._own_topics.find(topic)
        if own is None or own.has(kind := type_name(msg_type)):
            return
        if own.fixed or kind not in read_topic(self, topic).types_but_of({self.get_fully_qualified_name()}):
            types = " or ".join(sorted(own.types))
            raise Conflict(f"the gateway uses {topic} as {types}, not as {kind}", code="topic_in_use")

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Like rclpy's, but removes it from its listener first."""
        self._messages.remove(subscription)
        return bool(super().destroy_subscription(subscription))

    def create_client(self, srv_type: Any, srv_name: str, **options: Any) -> Client:
        """Like rclpy's, but a listener takes the responses."""
        options["callback_group"] = NotForExecutors()
        client = super().create_client(srv_type, srv_name, **options)
        self.answers.add(client)
        return client

    def destroy_client(self, client: Client) -> bool:
        """Like rclpy's, but removes it from its listener first."""
        self.answers.remove(client)
        return bool(super().destroy_client(client))
