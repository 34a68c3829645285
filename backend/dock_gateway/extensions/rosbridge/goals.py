"""The goals that one client has sent: goals of the gateway, whose events the client gets as rosbridge sends them."""

import asyncio
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any

import orjson

from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, TooManyRequests
from dock_gateway.core.event import Event
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import GoalStatus
from dock_gateway.extensions.rosbridge.protocol import Identity, SendActionGoal, action_feedback, action_result
from dock_gateway.extensions.rosbridge.values import adapter
from dock_gateway.ros.messages.interfaces import load_action

MAX_GOALS = 100
# Events that are kept while a goal is sent, as its id is not known yet.
MAX_HELD = 1000


@dataclass(frozen=True, eq=False)
class GoalsOfClient(EventFilter):
    """The events of the goals that a client has sent.

    Attributes:
        goal_ids: The goals.
        sending: The actions to which goals are being sent, whose ids are not known yet.
    """

    goal_ids: set[str] = field(default_factory=set)
    sending: Counter[str] = field(default_factory=Counter)

    def covers(self, event: Event) -> bool:
        """Return whether the filter covers an event."""
        if event.topic != "goals":
            return False
        return event.goal_id in self.goal_ids or self.sending[event.action_name or ""] > 0


@dataclass(frozen=True)
class SentGoal:
    """A goal that a client has sent.

    Attributes:
        goal_id: Its id at the gateway.
        action: Its action, as the client calls it.
        identity: Its id at the client.
        action_type: Its type.
        feedback: Whether the client wants feedback.
        fragment_size: Maximum number of characters of a message to the client.
    """

    goal_id: str
    action: str
    identity: Identity
    action_type: str
    feedback: bool
    fragment_size: int | None

    def message(self, event: dict[str, Any]) -> bytes | None:
        """Return what the client is sent for an event of the goal."""
        match event["type"]:
            case "feedback" if self.feedback:
                return action_feedback(self.action, self.identity, self._adapted("Feedback", event["feedback"]))
            case "result":
                result = self._adapted("Result", event["result"])
                return self._end(GoalStatus(event["status"]), result, event["error"])
            case "status" if event["status"] == GoalStatus.LOST:
                return self._end(GoalStatus.LOST, None, event["error"])
        return None

    def _end(self, status: GoalStatus, result: Any, error: dict[str, str] | None) -> bytes:
        reason = "the goal ended without a result" if error is None else error["detail"]
        return action_result(self.action, self.identity, status, result, reason)

    def _adapted(self, part: str, message: Any) -> Any:
        adapt = adapter(getattr(load_action(self.action_type), part))
        return message if adapt is None or message is None else adapt(message)


class ClientGoals:
    """The goals of one client, until each has ended. They go on if the client disconnects.

    Args:
        send: Sends a message to the client.

    Attributes:
        event_filter: The events that `on_event` needs.
    """

    def __init__(self, send: Callable[[bytes, int | None], Awaitable[None]]) -> None:
        self.event_filter = GoalsOfClient()
        self._send = send
        self._goals: dict[str, SentGoal] = {}
        self._known: dict[Any, asyncio.Future[str]] = {}  # ids at the gateway, by those of the client
        self._held: list[Event] = []
        self._passing = asyncio.Lock()

    async def submit(
        self,
        request: SendActionGoal,
        identity: Identity,
        action_name: str,
        submit: Callable[[], Awaitable[dict[str, Any]]],
    ) -> str:
        """Send a goal, and pass its events on to the client. Return its type.

        Args:
            request: The operation.
            identity: Its id.
            action_name: Absolute name of the action.
            submit: Sends it, and returns its document.

        Raises:
            GatewayError: It was not accepted, the client has too many goals, or another one with this id.
        """
        if len(self._known) >= MAX_GOALS:
            raise TooManyRequests(f"this connection already has {MAX_GOALS} goals")
        if identity is not None and identity in self._known:
            raise InvalidField([FieldError("id", "an id of its own for each goal", "got that of a goal which runs")])
        key = object() if identity is None else identity
        known = self._known[key] = asyncio.get_running_loop().create_future()
        sending = self.event_filter.sending
        sending[action_name] += 1
        try:
            goal = await submit()
            async with self._passing:
                sent = SentGoal(
                    goal["goal_id"],
                    request.action,
                    identity,
                    goal["action_type"],
                    request.feedback,
                    request.fragment_size,
                )
                self._goals[sent.goal_id] = sent
                self.event_filter.goal_ids.add(sent.goal_id)
                known.set_result(sent.goal_id)
                for event in self._held:
                    await self._pass_on(event)
            return sent.action_type
        finally:
            if not known.done():
                known.cancel()
                self._known.pop(key, None)
            sending[action_name] -= 1
            if not sending.total():
                self._held.clear()

    async def goal_id(self, identity: Identity) -> str:
        """Return the id of a goal at the gateway; wait for it, if the goal is being sent.

        Raises:
            InvalidField: The client has no such goal.
        """
        known = self._known.get(identity)
        if known is None or identity is None:
            raise InvalidField([FieldError("id", "the id of a goal of this connection that has not ended", "got none")])
        try:
            return await asyncio.shield(known)
        except asyncio.CancelledError:
            if not known.cancelled():
                raise
            raise InvalidField([FieldError("id", "a goal that was accepted", "got one that was not")]) from None

    async def on_events(self, events: list[Event]) -> None:
        """Pass events on to the client."""
        async with self._passing:
            for event in events:
                if event.goal_id in self._goals:
                    await self._pass_on(event)
                elif len(self._held) < MAX_HELD and self.event_filter.sending.total():
                    self._held.append(event)

    async def _pass_on(self, event: Event) -> None:
        goal = self._goals.get(event.goal_id or "")
        if goal is None:
            return
        message = goal.message(orjson.loads(event.data))
        if event.ends_goal:
            self._forget(goal)
        if message is not None:
            await self._send(message, goal.fragment_size)

    def _forget(self, goal: SentGoal) -> None:
        self._goals.pop(goal.goal_id, None)
        self.event_filter.goal_ids.discard(goal.goal_id)
        self._known = {
            identity: known
            for identity, known in self._known.items()
            if not (known.done() and not known.cancelled() and known.result() == goal.goal_id)
        }

    @property
    def running(self) -> list[asyncio.Future[str]]:
        """The goals that have not ended, by their ids at the gateway; those that are being sent have none yet."""
        return list(self._known.values())


def failure(request: SendActionGoal, identity: Identity, error: GatewayError) -> bytes:
    """Return the end of a goal that was not accepted."""
    return action_result(request.action, identity, GoalStatus.REJECTED, None, error.detail)
