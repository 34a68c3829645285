"""The way out: what comes from ROS becomes changes of goals, events for the hub and entries in the history.

Runs on the event loop alone and never waits for anybody but the action server.
"""

import asyncio
import logging
import time
from collections import OrderedDict
from collections.abc import Callable
from copy import copy

from dock_gateway.events import Event, feedback_event, moment, nanoseconds, result_event, status_event, utc_now
from dock_gateway.goals import Goal, GoalError, GoalStatus, Json
from dock_gateway.history import History
from dock_gateway.hub import Hub
from dock_gateway.later import Later
from dock_gateway.results import Results
from dock_gateway.ros.actions import ActionPort, StatusReport
from dock_gateway.senders import Senders
from dock_gateway.tasks import Tasks

log = logging.getLogger(__name__)

MAX_REMEMBERED = 2000
MAX_LOST = 100

# Makes an event of a goal as it stands, with a timestamp.
MakeEvent = Callable[[Goal, int], Event]


class GoalTracker:
    """Every goal on one action, from its first sign to its end.

    Args:
        port: The action.
        hub: Where events go.
        history: Where goals are kept.
        reasons: Why goals were rejected or aborted.

    Attributes:
        live: The goals that run, and lost ones that may return.
        taken_up: Ids of goals from before a restart.
        on_return: Called with a goal that was `lost` and shows signs of life.
        on_end: What is called with a goal that nothing more is expected of.
        last_heard: When the action server gave its last sign of life, on the monotonic clock.
        results: What asks for results, and waits for them.
        tasks: What goes on beside, until the tracker is closed.
    """

    def __init__(self, port: ActionPort, hub: Hub, history: History, reasons: Later[GoalError]) -> None:
        self.live: dict[str, Goal] = {}
        self.taken_up: set[str] = set()
        self.on_return: Callable[[Goal], None] = lambda _: None
        self.on_end: list[Callable[[Goal], None]] = []
        self.last_heard = time.monotonic()
        self.port = port
        self.results = Results(port, self, reasons)
        self.tasks = Tasks("tracking goals")
        self._hub = hub
        self._history = history
        self._senders = Senders(history)
        self._ended: OrderedDict[str, Goal] = OrderedDict()
        self._held: dict[str, list[tuple[MakeEvent, Goal, int]]] = {}
        self._waiters: dict[str, asyncio.Event] = {}
        self._goal_heard: dict[str, float] = {}

    def running(self) -> list[Goal]:
        """The goals that have not ended, oldest first."""
        return [goal for goal in self.live.values() if not goal.status.terminal]

    def heard(self) -> None:
        """The action server gave a sign of life."""
        self.last_heard = time.monotonic()

    def silence_of(self, goal: Goal) -> float:
        """Seconds since there was news of this goal."""
        return time.monotonic() - self._goal_heard.get(goal.goal_id, self.last_heard)

    # ------------------------------------------------------------------ what ROS says

    def on_status(self, reports: list[StatusReport], stamp_ns: int) -> None:
        """A message of `_action/status`: the state of every goal that the server remembers."""
        self.heard()
        for report in reports:
            if report.goal_id in self._ended:
                continue
            goal = self.live.get(report.goal_id) or self._adopt(report.goal_id, report.accepted_ns or stamp_ns)
            if not report.status.terminal:
                accepted = report.status is GoalStatus.ACCEPTED
                self.move(goal, report.status, report.accepted_ns if accepted else stamp_ns)
            else:
                self.results.expect(goal, report.status, stamp_ns)
            self.results.request(goal)

    def on_feedback(self, goal_id: str, feedback: Json, stamp_ns: int) -> None:
        """A message of `_action/feedback`."""
        self.heard()
        if goal_id in self._ended:
            return
        goal = self.live.get(goal_id)
        if goal is None:
            goal = self._adopt(goal_id, stamp_ns)
            self.results.request(goal)
        if goal.status is GoalStatus.LOST:
            self.move(goal, GoalStatus.EXECUTING, stamp_ns)
        self._goal_heard[goal_id] = time.monotonic()
        goal.hear(feedback, utc_now())
        self._publish(feedback_event, goal, stamp_ns)

    def on_progress(self, goal: Goal, stage: str | None, retries: int | None, stamp_ns: int) -> None:
        """What the server says on `/diagnostics` of a goal that runs."""
        if not goal.status.terminal and goal.progress(stage, retries, utc_now()):
            self._publish_status(goal, stamp_ns)
            self._record(goal)

    # ------------------------------------------------------------------ goals

    def add(self, goal: Goal) -> None:
        """Track a goal that is being sent."""
        self.live[goal.goal_id] = goal
        self._publish_status(goal, nanoseconds(goal.created_at))  # before anything that the server says of it

    def _adopt(self, goal_id: str, created_ns: int) -> Goal:
        """Take up a goal that somebody else sent, or we before a restart; what is said of it waits for the history."""
        goal = Goal(goal_id, self.port.action_name, self.port.action_type, moment(created_ns), origin="external")
        self.live[goal_id] = goal
        self._held[goal_id] = []
        self.tasks.spawn(self._introduce(goal))
        return goal

    async def _introduce(self, goal: Goal) -> None:
        try:
            await self._senders.find(goal, self._remember)
        except Exception:
            log.exception("while looking up who sent goal %s", goal.goal_id)
        finally:
            log.info("goal %s on %s, origin %s", goal.goal_id, goal.action_name, goal.origin)
            self._publish_held(goal)
            self._history.record(goal)
        if goal.origin == "external" and await self._senders.find_late(goal) and goal.goal_id in self.live:
            self._publish_status(goal, time.time_ns())

    def _remember(self, goal: Goal, known: Goal) -> None:
        """Have a goal, and what is held back of it, take over what the history knows."""
        goal.remember(known)
        for _, then, _ in self._held.get(goal.goal_id, []):
            then.remember(known)

    def take_up(self, goal: Goal) -> None:
        """Go on with a goal that the history says was running; the server is asked for its outcome."""
        adopted = self.live.get(goal.goal_id)
        if adopted is not None and adopted.origin != goal.origin:  # the history was away when the goal turned up
            self._remember(adopted, goal)
            self._publish_status(adopted, time.time_ns())
        elif adopted is None and goal.goal_id not in self._ended:
            self.live[goal.goal_id] = goal
            self.taken_up.add(goal.goal_id)
            self.results.request(goal)
            log.info("taking up goal %s, %s", goal.goal_id, goal.status.value)

    def move(self, goal: Goal, status: GoalStatus, stamp_ns: int | None = None) -> None:
        """Move a goal on to a state that is not terminal, where that is not a step back."""
        was_lost = goal.status is GoalStatus.LOST
        self._goal_heard[goal.goal_id] = time.monotonic()
        if not goal.advance(status, utc_now()):
            return
        self._publish_status(goal, stamp_ns or time.time_ns())
        self._record(goal)
        if was_lost:
            log.info("goal %s is back", goal.goal_id)
            self.on_return(goal)

    def stall(self, goal: Goal, *, stalled: bool) -> None:
        """Show a goal as stalled, or no longer."""
        if goal.stalled is not stalled:
            goal.stalled = stalled
            self._publish_status(goal, time.time_ns())

    def lose(self, goal: Goal, error: GoalError) -> None:
        """The action server is gone. The goal stays in sight: it may return."""
        if not goal.advance(GoalStatus.LOST, utc_now()):
            return
        goal.error = error
        log.warning("goal %s is lost: %s", goal.goal_id, error.detail)
        self._publish_status(goal, time.time_ns())
        self._record(goal)
        self._release(goal)
        lost = [other for other in self.live.values() if other.status is GoalStatus.LOST]
        for oldest in lost[:-MAX_LOST]:
            self._retire(oldest)

    def end(
        self,
        goal: Goal,
        status: GoalStatus,
        *,
        result: Json | None = None,
        error: GoalError | None = None,
        stamp_ns: int | None = None,
    ) -> None:
        """The goal ended for good; `stamp_ns` is when the server said so."""
        late_result = goal.status is status and goal.result is None and result is not None
        if not late_result and not goal.advance(status, utc_now()):
            return
        goal.result = result
        goal.error = error if late_result else error or goal.error
        if late_result or not stamp_ns:  # an event of its own
            stamp_ns = time.time_ns()
        if not late_result:
            self._publish_status(goal, stamp_ns)
        if status is not GoalStatus.REJECTED:
            self._publish(result_event, goal, stamp_ns)
        self._record(goal)
        self._release(goal)
        self._retire(goal)

    def _publish_status(self, goal: Goal, stamp_ns: int) -> None:
        self._publish(status_event, goal, stamp_ns)

    def _publish(self, make: MakeEvent, goal: Goal, stamp_ns: int) -> None:
        held = self._held.get(goal.goal_id)
        if held is None:
            self._hub.publish(make(goal, stamp_ns))
        else:
            held.append((make, copy(goal), stamp_ns))

    def _record(self, goal: Goal) -> None:
        """Keep what is new about a goal; not before it is known who sent it, which is looked up in what is kept."""
        if goal.goal_id not in self._held:
            self._history.record(goal)

    def _publish_held(self, goal: Goal) -> None:
        """Publish what was held back: the goal as it was each time, and as what is known of its sender says now."""
        for make, then, stamp_ns in self._held.pop(goal.goal_id, []):
            then.attribute(goal)
            self._hub.publish(make(then, stamp_ns))
            goal.last_event_id = then.last_event_id

    def _retire(self, goal: Goal) -> None:
        self.live.pop(goal.goal_id, None)
        self.taken_up.discard(goal.goal_id)
        self._goal_heard.pop(goal.goal_id, None)
        self.results.retire(goal)
        for told in self.on_end:
            told(goal)
        self._ended[goal.goal_id] = goal
        if len(self._ended) > MAX_REMEMBERED:
            self.results.forget(self._ended.popitem(last=False)[0])

    # ------------------------------------------------------------------ waiting, and the end

    async def wait_terminal(self, goal: Goal, timeout: float) -> None:
        """Wait until the goal has ended, or the time is up, or the gateway closes."""
        if goal.status.terminal or self._hub.closing:
            return
        self.results.want(goal)
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
        """Let everyone who waits for a goal go."""
        for event in self._waiters.values():
            event.set()
        self._waiters.clear()

    async def close(self) -> None:
        """Stop waiting for anything."""
        self.release_all()
        await self.results.close()
        await self.tasks.close()
