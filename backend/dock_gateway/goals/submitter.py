"""Submits goals: one goal per idempotency key, however often it is submitted."""

import asyncio
import time
from typing import Any

import orjson

from dock_gateway.core.access import Principal
from dock_gateway.core.dock_adapters.adapter import DockAdapter
from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.goals.delivery import GoalDelivery, KeyClaim, outcome
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.settings import Settings
from dock_gateway.storage import History, fingerprint_of

# Seconds to wait for the goal of a key that another replica has claimed to be stored.
CLAIM_WAIT = 2.0


class Submitter:
    """Submits goals of one action."""

    def __init__(
        self,
        settings: Settings,
        history: History,
        tracker: GoalTracker,
        delivery: GoalDelivery,
        adapter: DockAdapter | None = None,
    ) -> None:
        self._adapter = adapter
        self._settings = settings
        self._history = history
        self._tracker = tracker
        self._submitting: dict[str, tuple[Any, asyncio.Task[Goal]]] = {}
        self._delivery = delivery

    async def submit(self, message: Any, idempotency_key: str | None = None, *, sender: Principal | None) -> Goal:
        """Send a goal and wait until the action server has accepted it.

        Args:
            message: The goal as a ROS message.
            idempotency_key: A later submission with this key gets the first one's goal, unless that was never sent.
            sender: Who sends it; None: the gateway itself, for a rule of automatic docking or a mission.

        Raises:
            Conflict: A stop is latched (`stop_latched`) or was requested in the meantime (`stopped`), the server
                rejected the goal (`goal_rejected`, `dock_busy`), or the key was used for another goal.
            Unavailable: There is no action server that answers.
            ServerTimeout: It was sent the goal, and did not answer in time. If it accepts the goal later, the goal is
                canceled at once.
            TooManyRequests: Too many goals are waiting for an answer.
        """
        if idempotency_key is None:
            return await asyncio.shield(self._delivery.start(message, sender=sender))
        stops = self._delivery.stops
        again: Goal | None = None
        under_way = self._submitting.get(idempotency_key)
        if under_way is None:
            first = await self._known(idempotency_key)
            if first is not None:
                message = self._require_first(first, message)
                first = await self._settled(first)
                if self._may_send_again(first):
                    again = first
                elif not await self._free(idempotency_key, first):
                    return outcome(first)
            under_way = self._submitting.get(idempotency_key)
        if under_way is None:
            task = self._delivery.start(message, self._claim_of(idempotency_key), stops, again, sender=sender)
            self._submitting[idempotency_key] = (message, task)
            task.add_done_callback(lambda _: self._submitting.pop(idempotency_key))
        else:
            first_message, task = under_way
            encode = self._tracker.port.encode_goal
            self._require_same(encode(first_message), encode(message))
        return await asyncio.shield(task)

    def _require_first(self, first: Goal, message: Any) -> Any:
        """Check that a key's first goal was asked for with this message; return the message that was sent.

        A gate may have named the dock of a goal that named none.

        Raises:
            Conflict: It was another one (`idempotency_key_reused`).
        """
        port, adapter = self._tracker.port, self._adapter
        asked = port.encode_goal(message)
        if adapter is not None and first.goal is not None and asked != first.goal:
            fields, sent = orjson.loads(asked), adapter.dock_of(orjson.loads(first.goal))
            if sent and adapter.dock_of(fields) == "":
                message = port.goal_codec.parse(adapter.at_dock(fields, sent))
                asked = port.encode_goal(message)
        self._require_same(fingerprint_of(first.action_name, first.goal), fingerprint_of(port.action_name, asked))
        return message

    async def _known(self, idempotency_key: str) -> Goal | None:
        try:
            return await self._history.by_key(idempotency_key)
        except Unavailable:
            return None  # the claim that follows handles this

    async def _free(self, idempotency_key: str, first: Goal) -> bool:
        """Release the key if its goal was never sent; return whether the key may be used again."""
        if not first.unsent:
            return False
        try:
            await self._history.release(idempotency_key, first.goal_id)
        except Unavailable:
            return False
        return True

    def _may_send_again(self, goal: Goal) -> bool:
        """Return whether a stored goal never reached the action server and its sender is gone."""
        return goal.unconfirmed or (goal.status is GoalStatus.PENDING and goal.goal_id not in self._tracker.live)

    async def _settled(self, goal: Goal) -> Goal:
        """Wait until a goal sent earlier, perhaps by another replica, has been answered; return its current state."""
        deadline = time.monotonic() + self._settings.accept_timeout
        while goal.status is GoalStatus.PENDING and time.monotonic() < deadline:
            await asyncio.sleep(0.05)
            goal = self._tracker.live.get(goal.goal_id) or await self._history.get(goal.goal_id) or goal
        return self._tracker.live.get(goal.goal_id, goal)

    def _claim_of(self, idempotency_key: str) -> KeyClaim:
        async def take(goal: Goal) -> Goal | None:
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
            if first is not None:
                return outcome(await self._settled(first))
            # The replica that claimed the key died before it stored the goal. Use the same goal id, which an action
            # server accepts only once.
            goal.goal_id = goal_id
            return None

        return KeyClaim(idempotency_key, take)

    @staticmethod
    def _require_same(first: object, second: object) -> None:
        if first != second:
            raise Conflict("this Idempotency-Key was used for another goal", code="idempotency_key_reused")
