"""The goals on one action: gives messages and requests to the `GoalMachine`, and carries out what it wants done.

Runs on the event loop only, and waits for nothing but the action server and the history.
"""

import asyncio
import logging
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from datetime import datetime
from typing import Concatenate, ParamSpec
from weakref import WeakValueDictionary

from dock_gateway.core.dock_adapters.adapter import DockAdapter
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import Now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalError, Json, Origin, ResultAnswer
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.tasks import PendingFacts, Tasks
from dock_gateway.goals.adoption import REQUEST_PAUSE, REQUESTS_AT_ONCE
from dock_gateway.goals.goal_machine import (
    AwaitResult,
    GoalChange,
    GoalMachine,
    Notify,
    PublishEnd,
    PublishEvent,
    Store,
)
from dock_gateway.goals.goal_publisher import GoalPublisher
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.goals.results import Results
from dock_gateway.ros.action_port import ActionPort
from dock_gateway.ros.admission import KnownGoals
from dock_gateway.ros.status import StatusReport
from dock_gateway.storage import History

log = logging.getLogger(__name__)

P = ParamSpec("P")

# Takes a goal that is about to be lost, and returns what was done about it, as a clause; empty: nothing.
BeforeLost = Callable[[Goal], str]


class GoalTracker:
    """Every goal on one action, from its first message to its end.

    Args:
        port: The action.
        fanout: Receives events.
        history: Stores goals.
        reasons: Why goals were rejected or aborted.
        adapter: What the action's messages say about a goal, if it docks or undocks robots.
        remark: Returns what is wrong around the robot; it is added to the reason of goals that are aborted.
        before_lost: Called with a goal that is about to be lost; what was done is added to the reason.
        limits: How long to wait, and how many goals to remember.

    Attributes:
        live: The running goals, and lost ones that may return.
        taken_up: Ids of goals from before a restart.
        unwanted: Why goals must not run, by their ids.
        known: Returns whether a goal is known, on any thread.
        on: The functions to call with a goal, by what happened to it.
        last_heard: When the action server last gave a sign of life, on the monotonic clock.
        tasks: Background tasks, which run until the tracker is closed.
    """

    def __init__(
        self,
        port: ActionPort,
        fanout: Fanout,
        history: History,
        reasons: PendingFacts[GoalError],
        adapter: DockAdapter | None = None,
        *,
        remark: Callable[[], str] = str,
        before_lost: Iterable[BeforeLost] = (),
        limits: GoalLimits = LIMITS,
    ) -> None:
        self._machine = GoalMachine(
            port.action_name, port.action_type, fanout.clock.stamp, Now.read(), adapter, limits=limits
        )
        self.known: KnownGoals = self._machine
        self.live = self._machine.live
        self.taken_up = self._machine.taken_up
        self.unwanted = self._machine.unwanted
        self.last_heard = time.monotonic()
        self.port = port
        self.tasks = Tasks("tracking goals")
        self._results = Results(port, reasons, self.heard, self._settle, remark, limits=limits)
        self.on = {news: Listeners[[Goal]](f"{news.name.lower()}, of a goal") for news in GoalChange}
        self.on[GoalChange.LOST].append(self._release)
        self.on[GoalChange.RETIRED].append(self._results.retire)
        self._before_lost = before_lost
        self._fanout = fanout
        self._history = history
        self._publisher = GoalPublisher(fanout, history)
        self._waiters: WeakValueDictionary[str, asyncio.Event] = WeakValueDictionary()  # held by the waiting callers
        self._looking_up = False
        self._lookups = Tasks("looking up goals")

    def heard(self) -> None:
        """Note that the action server gave a sign of life."""
        self.last_heard = time.monotonic()

    def silence_of(self, goal: Goal) -> float:
        """Return the seconds since the last news of this goal."""
        return time.monotonic() - (self._machine.heard_at(goal) or self.last_heard)

    # ------------------------------------------------------------------ messages from ROS

    def on_status(self, reports: list[StatusReport], stamp_ns: int) -> None:
        """Handle a message of `_action/status`: the states of the goals that the server remembers."""
        self.heard()
        for report in reports:
            self.apply(GoalMachine.report, report.goal_id, report.status, report.accepted_ns, stamp_ns)

    def on_feedback(self, goal_id: str, feedback: Json, stamp_ns: int) -> None:
        """Handle a message of `_action/feedback`."""
        self.heard()
        self.apply(GoalMachine.feedback, goal_id, feedback, stamp_ns)

    def ask_again(self, goal: Goal) -> None:
        """Request a goal's result again: the server may have restarted and lost the first request."""
        self._results.request_again(goal)

    def _settle(self, goal: Goal, answer: ResultAnswer, stamp_ns: int | None) -> None:
        if answer.status is None:
            self.lose(goal, GoalError("action_server_lost", "the action server does not know the goal"))
        else:
            self.apply(GoalMachine.answered, goal, answer, stamp_ns)

    # ------------------------------------------------------------------ goals

    def running(self) -> list[Goal]:
        """Return the goals that have not ended, oldest first."""
        return self._machine.running()

    def new_goal(self, goal_id: str, created_at: datetime, origin: Origin) -> Goal:
        """Return a new goal on this action, which is not tracked yet."""
        return self._machine.new_goal(goal_id, created_at, origin)

    def take_up(self, goal: Goal) -> None:
        """Resume tracking a goal that was running according to the history."""
        self.on[GoalChange.RESUMED](goal)
        self._publisher.publish_first(goal)
        self.apply(GoalMachine.take_up, goal)

    def lose(self, goal: Goal, error: GoalError) -> None:
        """Mark a goal as lost because the action server is gone, after what is to be done before that."""
        if not goal.status.terminal:
            self.apply(GoalMachine.lose, goal, about_to_be_lost(goal, error, self._before_lost))

    # ------------------------------------------------------------------ what the machine wants done

    def apply(
        self, change: Callable[Concatenate[GoalMachine, Now, P], None], *args: P.args, **kwargs: P.kwargs
    ) -> None:
        """Give the machine an input at this moment, such as `GoalMachine.end`, and do what it wants done."""
        change(self._machine, Now.read(), *args, **kwargs)
        while self._machine.outputs:
            match self._machine.outputs.popleft():
                case PublishEvent(event, goal):
                    self._publisher.publish(event, goal)
                    self.on[GoalChange.CHANGED](goal)
                case Store(goal):
                    self._history.record(goal)
                case AwaitResult(goal, reported):
                    self._results.request(goal, reported)
                case PublishEnd(goal, source_ns):
                    self._publisher.publish_end(goal, source_ns, self._release)
                case Notify(news, goal):
                    self.on[news](goal)
        if self._machine.newcomers and not self._looking_up:
            self._looking_up = True
            self._lookups.spawn(self._look_up())

    async def _look_up(self) -> None:
        """Look up unknown goals in the history, as long as there are any."""
        newcomers = self._machine.newcomers
        try:
            while newcomers:
                known = await self._known(asked := list(newcomers))
                ready, pause = newcomers.ready(asked, known, time.monotonic())
                for number, goal_id in enumerate(ready, 1):
                    try:
                        if (goal := (known or {}).get(goal_id)) is not None:
                            self.on[GoalChange.RESUMED](goal)
                            self._publisher.publish_first(goal)
                        self.apply(GoalMachine.adopt, goal_id, goal)
                    except Exception:
                        log.exception("while adopting goal %s", goal_id, extra={"goal_id": goal_id})
                    if not self._machine.ended(goal_id) and number % REQUESTS_AT_ONCE == 0:
                        await asyncio.sleep(REQUEST_PAUSE)
                await asyncio.sleep(pause)
        finally:
            self._looking_up = False

    async def _known(self, goal_ids: list[str]) -> dict[str, Goal] | None:
        """Return what the history knows about these goals, or None if it does not answer."""
        try:
            return await self._history.known(goal_ids)
        except GatewayError:
            return None
        except Exception:
            log.exception("while looking up goals")
            return None

    # ------------------------------------------------------------------ waiting, and the end

    async def wait_terminal(self, goal: Goal, timeout: float) -> None:
        """Wait until the goal has ended or the gateway closes, at most `timeout` seconds."""
        if goal.status.terminal or self._fanout.closing:
            return
        event = self._waiters.setdefault(goal.goal_id, asyncio.Event())
        try:
            async with asyncio.timeout(timeout):
                await event.wait()
        except TimeoutError:
            return

    def _release(self, goal: Goal) -> None:
        if event := self._waiters.pop(goal.goal_id, None):
            event.set()

    def release_all(self) -> None:
        """Wake every caller that waits for a goal."""
        for event in list(self._waiters.values()):
            event.set()
        self._waiters.clear()

    async def close(self) -> None:
        """Stop all waiting and background work."""
        self.release_all()
        await self._lookups.close()
        await self._results.close()
        await self._publisher.drain()
        await self.tasks.close()


def about_to_be_lost(goal: Goal, error: GoalError, before_lost: Iterable[BeforeLost]) -> GoalError:
    """Do what is to be done before a goal is lost; return the error with what was done."""
    return replace(error, detail="; ".join(filter(None, (error.detail, *(do(goal) for do in before_lost)))))
