"""Results of goals: each is requested, then awaited until it arrives or a timeout expires.

The answer says how a goal ended, regardless of its sender. It is combined with data from other sources: when the goal
ended, from the status topic, and why it was aborted.
"""

import asyncio
import time
from collections.abc import Callable
from dataclasses import replace

from dock_gateway.core.dock_adapters.adapter import NO_REASON
from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import NO_RESULT, Goal, GoalError, GoalStatus, ResultAnswer
from dock_gateway.core.tasks import PendingFacts, Tasks
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.ros.action_port import ActionPort
from dock_gateway.ros.bridge import PendingCall

SAID_NOTHING = "the action server aborted the goal and gave no reason"
# Goals that end in one of these states have a result, which may arrive late.
WITH_RESULT = frozenset({GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED})


# Takes a goal, how it ended, and when the server reported that, in nanoseconds since 1970, if it did.
Settle = Callable[[Goal, ResultAnswer, int | None], None]


class Results:
    """Requests the results of the goals on one action, and waits for them.

    Args:
        port: The action.
        reasons: Why goals were aborted.
        heard: Called with each sign of life of the action server.
        settle: Called with each answer, and if none comes for a goal that ended.
        remark: Returns what is wrong around the robot; it is added to the reason of goals that are aborted.
        limits: How long to wait.
    """

    def __init__(
        self,
        port: ActionPort,
        reasons: PendingFacts[GoalError],
        heard: Callable[[], None],
        settle: Settle,
        remark: Callable[[], str] = str,
        *,
        limits: GoalLimits = LIMITS,
    ) -> None:
        self._port = port
        self._reasons = reasons
        self._heard = heard
        self._settle = settle
        self._remark = remark
        self._limits = limits
        self._end_stamps: PendingFacts[int] = PendingFacts(limits.end_stamp_wait, limits.end_stamps)
        self._calls: dict[str, PendingCall] = {}
        self._tasks = Tasks("waiting for results")
        self._closed = False

    # ------------------------------------------------------------------ asking

    def request(self, goal: Goal, reported: tuple[GoalStatus, int] | None = None) -> None:
        """Request the goal's result, unless a request is pending.

        If the server reported how and when the goal ended, it ends without a result after a while.
        """
        if reported is not None and goal.goal_id not in self._end_stamps:
            self._end_stamps.put(goal.goal_id, reported[1])
            self._tasks.spawn(self._end_without_result(goal, reported[0]))
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
        finally:  # only now: a status message that arrives before would trigger another request
            if self._calls.get(goal.goal_id) is call:
                del self._calls[goal.goal_id]

    async def _take_answer(self, goal: Goal, answer: ResultAnswer) -> None:
        self._heard()
        stamp_ns = None
        if answer.status is not None and answer.status.terminal:
            stamp_ns = await self._end_stamps.wait_for(goal.goal_id)
        if answer.status is GoalStatus.ABORTED:
            error = await self._reasons.wait_for(goal.goal_id) or answer.error or GoalError(NO_REASON, SAID_NOTHING)
            answer = replace(answer, error=error)
        answer = replace(answer, remark=self._remark())
        self._settle(goal, answer, stamp_ns)

    async def _end_without_result(self, goal: Goal, status: GoalStatus) -> None:
        deadline = time.monotonic() + self._limits.result_wait
        while not goal.status.final and time.monotonic() < deadline:
            await asyncio.sleep(self._limits.ask_again_after)
            # An answer is lost if the server has not discovered our client yet, as just after a start.
            if not goal.status.final:
                self.request_again(goal)
        if not goal.status.final:
            error = GoalError(NO_RESULT, "the goal ended, but the action server did not send its result")
            self._settle(goal, ResultAnswer(status, None, error), await self._end_stamps.wait_for(goal.goal_id))

    # ------------------------------------------------------------------ the end

    def retire(self, goal: Goal) -> None:
        """Stop waiting for the result of an ended or lost goal; if it may still arrive, somewhat later."""
        if goal.result is not None or goal.status not in WITH_RESULT:
            self.forget(goal.goal_id)
        elif goal.goal_id in self._calls:
            asyncio.get_running_loop().call_later(self._limits.late_result, self.forget, goal.goal_id)

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
