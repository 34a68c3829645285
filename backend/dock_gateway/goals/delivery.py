"""Delivers a goal to the action server: stores it, sends it, takes the answer. Enforces the deadlines."""

import asyncio
import time
import uuid
from collections.abc import Awaitable, Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import Conflict, GatewayError, ServerTimeout, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalError, GoalStatus, Origin
from dock_gateway.core.request import act, slot
from dock_gateway.goals.action_context import ActionContext
from dock_gateway.goals.cancellation import TOO_LATE, Canceler
from dock_gateway.goals.goal_machine import GoalChange, GoalMachine
from dock_gateway.goals.liveness import ServerWatch
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.ros.bridge import PendingCall

# Rejection codes that are passed on from an action server; any other becomes `goal_rejected`.
KNOWN_REJECTIONS = ("dock_busy", "stop_latched")
# Seconds within which a server that has accepted a goal reports it, when it refuses the same goal sent again.
SEEN_WITHIN = 1.0
STOPPED_ON_ITS_WAY = "the goal was not sent, as a stop was requested first"


@dataclass(frozen=True)
class KeyClaim:
    """An idempotency key. `take` claims it for a goal; if another goal has it already, it returns that one."""

    key: str
    take: Callable[[Goal], Awaitable[Goal | None]]


class GoalDelivery:
    """Delivers the goals of one action.

    Args:
        context: The parts of the gateway that it uses.
        tracker: The goals of the action.
        watch: Whether it has a server.
        canceler: Cancels goals that a stop has overtaken.

    Attributes:
        stops: Number of stops requested.
        unanswered: The requests of goals that were given up, by the goals' ids.
    """

    def __init__(self, context: ActionContext, tracker: GoalTracker, watch: ServerWatch, canceler: Canceler) -> None:
        self._context = context
        self._tracker = tracker
        self._watch = watch
        self._canceler = canceler
        self.stops = 0
        self.unanswered: dict[str, PendingCall] = {}
        tracker.on[GoalChange.RETIRED].append(self._forget)
        self._tasks: set[asyncio.Task[Goal]] = set()

    def stop(self) -> None:
        """Prevent goals that have not been sent yet from being sent, and those on their way from running."""
        self.stops += 1
        self._canceler.stop()

    def require_no_stop_since(self, stops: int, **extra: Any) -> None:
        """Refuse a goal that was requested before a stop.

        Args:
            stops: The value of `stops` when it was requested.
            extra: Of the error.

        Raises:
            Conflict: `stopped`.
        """
        if self.stops != stops or self._context.interlock.holds(self._tracker.port.action_name):
            raise Conflict(STOPPED_ON_ITS_WAY, code="stopped", **extra)

    def start(
        self,
        message: Any,
        claim: KeyClaim | None = None,
        stops: int | None = None,
        again: Goal | None = None,
        *,
        sender: Principal | None,
    ) -> "asyncio.Task[Goal]":
        """Deliver a goal in its own task, which continues if the client disconnects.

        Args:
            message: The goal as a ROS message.
            claim: Its idempotency key, if it has one.
            stops: The value of `stops` when the goal was requested; default: the current one.
            again: The goal itself, if it was stored before and never accepted. It keeps its id, which an action server
                accepts only once.
            sender: Who sends it; None: the gateway itself, for a rule of automatic docking or a mission.

        Raises:
            Conflict: A stop is latched (`stop_latched`). The task raises it too, also if a stop was requested in the
                meantime (`stopped`) or the server rejected the goal (`goal_rejected`, `dock_busy`).
            NotAuthenticated: Raised by the task: the sender's login has ended (`invalid_token`).
            NotAllowed: Raised by the task: `before_send` refuses it (`approval_refused`, `approval_expired`).
            DockOccupied: Raised by the task: a gate refuses it. Gates may have reasons of their own, too.
            Unavailable: There is no action server that answers; raised by the task, too.
            ServerTimeout: Raised by the task: the server did not answer in time. If it accepts the goal later, the goal
                is canceled at once.
            TooManyRequests: Too many goals of the user wait for an answer, or of all users together.
        """
        action_name = self._tracker.port.action_name
        self._context.interlock.require_released(action_name)
        stops = self.stops if stops is None else stops
        place = ExitStack()
        place.enter_context(slot("goals", per=action_name))
        task = asyncio.create_task(self._deliver(message, claim, stops, again, sender))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        task.add_done_callback(lambda _: place.close())
        return task

    # ------------------------------------------------------------------ sending

    async def _deliver(
        self, message: Any, claim: KeyClaim | None, stops: int, again: Goal | None, sender: Principal | None
    ) -> Goal:
        """Store a goal, then send it: if this process dies, a running goal is still known to be ours."""
        port = self._tracker.port
        await self._watch.require()
        self._act(sender)  # also right before it is sent; but then a goal that was refused is stored
        if sender is not None:
            for wait in self._context.before_send:
                await wait(sender, port.action_name, port.encode_goal(message))
        origin: Origin = "automation" if sender is None else "gateway"
        made = str(uuid.uuid4())
        goal = again or self._tracker.new_goal(made, utc_now(), origin)
        if again is None:
            goal.goal = port.encode_goal(message)
            if claim is not None and (first := await claim.take(goal)):
                return first
            message = await self._pass_gates(goal, message, claim, sender)
            await self._context.history.add(goal, claim.key if claim else None)
        else:
            message = await self._pass_gates(goal, message, None, sender)
            self._canceler.allow(goal)
        self._tracker.apply(GoalMachine.add, goal)
        try:
            self.require_no_stop_since(stops, goal_id=goal.goal_id)
            self._act(sender)
            call = port.send(goal.goal_id, message)
        except GatewayError as error:
            self._tracker.apply(GoalMachine.end, goal, GoalStatus.REJECTED, error=GoalError(error.code, error.detail))
            raise
        return outcome(goal, running=await self._take_answer(goal, call, may_run=goal.goal_id != made))

    async def _pass_gates(self, goal: Goal, message: Any, claim: KeyClaim | None, sender: Principal | None) -> Any:
        """Return the message of a goal that may be sent. The key of one that may not is free again.

        Raises:
            GatewayError: It may not.
        """
        port = self._tracker.port
        try:
            for gate in self._context.gates:
                if (fields := await gate(sender, goal)) is not None:
                    message = port.goal_codec.parse(fields)
                    goal.goal = port.encode_goal(message)
        except GatewayError:
            if claim is not None:
                with suppress(Unavailable):
                    await self._context.history.release(claim.key, goal.goal_id)
            raise
        return message

    @staticmethod
    def _act(sender: Principal | None) -> None:
        """Check the login of who sends a goal; what the gateway does by itself needs none."""
        if sender is not None:
            act()

    # ------------------------------------------------------------------ the answer

    async def _take_answer(self, goal: Goal, call: PendingCall, *, may_run: bool) -> str | None:
        """Take the answer; return the goal that was running, if it was rejected because of one.

        Args:
            goal: The goal.
            call: Its request.
            may_run: Whether it may have been sent before, here or by another gateway.
        """
        try:
            async with asyncio.timeout(self._context.settings.accept_timeout):
                response = await asyncio.shield(call.response)
        except TimeoutError:
            self._give_up(goal, call)
            return None
        self._tracker.heard()
        if response.accepted:
            self._accept(goal, response)
            # A gateway that is killed after its answer then knows that the goal runs.
            await self._context.history.seal(goal, [])
            return None
        if may_run:
            await self._wait_until_seen(goal)
        return await self._reject(goal)

    def _accept(self, goal: Goal, response: Any) -> None:
        self._tracker.apply(GoalMachine.accept, goal, response.stamp.sec * 1_000_000_000 + response.stamp.nanosec)

    async def _wait_until_seen(self, goal: Goal) -> None:
        """Wait until the server reports a goal, which it refuses if it has accepted it before; a moment at most."""
        deadline = time.monotonic() + SEEN_WITHIN
        while goal.status is GoalStatus.PENDING and time.monotonic() < deadline:  # noqa: ASYNC110 - there is no event
            await asyncio.sleep(0.02)

    async def _reject(self, goal: Goal) -> str | None:
        busy_with = self._busy_with()
        reason = await self._context.reasons.wait_for(goal.goal_id)
        if reason is not None:
            code = reason.code if reason.code in KNOWN_REJECTIONS else "goal_rejected"
            error = GoalError(code, reason.detail)
        elif busy_with is not None:
            error = GoalError("dock_busy", f"goal {busy_with} is running; cancel it first")
        else:
            error = GoalError("goal_rejected", "the action server rejected the goal and gave no reason")
        if goal.status is not GoalStatus.PENDING:
            return None  # it runs: the server refused the same id sent again
        self._tracker.apply(GoalMachine.end, goal, GoalStatus.REJECTED, error=error)
        return busy_with if error.code == "dock_busy" else None

    def _busy_with(self) -> str | None:
        running = (goal for goal in self._tracker.running() if goal.status is not GoalStatus.PENDING)
        return next((goal.goal_id for goal in running), None)

    def _give_up(self, goal: Goal, call: PendingCall) -> None:
        if goal.status is not GoalStatus.PENDING:  # other messages reported that it runs, or how it ended
            call.forget()
            return
        self._canceler.mark_unwanted(goal, TOO_LATE)
        self.unanswered[goal.goal_id] = call
        detail = (
            f"the action server did not accept or reject the goal within {self._context.settings.accept_timeout:g} s"
        )
        self._tracker.lose(goal, GoalError("action_server_timeout", detail))

        def answered(response: "asyncio.Future[Any]") -> None:
            self.unanswered.pop(goal.goal_id, None)
            if response.cancelled() or response.exception():
                return
            self._tracker.heard()
            if response.result().accepted:
                self._accept(goal, response.result())
            elif goal.status is GoalStatus.LOST:  # else it runs: the server refused the same id sent again
                self._tracker.apply(GoalMachine.end, goal, GoalStatus.REJECTED, error=goal.error)

        call.response.add_done_callback(answered)

    def _forget(self, goal: Goal) -> None:
        """Stop waiting for the answer to a goal that was given up."""
        if (call := self.unanswered.pop(goal.goal_id, None)) is not None:
            call.forget()


# The error for the sender of a goal that did not start, by the code of the goal's error.
_REFUSALS: dict[str, type[GatewayError]] = {
    "action_server_unavailable": Unavailable,
    "ros_unavailable": Unavailable,
    "action_server_timeout": ServerTimeout,
}


def outcome(goal: Goal, *, running: str | None = None) -> Goal:
    """Return the goal, or raise the error for its sender: the same one for each retry with the same key.

    Args:
        goal: The goal.
        running: The goal because of which it was rejected, if that is known.

    Raises:
        Conflict: The goal was rejected.
        Unavailable: It could not be sent.
        ServerTimeout: It was not answered.
    """
    error = goal.error
    if error is not None and goal.unconfirmed:
        raise Unavailable(error.detail, code=error.code, goal_id=goal.goal_id)
    gave_up = error is not None and goal.status is GoalStatus.LOST and error.code == ServerTimeout.code
    if error is None or not (goal.status is GoalStatus.REJECTED or gave_up):
        return goal
    refusal = _REFUSALS.get(error.code, Conflict)
    busy: dict[str, Any] = {} if running is None else {"running_goal_id": running}
    raise refusal(error.detail, code=error.code, goal_id=goal.goal_id, **busy)
