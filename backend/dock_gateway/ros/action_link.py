"""The clients and subscriptions of one action, on one DDS participant."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from action_msgs.srv import CancelGoal
from rclpy.client import Client
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.listener import Handler

# Messages. At 3,000 Hz a depth of 10 lost messages on a busy machine; 1,000 lost none.
FEEDBACK_DEPTH = 1000
# Many goals may be sent and answered at the same time; ROS's default depth of 10 would lose some.
SERVICE_QOS = QoSProfile(depth=1000)


@dataclass(frozen=True)
class ServerPresence:
    """The servers of an action.

    Attributes:
        available: Whether a server of all three services is on the graph.
        servers: Identifiers of the servers, alive or dead, if there are several.
        answered_twice_at: When two of them last answered the same request, on the monotonic clock.
    """

    available: bool
    servers: frozenset[str] = frozenset()
    answered_twice_at: float = float("-inf")


class ActionLink:
    """One way to reach an action server. The constructor and `listen` are called on the ROS thread of the bridge.

    Args:
        bridge: The bridge to the participant.
        action_name: Absolute name of the action.
        impl: The services and topics of its type.
        listen: Called with the link before its clients are made: a server that answers has then also matched the
            subscriptions.
    """

    def __init__(
        self, bridge: Bridge, action_name: str, impl: Any, listen: Callable[["ActionLink"], None] = lambda _: None
    ) -> None:
        self.bridge = bridge
        self._name = action_name
        self._impl = impl
        self._subscriptions: list[Subscription] = []
        self._clients: list[Client] = []
        try:
            listen(self)
            self.send = self._make_client(impl.SendGoalService, "send_goal")
            self.result = self._make_client(impl.GetResultService, "get_result")
            # Last: a server that has answered a ping has also matched the clients announced before.
            self.cancel = self._make_client(CancelGoal, "cancel_goal")
        except Exception:
            self.leave()
            raise

    def _make_client(self, service: Any, name: str) -> Client:
        client = self.bridge.node.create_client(service, f"{self._name}/_action/{name}", qos_profile=SERVICE_QOS)
        self._clients.append(client)
        return client

    def listen(self, on_feedback: Handler, on_status: Handler) -> None:
        """Handle each feedback message, and the bytes of each status message."""
        node, overrides = self.bridge.node, QoSOverridingOptions.with_default_policies()
        feedback = node.subscribe(
            self._impl.FeedbackMessage,
            f"{self._name}/_action/feedback",
            on_feedback,
            QoSProfile(depth=FEEDBACK_DEPTH),
            qos_overriding_options=overrides,
        )
        self._subscriptions.append(feedback)
        status = node.subscribe(
            self._impl.GoalStatusMessage,
            f"{self._name}/_action/status",
            on_status,
            qos_profile_action_status_default,
            qos_overriding_options=overrides,
            raw=True,
        )
        self._subscriptions.append(status)

    def leave(self) -> None:
        """Leave the action; call it on the ROS thread."""
        for subscription in self._subscriptions:
            self.bridge.node.destroy_subscription(subscription)
        for client in self._clients:
            self.bridge.node.destroy_client(client)

    def read_presence(self) -> ServerPresence:
        """Return the servers of the action; call it on the ROS thread."""
        available, node = all(client.service_is_ready() for client in self._clients), self.bridge.node
        if node.count_services(f"{self._name}/_action/send_goal") < 2:
            return ServerPresence(available)
        infos = node.get_publishers_info_by_topic(f"{self._name}/_action/status")
        servers = frozenset(bytes(info.endpoint_gid).hex() for info in infos)
        return ServerPresence(available, servers, max(map(node.answers.answered_twice_at, self._clients)))
