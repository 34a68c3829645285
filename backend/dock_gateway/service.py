"""What can be done with the goals of an action: the way in. Mints ids, records goals, keeps every deadline."""

import asyncio
import logging
import time
import uuid
from typing import Any

from dock_gateway.canceler import TOO_LATE, Canceler
from dock_gateway.errors import (
    Conflict,
    GatewayError,
    NotFound,
    ServerTimeout,
    TooManyRequests,
    Unavailable,
)
from dock_gateway.events import utc_now
from dock_gateway.goals import Goal, GoalError, GoalStatus
from dock_gateway.history import History, fingerprint_of
from dock_gateway.interlock import Interlock
from dock_gateway.later import Later
from dock_gateway.liveness import ServerWatch
from dock_gateway.ros.bridge import PendingCall
from dock_gateway.settings import Settings
from dock_gateway.tracker import GoalTracker

log = logging.getLogger(__name__)

# A key that another replica has claimed: so long may it take until its goal is kept.
CLAIM_WAIT = 2.0
# What an action server may say by these names, all else being `goal_rejected`.
KNOWN_REJECTIONS = ("dock_busy", "stop_latched")
STOPPED_ON_ITS_WAY = GoalError("stopped", "a stop was asked for while the goal was on its way, so it was not sent")


class GoalService:
    """Submits, cancels and finds goals of one action."""

    def __init__(
        self,
        settings: Settings,
        history: History,
        tracker: GoalTracker,
        watch: ServerWatch,
        reasons: Later[GoalError],
        *,
        interlock: Interlock,
    ) -> None:
        self._settings = settings
        self._history = history
        self._tracker = tracker
        self._watch = watch
        self._reasons = reasons
        self._interlock = interlock
        self._submitting: dict[str, tuple[Any, asyncio.Task[Goal]]] = {}
        self._pending = 0
        self._stops = 0
        self._tasks: set[asyncio.Task[Goal]] = set()
        self._canceler = Canceler(settings, tracker)

    # ------------------------------------------------------------------ submit

    async def submit(self, message: Any, idempotency_key: str | None = None) -> Goal:
        """Send a goal and wait until the action server has accepted it.

        Args:
            message: The goal as a ROS message.
            idempotency_key: Another submission with this key gets the goal of the first, unless that was never sent.

        Raises:
            Conflict: A stop is latched (`stop_latched`) or was asked for meanwhile (`stopped`), the server rejected the
                goal (`goal_rejected`, `dock_busy`), or the key was used for another goal.
            Unavailable: There is no action server.
            ServerTimeout: It did not answer in time. Should it accept the goal later, the goal is canceled at once.
            TooManyRequests: Too many goals wait for an answer.
        """
        if idempotency_key is None:
            return await asyncio.shield(self._start(message, None))
        under_way = self._submitting.get(idempotency_key)
        if under_way is None:
            first = await self._known(idempotency_key)
            if first is not None:
                port = self._tracker.port
                self._require_same(
                    fingerprint_of(first.action_name, first.goal),
                    fingerprint_of(port.action_name, port.encode_goal(message)),
                )
                if not await self._free(idempotency_key, first):
                    return await self._outcome_of(first, time.monotonic() + self._settings.accept_timeout)
            under_way = self._submitting.get(idempotency_key)
        if under_way is None:
            task = self._start(message, idempotency_key)
            self._submitting[idempotency_key] = (message, task)
            task.add_done_callback(lambda _: self._submitting.pop(idempotency_key))
        else:
            first_message, task = under_way
            encode = self._tracker.port.encode_goal
            self._require_same(encode(first_message), encode(message))
        return await asyncio.shield(task)

    async def _known(self, idempotency_key: str) -> Goal | None:
        try:
            return await self._history.by_key(idempotency_key)
        except Unavailable:
            return None  # the claim that follows does what can be done

    async def _free(self, idempotency_key: str, first: Goal) -> bool:
        """Whether the key may be used once more: its goal was never sent, and the history has let go of it."""
        if not first.unsent:
            return False
        try:
            await self._history.release(idempotency_key, first.goal_id)
        except Unavailable:
            return False
        return True

    async def _outcome_of(self, goal: Goal, deadline: float) -> Goal:
        """What became of a goal that was sent before, maybe by another replica and just now."""
        while goal.status is GoalStatus.PENDING and time.monotonic() < deadline:
            await asyncio.sleep(0.05)
            goal = self._tracker.live.get(goal.goal_id) or await self._history.get(goal.goal_id) or goal
        return _outcome(self._tracker.live.get(goal.goal_id, goal))

    async def _claim(self, idempotency_key: str, goal: Goal) -> Goal | None:
        """Claim the key for the goal; the goal that had it already, if there is one."""
        fingerprint = fingerprint_of(goal.action_name, goal.goal)
        goal_id, first_fingerprint = await self._history.claim(idempotency_key, goal.goal_id, fingerprint)
        if goal_id == goal.goal_id:
            return None
        self._require_same(first_fingerprint, fingerprint)
        deadline = time.monotonic() + CLAIM_WAIT
        first = await self._history.get(goal_id)
        while first is None and time.monotonic() < deadline:
            await asyncio.sleep(0.05)
            first = await self._history.get(goal_id)
        # Whoever claimed the key may have died before it kept the goal. Its place is taken under the same id, which
        # an action server accepts only once.
        goal.goal_id = goal_id
        return first

    @staticmethod
    def _require_same(first: object, second: object) -> None:
        if first != second:
            raise Conflict("this Idempotency-Key was used for another goal", code="idempotency_key_reused")

    def _start(self, message: Any, idempotency_key: str | None) -> asyncio.Task[Goal]:
        """Submit in a task of its own, which goes on when the client goes away."""
        task = asyncio.create_task(self._submit(message, idempotency_key))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _submit(self, message: Any, idempotency_key: str | None) -> Goal:
        if self._pending >= self._settings.max_pending_goals:
            raise TooManyRequests(f"{self._pending} goals are waiting for the action server's answer already")
        self._pending += 1
        try:
            return await self._send(message, idempotency_key)
        finally:
            self._pending -= 1

    async def _send(self, message: Any, idempotency_key: str | None) -> Goal:
        deadline = time.monotonic() + self._settings.accept_timeout
        stops = self._stops
        port = self._tracker.port
        self._interlock.require_released(port.action_name)
        await self._watch.require()
        goal = Goal(str(uuid.uuid4()), port.action_name, port.action_type, utc_now(), goal=port.encode_goal(message))
        if idempotency_key is not None and (first := await self._claim(idempotency_key, goal)):
            return await self._outcome_of(first, deadline)
        keeping = asyncio.create_task(self._history.add(goal, idempotency_key))
        if idempotency_key is not None or not self._history.stats().database_reachable:
            await keeping
        self._tracker.add(goal)
        with self._tracker.results.sending(goal):
            try:
                await self._deliver(goal, message, deadline, stops)
            finally:
                await self._see_kept(goal, keeping)
        return _outcome(goal)

    async def _deliver(self, goal: Goal, message: Any, deadline: float, stops: int) -> None:
        """Send the goal and take the server's answer, whatever it is, unless there was a stop in the meantime."""
        if self._stops != stops or self._interlock.holds(goal.action_name):
            self._tracker.end(goal, GoalStatus.REJECTED, error=STOPPED_ON_ITS_WAY)
            return
        try:
            call = self._tracker.port.send(goal.goal_id, message)
            async with asyncio.timeout(max(0.1, deadline - time.monotonic())):
                response = await asyncio.shield(call.response)
        except TimeoutError:
            self._give_up(goal, call)
            return
        except GatewayError as error:
            self._tracker.end(goal, GoalStatus.REJECTED, error=GoalError(error.code, error.detail))
            raise
        self._tracker.heard()
        if response.accepted:
            self._accept(goal, response)
        else:
            await self._reject(goal)

    async def _see_kept(self, goal: Goal, keeping: "asyncio.Task[None]") -> None:
        """Wait until the goal is safe, which took place beside its delivery; one that cannot be kept must not run."""
        try:
            await keeping
        except GatewayError as error:
            if not goal.status.final:
                self._canceler.disown(goal, GoalError(error.code, error.detail))
            if not goal.status.terminal:
                self._canceler.turned_up(goal)
            raise

    def _accept(self, goal: Goal, response: Any) -> None:
        self._tracker.move(goal, GoalStatus.ACCEPTED, response.stamp.sec * 1_000_000_000 + response.stamp.nanosec)
        self._tracker.results.request(goal)
        self._canceler.turned_up(goal)

    def _busy_with(self, goal: Goal) -> str | None:
        return next(
            (
                other.goal_id
                for other in self._tracker.running()
                if other is not goal and other.status is not GoalStatus.PENDING
            ),
            None,
        )

    async def _reject(self, goal: Goal) -> None:
        busy_with = self._busy_with(goal)
        reason = await self._reasons.of(goal.goal_id)
        if reason is not None:
            code = reason.code if reason.code in KNOWN_REJECTIONS else "goal_rejected"
            error = GoalError(code, reason.detail)
        elif busy_with is not None:
            error = GoalError("dock_busy", f"goal {busy_with} is running; cancel it first")
        else:
            error = GoalError("goal_rejected", "the action server rejected the goal and did not say why")
        self._tracker.end(goal, GoalStatus.REJECTED, error=error)

    def _give_up(self, goal: Goal, call: PendingCall) -> None:
        self._canceler.disown(goal, TOO_LATE)
        detail = f"the action server did not accept or reject the goal within {self._settings.accept_timeout:g} s"
        self._tracker.lose(goal, GoalError("action_server_timeout", detail))

        def answered(response: "asyncio.Future[Any]") -> None:
            if response.cancelled() or response.exception():
                return
            self._tracker.heard()
            if response.result().accepted:
                self._accept(goal, response.result())
            else:
                self._tracker.end(goal, GoalStatus.REJECTED, error=goal.error)

        call.response.add_done_callback(answered)

    # ------------------------------------------------------------------ cancel

    async def cancel(self, goal_id: str) -> Goal:
        """Ask the server to cancel a goal, whoever sent it. A lost one is canceled when it turns up.

        Raises:
            NotFound: There is no such goal.
            Conflict: It has ended (`goal_terminal`), or the server refuses (`cancel_rejected`).
            Unavailable: The action server is gone.
            ServerTimeout: It did not answer in time.
        """
        goal = await self.get(goal_id)
        await self._canceler.cancel(goal)
        return goal

    def disown_pending(self) -> None:
        """A stop is asked for: what is on its way must not run."""
        self._stops += 1

    async def cancel_all(self) -> list[str]:
        """Ask the server to cancel every goal, other clients' too; returns the ids of those that it will cancel.

        Raises:
            Unavailable: There are goals and no action server.
            ServerTimeout: The server does not answer.
            Conflict: It refuses.
        """
        return await self._canceler.cancel_all()

    # ------------------------------------------------------------------ look

    async def get(self, goal_id: str) -> Goal:
        """One goal.

        Raises:
            NotFound: There is no such goal.
        """
        goal = self._tracker.live.get(goal_id) or await self._history.get(goal_id)
        if goal is None:
            raise NotFound(f"there is no goal {goal_id}", code="goal_not_found")
        return goal

    async def wait(self, goal: Goal, timeout: float) -> None:
        """Wait until the goal has ended or the time is up."""
        await self._tracker.wait_terminal(goal, timeout)


# What the sender of a goal is told when it did not even start, by the code of the goal's error.
_REFUSALS: dict[str, type[GatewayError]] = {
    "action_server_unavailable": Unavailable,
    "ros_unavailable": Unavailable,
    "action_server_timeout": ServerTimeout,
}


def _outcome(goal: Goal) -> Goal:
    """The goal, or the error that the sender of it gets: the same one for each retry with the same key."""
    error = goal.error
    gave_up = error is not None and goal.status is GoalStatus.LOST and error.code == ServerTimeout.code
    if error is None or not (goal.status is GoalStatus.REJECTED or gave_up):
        return goal
    refusal = _REFUSALS.get(error.code, Conflict)
    raise refusal(error.detail, code=error.code, goal_id=goal.goal_id)
