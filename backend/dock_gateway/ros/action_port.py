"""A client of one action that implements the action protocol itself.

rclpy's ActionClient sees only its own goals and decodes feedback for each. The protocol is three services and two
topics; subscribing to the topics shows every goal of the action, whoever sent it.
"""

import asyncio
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from action_msgs.srv import CancelGoal
from rclpy.client import Client
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import serialize_message
from rclpy.subscription import Subscription
from unique_identifier_msgs.msg import UUID

from dock_gateway.core.goal import FROM_ROS, GoalError, GoalStatus, Json
from dock_gateway.ros.bridge import Bridge, PendingCall, guard
from dock_gateway.ros.listener import Unread
from dock_gateway.ros.losses import Losses, OnLoss
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import load_action
from dock_gateway.ros.status import StatusReader, StatusReport, text_of

# Messages. At 3,000 Hz a depth of 10 lost messages on a busy machine; 1,000 lost none.
FEEDBACK_DEPTH = 1000
# Many goals may be sent and answered at the same time; ROS's default depth of 10 would lose some.
SERVICE_QOS = QoSProfile(depth=1000)


# Bytes before the goal id, the first field of a feedback message, and bytes of the id.
HEADER, ID_SIZE = 4, 16

OnStatus = Callable[[list[StatusReport], int], None]
OnFeedback = Callable[[str, Json, int], None]


@dataclass(frozen=True)
class CancelAnswer:
    """The response to a cancel request: the goals that the server will cancel, and its `return_code`."""

    goal_ids: frozenset[str]
    return_code: int


@dataclass(frozen=True)
class ResultAnswer:
    """The response to a result request; `status` is None if the server does not know the goal."""

    status: GoalStatus | None = None
    result: Json | None = None
    error: GoalError | None = None


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


class ActionKind:
    """An action type by its name, `package/action/Name`. The constructor imports the package, which is slow.

    Raises:
        ImportError: The package is not installed, or cannot be imported.
        TypeError: The type has fields that no .msg file can have.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.action = load_action(name)
        for part in (self.action.Goal, self.action.Result, self.action.Feedback):
            codec(part)


class ActionPort:
    """Sends goals, cancel requests and result requests to one action, and listens to all its goals.

    The constructor, `listen` and `close` are called on the ROS thread, all other methods on the loop.

    Args:
        bridge: The bridge to the ROS thread.
        action_name: Absolute name of the action.
        kind: Type of the action.
    """

    def __init__(self, bridge: Bridge, action_name: str, kind: ActionKind) -> None:
        self.action_name = action_name
        self.action_type = kind.name
        self.goal_codec = codec(kind.action.Goal)
        self._bridge = bridge
        self._subscriptions: list[Subscription] = []
        self._clients: list[Client] = []
        self._impl = kind.action.Impl
        self._result_codec = codec(kind.action.Result)
        self._feedback_codec = codec(kind.action.Feedback)
        # Sending serializes the request at once, so it can be reused: it is expensive to create.
        self._goal_request = self._impl.SendGoalService.Request()
        try:
            self._send = self._make_client(self._impl.SendGoalService, "send_goal")
            self._result = self._make_client(self._impl.GetResultService, "get_result")
            # Last: a server that has answered a ping has also matched the clients announced before.
            self._cancel = self._make_client(CancelGoal, "cancel_goal")
        except Exception:
            self.close()
            raise

    def _make_client(self, service: Any, name: str) -> Client:
        path = f"{self.action_name}/_action/{name}"
        client = self._bridge.node.create_client(service, path, qos_profile=SERVICE_QOS)
        self._clients.append(client)
        return client

    def listen(self, on_status: OnStatus, on_feedback: OnFeedback, on_loss: OnLoss) -> None:
        """Start listening to all goals.

        Args:
            on_status: Called on the loop with the changes in a status message and its source timestamp in ns.
            on_feedback: Called on the loop with a goal id, the feedback as JSON and the source timestamp in ns.
            on_loss: Called on the loop with a goal id, why its feedback was not read, and the number of messages.
        """
        node, overrides = self._bridge.node, QoSOverridingOptions.with_default_policies()
        losses, statuses = Losses(self._bridge, on_loss), StatusReader()
        inbox = self._bridge.inbox(lambda goal_id, *_: losses.count(goal_id, Unread.TOO_FAST))

        def hear_feedback(message: Any, info: dict[str, Any]) -> None:
            feedback = self._feedback_codec.encode(message.feedback)
            inbox.offer(len(feedback), on_feedback, to_text(message.goal_id), feedback, info["source_timestamp"])

        def refuse_feedback(message: bytes, why: Unread) -> None:
            losses.count(text_of(message[HEADER : HEADER + ID_SIZE]), why)

        def hear_status(message: bytes, info: dict[str, Any]) -> None:
            inbox.put(on_status, statuses.read(message), info["source_timestamp"])

        feedback = node.create_subscription(
            self._impl.FeedbackMessage,
            f"{self.action_name}/_action/feedback",
            guard(hear_feedback, refuse_feedback),
            QoSProfile(depth=FEEDBACK_DEPTH),
            qos_overriding_options=overrides,
        )
        self._subscriptions.append(feedback)
        status = node.create_subscription(
            self._impl.GoalStatusMessage,
            f"{self.action_name}/_action/status",
            guard(hear_status),
            qos_profile_action_status_default,
            qos_overriding_options=overrides,
            raw=True,
        )
        self._subscriptions.append(status)

    def close(self) -> None:
        """Leave the action."""
        for subscription in self._subscriptions:
            self._bridge.node.destroy_subscription(subscription)
        for client in self._clients:
            self._bridge.node.destroy_client(client)

    async def presence(self) -> "ServerPresence":
        """Return the servers of the action."""
        return await self._bridge.call(self._look)

    def _look(self) -> "ServerPresence":
        available, node = all(client.service_is_ready() for client in self._clients), self._bridge.node
        if node.count_services(f"{self.action_name}/_action/send_goal") < 2:
            return ServerPresence(available)
        infos = node.get_publishers_info_by_topic(f"{self.action_name}/_action/status")
        servers = frozenset(bytes(info.endpoint_gid).hex() for info in infos)
        return ServerPresence(available, servers, max(map(node.answers.answered_twice_at, self._clients)))

    def send(self, goal_id: str, goal: Any) -> PendingCall:
        """Send a goal; the response says whether it was accepted."""
        self._goal_request.goal_id, self._goal_request.goal = to_ros(goal_id), goal
        return self._bridge.request(self._send, self._goal_request)

    def request_result(self, goal_id: str) -> PendingCall:
        """Request a goal's `ResultAnswer`, sent when the goal has ended, or at once if it is unknown."""
        request = self._impl.GetResultService.Request(goal_id=to_ros(goal_id))
        return self._bridge.request(self._result, request, self._read_result)

    def _read_result(self, response: Any) -> "ResultAnswer":
        status = FROM_ROS.get(response.status)
        if status is None:
            return ResultAnswer()
        size, limit = len(serialize_message(response.result)), self._bridge.max_message_bytes
        if size > limit:
            detail = f"the result has {size} bytes; max_message_bytes is {limit}"
            return ResultAnswer(status, error=GoalError("result_too_large", detail))
        return ResultAnswer(status, self._result_codec.encode(response.result))

    def encode_goal(self, goal: Any) -> Json:
        """Encode a goal message as JSON."""
        return self.goal_codec.encode(goal)

    async def cancel(self, goal_id: str | None, timeout: float) -> CancelAnswer:
        """Ask the server to cancel a goal, or every goal if `goal_id` is None.

        Raises:
            TimeoutError: The server did not answer.
        """
        request = CancelGoal.Request()
        if goal_id is not None:
            request.goal_info.goal_id = to_ros(goal_id)
        pending = self._bridge.request(self._cancel, request, _read_cancel)
        try:
            async with asyncio.timeout(timeout):
                answer: CancelAnswer = await asyncio.shield(pending.response)
        finally:
            if not pending.response.done():
                pending.forget()
        return answer

    async def ping(self, timeout: float) -> bool:
        """Return whether the server answers a request to cancel a goal that does not exist."""
        try:
            await self.cancel(str(uuid.uuid4()), timeout)
        except TimeoutError:
            return False
        return True


def _read_cancel(response: Any) -> CancelAnswer:
    return CancelAnswer(frozenset(to_text(info.goal_id) for info in response.goals_canceling), response.return_code)


def to_ros(goal_id: str) -> UUID:
    """Convert a goal id to its ROS message."""
    return UUID(uuid=list(uuid.UUID(goal_id).bytes))


def to_text(goal_id: UUID) -> str:
    """Convert a goal id to its text form, as in JSON."""
    return text_of(goal_id.uuid.tobytes())
