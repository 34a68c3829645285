"""A client of one action that implements the action protocol itself.

rclpy's ActionClient sees only its own goals and decodes feedback for each. The protocol is three services and two
topics; subscribing to the topics shows every goal of the action, of any sender.
"""

import asyncio
import time
import uuid
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from typing import Any

from action_msgs.srv import CancelGoal
from rclpy.client import Client
from rclpy.serialization import serialize_message
from unique_identifier_msgs.msg import UUID

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import FROM_ROS, GoalError, Json, ResultAnswer
from dock_gateway.ros.action_link import ActionLink, ServerPresence
from dock_gateway.ros.admission import NO_GOALS, KnownGoals
from dock_gateway.ros.bridge import Bridge, PendingCall
from dock_gateway.ros.goal_listener import GoalListener, OnFeedback, OnStatus
from dock_gateway.ros.losses import OnLoss
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import load_action
from dock_gateway.ros.status import text_of
from robot_io.rclpy_private import InvalidHandle

# Seconds that a server has for an answer when it is tried through another participant.
ANSWER_WITHIN = 1.0
# Seconds between two checks for that answer.
CHECK_INTERVAL = 0.1
# Seconds for the server to be found through the common participant.
HOME_WITHIN = 5.0

# The maximum number of unanswered requests to cancel single goals: an action server queues only 10 (ROS's default), and
# drops others, such as the request to cancel all goals.
CANCELS_AT_ONCE = 5


@dataclass(frozen=True)
class CancelAnswer:
    """The response to a cancel request: the goals that the server will cancel, and its `return_code`."""

    goal_ids: frozenset[str]
    return_code: int


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


class LeftError(Exception):
    """The link through which a request was sent has been replaced by another one."""


class ActionPort:
    """Sends goals, cancel requests and result requests to one action, and listens to all its goals.

    The constructor, `listen` and `close` are called on the ROS thread, all other methods on the loop.

    Args:
        bridge: The bridge to the ROS thread.
        action_name: Absolute name of the action.
        kind: Type of the action.

    Attributes:
        unanswered_since: When the server did not answer or could not be reached for the first time since its last
            answer, on the monotonic clock; None if it has answered. Requests for results are not counted, because
            they are answered when the goal ends.
        answered: Whether the server has ever answered.
        listener: Hears all its goals; None before `listen`.
    """

    def __init__(self, bridge: Bridge, action_name: str, kind: ActionKind) -> None:
        self.action_name = action_name
        self.action_type = kind.name
        self.goal_codec = codec(kind.action.Goal)
        self.unanswered_since: float | None = None
        self.answered = False
        self._bridge = bridge
        self._impl = kind.action.Impl
        self._result_codec = codec(kind.action.Result)
        self._feedback_codec = codec(kind.action.Feedback)
        # Sending serializes the request at once, so it can be reused: it is expensive to create.
        self._goal_request = self._impl.SendGoalService.Request()
        self._canceling: set[PendingCall] = set()
        self._cancels = asyncio.Semaphore(CANCELS_AT_ONCE)
        self.listener: GoalListener | None = None
        # It is kept while another link is used: creating and destroying it may block while robots are unreachable.
        self._home = self._link = ActionLink(bridge, action_name, self._impl)

    def listen(
        self, on_status: OnStatus, on_feedback: OnFeedback, on_loss: OnLoss, goals: KnownGoals = NO_GOALS
    ) -> None:
        """Start listening to all goals.

        Args:
            on_status: Called on the loop with the changes in a status message and its source timestamp in ns.
            on_feedback: Called on the loop with a goal id, the feedback as JSON and the source timestamp in ns.
            on_loss: Called on the loop with a goal id, why its feedback was not read, and the number of messages.
            goals: The goals that are known.
        """
        self.listener = GoalListener(
            self._bridge,
            self.action_name,
            self._feedback_codec,
            goals,
            on_status=on_status,
            on_feedback=on_feedback,
            on_loss=on_loss,
            uses=self._uses,
        )
        self.listener.listen(self._link)

    def _uses(self, link: ActionLink) -> bool:
        return link is self._link

    def _listen(self, link: ActionLink) -> None:
        if self.listener is not None:
            self.listener.listen(link)

    def close(self) -> None:
        """Leave the action."""
        self._home.leave()
        if self.away:
            self._bridge.to_loop(self._leave, self._link)

    # ------------------------------------------------------------------ another participant

    @property
    def away(self) -> bool:
        """Whether the action is reached through a DDS participant of its own."""
        return self._link is not self._home

    async def rejoin(self, keep: float) -> bool:
        """Reach the server through another DDS participant if it answers there and not here; return whether it is.

        The other participant is a new one, or the common one if the action is reached through one of its own.

        Args:
            keep: Seconds to wait for an answer.

        Raises:
            Unavailable: The ROS thread is down or too slow.
        """
        if self.away:
            return await self._try(self._home, keep, unless_answered=True)
        since = time.monotonic() if self.unanswered_since is None else self.unanswered_since
        bridge = await self._bridge.branch(since)
        try:
            link = await bridge.call(
                lambda: ActionLink(bridge, self.action_name, self._impl, self._listen), undo=ActionLink.leave
            )
        except BaseException:
            self._bridge.release(bridge)
            raise
        try:
            return await self._try(link, keep, unless_answered=True)
        finally:
            if link is not self._link:
                self._leave(link)

    async def go_home(self) -> bool:
        """Reach the server through the common DDS participant again if it answers there; return whether it is."""
        return await self._try(self._home, HOME_WITHIN, unless_answered=False)

    async def _try(self, link: ActionLink, keep: float, *, unless_answered: bool) -> bool:
        """Use another link from now on if the server answers there within `keep` seconds."""
        if not await self._wait_for(link, time.monotonic() + keep, unless_answered=unless_answered):
            return False
        old, self._link = self._link, link
        if old is not self._home:
            self._leave(old)
        self._answered()
        for pending in list(self._canceling):  # they are sent again
            pending.fail(LeftError())
        return True

    def _leave(self, link: ActionLink) -> None:
        link.bridge.to_ros(link.leave)
        self._bridge.release(link.bridge)

    async def _wait_for(self, link: ActionLink, deadline: float, *, unless_answered: bool) -> bool:
        """Wait until the server answers through another link; return False if `unless_answered` and it answers here."""
        while time.monotonic() < deadline:
            if (await link.bridge.call(link.read_presence)).available and await self._ping(link, ANSWER_WITHIN):
                return not (unless_answered and await self._ping(self._link, ANSWER_WITHIN))
            if unless_answered and self.unanswered_since is None:
                return False
            await asyncio.sleep(CHECK_INTERVAL)
        return False

    # ------------------------------------------------------------------ requests

    async def presence(self) -> ServerPresence:
        """Return the servers of the action.

        Raises:
            Unavailable: The gateway has left the action, or the ROS thread is down (`ros_unavailable`).
        """
        while True:
            link = self._link
            try:
                presence = await link.bridge.call(link.read_presence)
            except Exception as error:
                if link is not self._link:
                    continue  # it was replaced while it answered
                if isinstance(error, InvalidHandle):
                    raise Unavailable("the action has left the ROS graph") from None
                raise
            if not presence.available:
                self._ask()
            return presence

    def _ask(self) -> None:
        if self.unanswered_since is None:
            self.unanswered_since = time.monotonic()

    def _answered(self) -> None:
        self.unanswered_since, self.answered = None, True

    def send(self, goal_id: str, goal: Any) -> PendingCall:
        """Send a goal; the response says whether it was accepted."""
        self._goal_request.goal_id, self._goal_request.goal = to_ros(goal_id), goal
        self._ask()
        return self._request(self._link, self._link.send, self._goal_request)

    def request_result(self, goal_id: str) -> PendingCall:
        """Request a goal's `ResultAnswer`, sent when the goal has ended, or at once if it is unknown."""
        request = self._impl.GetResultService.Request(goal_id=to_ros(goal_id))
        return self._request(self._link, self._link.result, request, self._read_result)

    def _request(
        self, link: ActionLink, client: Client, request: Any, read: Callable[[Any], Any] = lambda answer: answer
    ) -> PendingCall:
        """Send a request; its answer is a sign that the present link works."""

        def read_answer(response: Any) -> Any:
            if link is self._link:
                self._answered()
            return read(response)

        return link.bridge.request(client, request, read_answer)

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
        async with asyncio.timeout(timeout), self._cancels if goal_id is not None else nullcontext():
            while True:
                with suppress(LeftError):
                    return await self._cancel(self._link, goal_id)

    async def _cancel(self, link: ActionLink, goal_id: str | None) -> CancelAnswer:
        request = CancelGoal.Request()
        if goal_id is not None:
            request.goal_info.goal_id = to_ros(goal_id)
        if link is self._link:
            self._ask()
        pending = self._request(link, link.cancel, request, _read_cancel)
        self._canceling.add(pending)
        try:
            answer: CancelAnswer = await asyncio.shield(pending.response)
        finally:
            self._canceling.discard(pending)
            if not pending.response.done():
                pending.forget()
        return answer

    async def ping(self, timeout: float) -> bool:
        """Return whether the server answers a request to cancel a goal that does not exist."""
        return await self._ping(self._link, timeout)

    async def _ping(self, link: ActionLink, timeout: float) -> bool:
        try:
            async with asyncio.timeout(timeout):
                await self._cancel(link, str(uuid.uuid4()))
        except (TimeoutError, LeftError, Unavailable):
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
