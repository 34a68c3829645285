"""Cancels goals: immediately if possible, else as soon as possible.

A goal that was canceled, stopped or given up must not run, even if its server was frozen, unreachable or too late. It
is unwanted from then on: the cancel request is repeated whenever the goal is seen, until the goal has ended or the
server refuses. A goal that is on its way when a stop comes is one of them, however late its server accepts it, also
after the stop was released. While a stop is latched for the action, every goal on it is unwanted, regardless of its
sender, and requests continue even after a refusal.
"""

import asyncio
import logging

from dock_gateway.core.errors import Conflict, GatewayError, ServerTimeout, Unavailable
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.core.request import act
from dock_gateway.goals.goal_machine import GoalChange, GoalMachine
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.latch.interlock import Interlock
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

STOP_TIMEOUT = 1.0
# ERROR_UNKNOWN_GOAL_ID of action_msgs/CancelGoal.
UNKNOWN_GOAL = 2
# ERROR_GOAL_TERMINATED of action_msgs/CancelGoal, which also stands for a goal that is being canceled already.
NOTHING_TO_CANCEL = 3

TOO_LATE = GoalError(
    "action_server_timeout",
    "the action server accepted the goal too late, so the gateway canceled it",
)
STOPPED = GoalError("stopped", "a stop was requested")
CANCELED = GoalError("canceled", "the goal was canceled while the action server could not be reached")


class Canceler:
    """Cancels the goals of one action, regardless of their sender.

    Args:
        settings: Deadlines.
        tracker: The goals.
        interlock: The latched stops.
        limits: How often to repeat a request, and how many goals to remember.

    Attributes:
        unwanted: Why goals must not run, by their ids.
        retrying: Ids of the goals that are being canceled until they have ended.
    """

    def __init__(
        self, settings: Settings, tracker: GoalTracker, interlock: Interlock, limits: GoalLimits = LIMITS
    ) -> None:
        self._settings = settings
        self._limits = limits
        self._tracker = tracker
        self._interlock = interlock
        self.unwanted = tracker.unwanted
        self.retrying: set[str] = set()
        for news in (GoalChange.SEEN, GoalChange.RETURNED):
            tracker.on[news].append(self.seen_again)
        tracker.on[GoalChange.RESUMED].append(self._resume)
        tracker.on[GoalChange.RETIRED].append(self._forget)

    async def cancel(self, goal: Goal) -> None:
        """Ask the server to cancel a goal. If the server cannot be reached, the goal stays unwanted.

        Raises:
            NotAuthenticated: The login of the user who cancels it has ended (`invalid_token`).
            Conflict: The goal has ended (`goal_terminal`), or the server refuses (`cancel_rejected`).
            Unavailable: There is no action server. If the goal is seen again, it is canceled.
            ServerTimeout: The server did not answer in time. The request is repeated.
        """
        require_unfinished(goal)
        act()
        if goal.status in (GoalStatus.PENDING, GoalStatus.LOST):
            self.mark_unwanted(goal, CANCELED)
        if goal.status is GoalStatus.LOST:
            return
        try:
            await self._ask(goal, self._settings.cancel_timeout)
        except (ServerTimeout, Unavailable):
            self.mark_unwanted(goal, CANCELED)
            self.seen_again(goal)
            raise

    async def _ask(self, goal: Goal, timeout: float) -> None:
        for attempt in range(2):
            try:
                answer = await self._tracker.port.cancel(goal.goal_id, timeout)
            except TimeoutError:
                detail = f"the action server did not answer within {timeout:g} s; retrying"
                raise ServerTimeout(detail, goal_id=goal.goal_id) from None
            self._tracker.heard()
            if goal.goal_id in answer.goal_ids:
                self._tracker.apply(GoalMachine.move, goal, GoalStatus.CANCELING)
                return
            if attempt == 0 and answer.return_code in (UNKNOWN_GOAL, NOTHING_TO_CANCEL) and not goal.status.terminal:
                await asyncio.sleep(0.1)  # the server may not have received the goal yet, or its status is on its way
                continue
            break
        if goal.status.terminal:
            raise Conflict(f"the goal is already {goal.status.value}", code="goal_terminal", goal_id=goal.goal_id)
        if answer.return_code == NOTHING_TO_CANCEL or goal.status in (
            GoalStatus.PENDING,
            GoalStatus.CANCELING,
            GoalStatus.LOST,
        ):
            return
        if answer.return_code != UNKNOWN_GOAL:  # which refuses nothing: the goal may be there later
            self._refused(goal)
        raise Conflict("the action server refuses to cancel the goal", code="cancel_rejected", goal_id=goal.goal_id)

    def _refused(self, goal: Goal) -> None:
        """Accept a refusal: the goal is no longer unwanted, unless a stop is latched for it."""
        self.unwanted.pop(goal.goal_id, None)
        self._tracker.apply(GoalMachine.explain, goal, self._why_unwanted(goal))

    def stop(self) -> None:
        """Mark every goal that has not ended: a stop was requested. `cancel_all` asks the server."""
        for goal in self._tracker.live.values():
            self._stop(goal)

    def _stop(self, goal: Goal) -> None:
        self.mark_unwanted(goal, self._stopped(goal))
        self._tracker.apply(GoalMachine.explain, goal, self._why_unwanted(goal))

    async def cancel_all(self) -> list[str]:
        """Ask the server to cancel every goal; return the ids of those that it will cancel.

        Those that it does not cancel yet are canceled as soon as possible, if a stop was requested.

        Raises:
            Unavailable: There are goals but no action server.
            ServerTimeout: The server does not answer.
            Conflict: `cancel_rejected`: the server refuses to cancel some goals; the others are canceled.
        """
        goals = list(self._tracker.live.values())
        try:
            return await self._cancel_all(goals)
        except (ServerTimeout, Unavailable):
            self._retry_cancels(self._tracker.running())
            if goals:
                raise
            return []
        finally:  # also on those that a further stop has marked since; on others once they are accepted
            self._retry_cancels([goal for goal in self._tracker.running() if goal.status is not GoalStatus.PENDING])

    async def _cancel_all(self, goals: list[Goal]) -> list[str]:
        try:
            answer = await self._tracker.port.cancel(None, STOP_TIMEOUT)
        except TimeoutError:
            detail = "the action server does not answer the request to cancel all goals; retrying"
            raise ServerTimeout(detail) from None
        self._tracker.heard()
        for goal_id in sorted(answer.goal_ids & self._tracker.live.keys()):
            self._stop(goal := self._tracker.live[goal_id])  # a request that is late reaches newer goals, too
            self._tracker.apply(GoalMachine.move, goal, GoalStatus.CANCELING)
        left = [goal for goal in goals if goal.status in (GoalStatus.ACCEPTED, GoalStatus.EXECUTING)]
        refuses = await asyncio.gather(*map(self._refuses, left))
        canceling = sorted(answer.goal_ids | {goal.goal_id for goal in left if goal.status is GoalStatus.CANCELING})
        if refused := [goal for goal, refuses_it in zip(left, refuses, strict=True) if refuses_it]:
            detail = f"the action server refuses to cancel {', '.join(goal.goal_id for goal in refused)}"
            raise Conflict(detail, code="cancel_rejected", canceling=canceling)
        return canceling

    async def _refuses(self, goal: Goal) -> bool:
        """Ask about a goal that the server did not name: it refuses, or the goal was canceled before or has ended."""
        try:
            await self._ask(goal, STOP_TIMEOUT)
        except Conflict as error:
            return error.code == "cancel_rejected"
        return False

    @property
    def uncanceled(self) -> bool:
        """Whether goals run that the server has not reported as canceling."""
        return any(goal.status is not GoalStatus.CANCELING for goal in self._tracker.running())

    def mark_unwanted(self, goal: Goal, why: GoalError) -> None:
        """Mark a goal that must not run, whenever it is seen."""
        if goal.status.final:
            return
        self.unwanted.setdefault(goal.goal_id, why)
        if len(self.unwanted) > len(self._tracker.live) + self._limits.unwanted:
            del self.unwanted[next(goal_id for goal_id in self.unwanted if goal_id not in self._tracker.live)]

    def _resume(self, goal: Goal) -> None:
        """Mark a goal that was unwanted before a restart, or at another gateway: its error says why."""
        given_up = goal.error is not None and goal.error.code == TOO_LATE.code
        if goal.error is not None and (given_up or not goal.status.terminal):
            self.mark_unwanted(goal, goal.error)

    def allow(self, goal: Goal) -> None:
        """Let a goal run that may have been unwanted: its sender sends it again."""
        self.unwanted.pop(goal.goal_id, None)

    def seen_again(self, goal: Goal) -> None:
        """Cancel a goal that appears to run, if it is unwanted."""
        why = self._why_unwanted(goal)
        if why is None or goal.goal_id in self.retrying or goal.status is GoalStatus.CANCELING:
            return
        log.warning("canceling goal %s: %s", goal.goal_id, why.detail, extra={"goal_id": goal.goal_id})
        self._tracker.apply(GoalMachine.explain, goal, why)
        self.retrying.add(goal.goal_id)
        self._tracker.tasks.spawn(self._retry_cancel(goal))

    def cancel_unwanted(self) -> None:
        """Cancel the unwanted goals that run, which another gateway's stop has not canceled."""
        self._retry_cancels(self._tracker.running())

    def _why_unwanted(self, goal: Goal) -> GoalError | None:
        """Return why a goal must not run, or None if it may."""
        held = self._stopped(goal) if self._interlock.holds(goal.action_name) else None
        return self.unwanted.get(goal.goal_id, held)

    def _stopped(self, goal: Goal) -> GoalError:
        by = self._interlock.requested_by(goal.action_name)
        return STOPPED if by is None else GoalError(STOPPED.code, f"{STOPPED.detail} by {by}")

    def _retry_cancels(self, goals: list[Goal]) -> None:
        for goal in goals:
            if not goal.status.terminal:
                self.seen_again(goal)

    async def _retry_cancel(self, goal: Goal) -> None:
        refused = False
        try:
            while self._why_unwanted(goal) is not None and not goal.status.terminal:
                try:
                    await self._ask(goal, self._settings.cancel_timeout)
                    if goal.status is GoalStatus.CANCELING:
                        return
                except Conflict as error:
                    if not refused:
                        log.warning(
                            "goal %s could not be canceled: %s",
                            goal.goal_id,
                            error.detail,
                            extra={"goal_id": goal.goal_id},
                        )
                    refused = True
                except GatewayError as error:
                    log.info(
                        "goal %s could not be canceled yet: %s",
                        goal.goal_id,
                        error.detail,
                        extra={"goal_id": goal.goal_id},
                    )
                await asyncio.sleep(self._limits.cancel_retry)
            self._tracker.apply(GoalMachine.explain, goal, None)  # the stop was released, so the goal may run
        finally:
            self.retrying.discard(goal.goal_id)

    def _forget(self, goal: Goal) -> None:
        if goal.status.final:
            self.unwanted.pop(goal.goal_id, None)


def require_unfinished(goal: Goal) -> None:
    """Check that a goal can still be canceled.

    Raises:
        Conflict: The goal has ended (`goal_terminal`).
    """
    if goal.status.final:
        raise Conflict(f"the goal is already {goal.status.value}", code="goal_terminal", goal_id=goal.goal_id)
