"""Results of goals: each is requested, then awaited until it arrives or a timeout expires.

The answer says how a goal ended, regardless of its sender. It is combined with data from other sources: when the goal
ended, from the status topic, and why it was aborted.
"""

import asyncio
import logging
import time
from typing import Protocol

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import NO_RESULT, Goal, GoalError, GoalStatus, Json
from dock_gateway.core.tasks import PendingFacts, Tasks
from dock_gateway.ros.action_port import ActionPort, ResultAnswer
from dock_gateway.ros.bridge import PendingCall

log = logging.getLogger(__name__)

# Seconds that an ended goal (by the status topic) waits for its result, and seconds between two requests for it.
RESULT_WAIT, ASK_AGAIN_AFTER = 4.0, 0.5
# Seconds after such an end for which a late result is still accepted.
LATE_RESULT = 60.0
# Seconds that a result waits for the status message of the end, whose timestamp is the same at every gateway.
END_STAMP_WAIT = 0.2
SAID_NOTHING = "the action server aborted the goal and did not say why"
# Goals that end in one of these states have a result, which may arrive late.
WITH_RESULT = frozenset({GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED})


class Goals(Protocol):
    """The owner of the goals, which applies the answers to them."""

    def heard(self) -> None:
        """The action server gave a sign of life."""

    def lose(self, goal: Goal, error: GoalError) -> None:
        """Mark a goal that the action server does not know as lost."""

    def end(
        self,
        goal: Goal,
        status: GoalStatus,
        *,
        result: Json | None = None,
        error: GoalError | None = None,
        stamp_ns: int | None = None,
    ) -> None:
        """End the goal for good; `stamp_ns` is when the server reported it, in nanoseconds since 1970."""


class Results:
    """Requests the results of the goals on one action, and waits for them.

    Args:
        port: The action.
        goals: The owner of the goals.
        reasons: Why goals were aborted.
    """

    def __init__(self, port: ActionPort, goals: Goals, reasons: PendingFacts[GoalError]) -> None:
        self._port = port
        self._goals = goals
        self._reasons = reasons
        self._end_stamps: PendingFacts[int] = PendingFacts(END_STAMP_WAIT)
        self._calls: dict[str, PendingCall] = {}
        self._tasks = Tasks("waiting for results")
        self._closed = False

    # ------------------------------------------------------------------ asking

    def request(self, goal: Goal) -> None:
        """Request the goal's result, unless a request is pending."""
        if goal.goal_id not in self._calls:
            self.request_again(goal)

    def request_again(self, goal: Goal) -> None:
        """Request the result again: the server may have restarted and lost the first request."""
        if self._closed:
            return
        try:
            call = self._port.request_result(goal.goal_id)
        except Unavailable:
            return  # requested again when the server is back
        self.forget(goal.goal_id)
        self._calls[goal.goal_id] = call
        self._tasks.spawn(self._await_answer(goal, call))

    # ------------------------------------------------------------------ waiting

    async def _await_answer(self, goal: Goal, call: PendingCall) -> None:
        try:
            await self._take_answer(goal, await call.response)
        finally:  # only now: a status message that arrives meanwhile would trigger another request
            if self._calls.get(goal.goal_id) is call:
                del self._calls[goal.goal_id]

    async def _take_answer(self, goal: Goal, answer: ResultAnswer) -> None:
        self._goals.heard()
        if answer.status is None:
            if not goal.status.terminal:
                self._goals.lose(goal, GoalError("action_server_lost", "the action server does not know the goal"))
            return
        if not answer.status.terminal:
            log.warning("goal %s: the action server gave a result and says %s", goal.goal_id, answer.status.value)
            return
        stamp_ns = await self._end_stamps.of(goal.goal_id)
        error = answer.error
        if answer.status is GoalStatus.ABORTED:
            error = await self._reasons.of(goal.goal_id) or error or GoalError("goal_aborted", SAID_NOTHING)
        self._goals.end(goal, answer.status, result=answer.result, error=error, stamp_ns=stamp_ns)

    def expect(self, goal: Goal, status: GoalStatus, stamp_ns: int) -> None:
        """Note that the server reported the goal's end. Without a result, the goal ends after `RESULT_WAIT` seconds."""
        if goal.goal_id not in self._end_stamps:
            self._end_stamps.put(goal.goal_id, stamp_ns)
            self._tasks.spawn(self._end_without_result(goal, status))

    async def _end_without_result(self, goal: Goal, status: GoalStatus) -> None:
        deadline = time.monotonic() + RESULT_WAIT
        while not goal.status.final and time.monotonic() < deadline:
            await asyncio.sleep(ASK_AGAIN_AFTER)
            # An answer is lost if the server has not discovered our client yet, as just after a start.
            if not goal.status.final:
                self.request_again(goal)
        if not goal.status.final:
            error = GoalError(NO_RESULT, "the goal ended and the action server did not give its result")
            self._goals.end(goal, status, error=error, stamp_ns=await self._end_stamps.of(goal.goal_id))

    # ------------------------------------------------------------------ the end

    def retire(self, goal: Goal) -> None:
        """Stop waiting for the result of an ended or lost goal; if it may still arrive, after `LATE_RESULT` seconds."""
        if goal.result is not None or goal.status not in WITH_RESULT:
            self.forget(goal.goal_id)
        elif goal.goal_id in self._calls:
            asyncio.get_running_loop().call_later(LATE_RESULT, self.forget, goal.goal_id)

    def forget(self, goal_id: str) -> None:
        """Stop waiting for the goal's result."""
        if (call := self._calls.pop(goal_id, None)) is not None:
            call.forget()

    async def close(self) -> None:
        """Stop requesting and waiting for results."""
        self._closed = True
        for call in list(self._calls.values()):
            call.forget()
        await self._tasks.close()
