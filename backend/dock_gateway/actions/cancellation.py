"""Canceling goals: now where that can be done, else as soon as it can.

A goal that was canceled, stopped or given up must not run, also when its server was frozen, out of reach or too late:
it is unwanted from then on, and the server is asked again whenever the goal turns up, until it has ended or the server
refuses. While a stop holds for the action, every goal on it is unwanted, whoever sent it and whenever it turns up, and
a refusal is not taken.
"""

import asyncio
import logging

from dock_gateway.actions.tracker import GoalTracker
from dock_gateway.core.errors import Conflict, GatewayError, ServerTimeout, Unavailable
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.latch.interlock import Interlock
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

STOP_TIMEOUT = 1.0
# A server that does not answer is asked again after so many seconds.
RETRY_INTERVAL = 1.0
# Goals that must not run and that nothing has been heard of, besides those that are tracked
MAX_UNWANTED = 1000
UNKNOWN_GOAL = 2  # action_msgs/CancelGoal ERROR_UNKNOWN_GOAL_ID

TOO_LATE = GoalError(
    "action_server_timeout",
    "the action server accepted the goal only after the gateway had given up on it, so it was canceled",
)
STOPPED = GoalError("stopped", "a stop was asked for")
CANCELED = GoalError("canceled", "it was canceled while the action server could not be reached")


class Canceler:
    """Cancels the goals of one action, whoever sent them.

    Args:
        settings: Deadlines.
        tracker: The goals.
        interlock: Which robots are held by a stop.
    """

    def __init__(self, settings: Settings, tracker: GoalTracker, interlock: Interlock) -> None:
        self._settings = settings
        self._tracker = tracker
        self._interlock = interlock
        self._unwanted: dict[str, GoalError] = {}
        self._insisting: set[str] = set()
        tracker.on_return = self.seen_again
        tracker.on_seen.append(self.seen_again)
        tracker.on_end.append(self._forget)

    async def cancel(self, goal: Goal) -> None:
        """Ask the server to cancel a goal; where it cannot be reached, the goal stays unwanted.

        Raises:
            Conflict: It has ended (`goal_terminal`), or the server refuses (`cancel_rejected`).
            Unavailable: The action server is not there. Should the goal turn up again, it is canceled.
            ServerTimeout: The server did not answer in time. It is asked again.
        """
        require_unfinished(goal)
        if goal.status in (GoalStatus.PENDING, GoalStatus.LOST):
            self.mark_unwanted(goal, CANCELED)
        if goal.status is GoalStatus.LOST:
            return
        try:
            await self._ask(goal)
        except (ServerTimeout, Unavailable):
            self.mark_unwanted(goal, CANCELED)
            self.seen_again(goal)
            raise

    async def _ask(self, goal: Goal) -> None:
        for attempt in range(2):
            try:
                answer = await self._tracker.port.cancel(goal.goal_id, self._settings.cancel_timeout)
            except TimeoutError:
                seconds = self._settings.cancel_timeout
                detail = f"the action server did not answer within {seconds:g} s; it is asked again"
                raise ServerTimeout(detail, goal_id=goal.goal_id) from None
            self._tracker.heard()
            if goal.goal_id in answer.goal_ids:
                self._tracker.move(goal, GoalStatus.CANCELING)
                return
            if answer.return_code == UNKNOWN_GOAL and attempt == 0 and not goal.status.terminal:
                await asyncio.sleep(0.1)  # it may just be on its way
                continue
            break
        if goal.status in (GoalStatus.PENDING, GoalStatus.CANCELING, GoalStatus.LOST):
            return
        if goal.status.terminal:
            raise Conflict(f"the goal is {goal.status.value} already", code="goal_terminal", goal_id=goal.goal_id)
        self._refused(goal)
        raise Conflict("the action server refuses to cancel the goal", code="cancel_rejected", goal_id=goal.goal_id)

    def _refused(self, goal: Goal) -> None:
        """The goal goes on; one that a stop holds for is asked for again, nevertheless."""
        self._unwanted.pop(goal.goal_id, None)
        goal.error = self._why_unwanted(goal)

    async def cancel_all(self) -> list[str]:
        """Ask the server to cancel every goal; returns the ids of those that it will cancel.

        Raises:
            Unavailable: There are goals and no action server.
            ServerTimeout: The server does not answer.
            Conflict: `cancel_rejected`: it refuses for some; the others are canceled.
        """
        goals = [goal for goal in self._tracker.live.values() if not goal.status.final]
        for goal in goals:
            self.mark_unwanted(goal, STOPPED)
            if not goal.status.terminal:
                goal.error = self._why_unwanted(goal)
        try:
            answer = await self._tracker.port.cancel(None, STOP_TIMEOUT)
        except TimeoutError:
            self._insist_on(goals)
            detail = "the action server does not answer; it was asked to cancel every goal, and is asked again"
            raise ServerTimeout(detail) from None
        except Unavailable:
            self._insist_on(goals)
            if goals:
                raise
            return []
        self._tracker.heard()
        for goal_id in answer.goal_ids & self._tracker.live.keys():
            self._tracker.move(self._tracker.live[goal_id], GoalStatus.CANCELING)
        refused = [goal for goal in goals if goal.status in (GoalStatus.ACCEPTED, GoalStatus.EXECUTING)]
        if refused:
            for goal in refused:
                self._refused(goal)
            self._insist_on(refused)
            raise Conflict(
                f"the action server refuses to cancel {', '.join(goal.goal_id for goal in refused)}",
                code="cancel_rejected",
                canceling=sorted(answer.goal_ids),
            )
        return sorted(answer.goal_ids)

    @property
    def uncanceled(self) -> bool:
        """Whether there are goals that run and that the server was not heard to cancel."""
        return any(goal.status is not GoalStatus.CANCELING for goal in self._tracker.running())

    def mark_unwanted(self, goal: Goal, why: GoalError) -> None:
        """The goal must not run, whenever it turns up."""
        if goal.status.final:
            return
        self._unwanted.setdefault(goal.goal_id, why)
        if len(self._unwanted) > len(self._tracker.live) + MAX_UNWANTED:
            del self._unwanted[next(goal_id for goal_id in self._unwanted if goal_id not in self._tracker.live)]

    def seen_again(self, goal: Goal) -> None:
        """A goal runs, as far as is known: where it is unwanted, it is canceled."""
        why = self._why_unwanted(goal)
        if why is None or goal.goal_id in self._insisting:
            return
        log.warning("canceling goal %s: %s", goal.goal_id, why.detail)
        goal.error = why
        self._insisting.add(goal.goal_id)
        self._tracker.tasks.spawn(self._insist(goal))

    def cancel_unwanted(self) -> None:
        """A stop of another gateway holds: nothing may run on that has not been canceled by it."""
        self._insist_on(self._tracker.running())

    def _why_unwanted(self, goal: Goal) -> GoalError | None:
        """Why a goal must not run; None where it may."""
        held = STOPPED if self._interlock.holds(goal.action_name) else None
        return self._unwanted.get(goal.goal_id, held)

    def _insist_on(self, goals: list[Goal]) -> None:
        for goal in goals:
            if not goal.status.terminal:
                self.seen_again(goal)

    async def _insist(self, goal: Goal) -> None:
        refused = False
        try:
            while self._why_unwanted(goal) is not None and not goal.status.terminal:
                try:
                    await self._ask(goal)
                    if goal.status is GoalStatus.CANCELING:
                        return
                except Conflict as error:
                    if not refused:
                        log.warning("goal %s could not be canceled: %s", goal.goal_id, error.detail)
                    refused = True
                except GatewayError as error:
                    log.info("goal %s could not be canceled yet: %s", goal.goal_id, error.detail)
                await asyncio.sleep(RETRY_INTERVAL)
            if not goal.status.terminal:  # the stop was released: it may run
                goal.error = None
        finally:
            self._insisting.discard(goal.goal_id)

    def _forget(self, goal: Goal) -> None:
        if goal.status.final:
            self._unwanted.pop(goal.goal_id, None)


def require_unfinished(goal: Goal) -> None:
    """See that there is something to cancel.

    Raises:
        Conflict: The goal has ended (`goal_terminal`).
    """
    if goal.status.final:
        raise Conflict(f"the goal is {goal.status.value} already", code="goal_terminal", goal_id=goal.goal_id)
