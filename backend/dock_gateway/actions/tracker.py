"""Turns messages from ROS into changes of goals, events for the hub and entries in the history.

Runs on the event loop only, and waits for nothing but the action server.
"""

import asyncio
import logging
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable
from functools import partial
from weakref import WeakValueDictionary

from dock_gateway.actions.adoption import Adoption, Message, Newcomer
from dock_gateway.actions.results import Results
from dock_gateway.core.event import Event, feedback_event, moment, nanoseconds, result_event, status_event, utc_now
from dock_gateway.core.goal import Goal, GoalError, GoalStatus, Json
from dock_gateway.core.hub import Hold, Hub
from dock_gateway.core.tasks import PendingFacts, Tasks
from dock_gateway.history import History
from dock_gateway.ros.action_port import ActionPort
from dock_gateway.ros.status import StatusReport

log = logging.getLogger(__name__)

# Maximum number of ids of ended goals kept, as an action server may go on reporting them for a while.
MAX_REMEMBERED = 10_000
MAX_LOST = 100
# Maximum seconds that later events are held back while a result is awaited.
RESERVE_FOR = 1.0

# Makes an event from a goal, the stamp of its id and the stamp of its source, in nanoseconds.
MakeEvent = Callable[[Goal, int, int], Event]


class GoalTracker:
    """Every goal on one action, from its first message to its end.

    Args:
        port: The action.
        hub: Receives events.
        history: Stores goals.
        reasons: Why goals were rejected or aborted.

    Attributes:
        live: The running goals, and lost ones that may return.
        taken_up: Ids of goals from before a restart.
        on_return: Called with a `lost` goal that shows signs of life.
        on_seen: Called with a running goal that this process did not send, when it is first seen.
        on_end: Called with a goal of which no further events are expected.
        last_heard: When the action server last gave a sign of life, on the monotonic clock.
        results: Requests results and waits for them.
        tasks: Background tasks, which run until the tracker is closed.
    """

    def __init__(self, port: ActionPort, hub: Hub, history: History, reasons: PendingFacts[GoalError]) -> None:
        self.live: dict[str, Goal] = {}
        self.taken_up: set[str] = set()
        self.on_return: Callable[[Goal], None] = lambda _: None
        self.on_seen: list[Callable[[Goal], None]] = []
        self.on_end: list[Callable[[Goal], None]] = []
        self.last_heard = time.monotonic()
        self.port = port
        self.results = Results(port, self, reasons)
        self.tasks = Tasks("tracking goals")
        self._hub = hub
        self._history = history
        self._adoption = Adoption(history, self._adopt)
        self._seals = Tasks("storing how goals ended")
        self._ended: OrderedDict[str, None] = OrderedDict()
        self._places: dict[str, Hold] = {}
        self._started = utc_now()
        self._waiters: WeakValueDictionary[str, asyncio.Event] = WeakValueDictionary()  # held by the waiting callers
        self._goal_heard: dict[str, float] = {}

    def running(self) -> list[Goal]:
        """Return the goals that have not ended, oldest first."""
        return [goal for goal in self.live.values() if not goal.status.terminal]

    def heard(self) -> None:
        """Note that the action server gave a sign of life."""
        self.last_heard = time.monotonic()

    def silence_of(self, goal: Goal) -> float:
        """Return the seconds since the last news of this goal."""
        return time.monotonic() - self._goal_heard.get(goal.goal_id, self.last_heard)

    # ------------------------------------------------------------------ messages from ROS

    def on_status(self, reports: list[StatusReport], stamp_ns: int) -> None:
        """Handle a message of `_action/status`: the states of the goals that the server remembers."""
        self.heard()
        for report in reports:
            take = partial(self._take_report, report=report, stamp_ns=stamp_ns)
            running = not report.status.terminal
            if not running:
                self._reserve(report.goal_id, stamp_ns)
            self._hear(report.goal_id, take, created_ns=report.accepted_ns or stamp_ns, running=running)

    def on_feedback(self, goal_id: str, feedback: Json, stamp_ns: int) -> None:
        """Handle a message of `_action/feedback`."""
        self.heard()
        take = partial(self._take_feedback, feedback=feedback, stamp_ns=stamp_ns)
        self._hear(goal_id, take, created_ns=stamp_ns, running=True)

    def on_progress(self, goal: Goal, stage: str | None, retries: int | None, stamp_ns: int) -> None:
        """Handle the server's report on `/diagnostics` about a running goal."""
        if not goal.status.terminal and goal.progress(stage, retries, utc_now()):
            self._publish(status_event, goal, stamp_ns)
            self._history.record(goal)

    def _hear(self, goal_id: str, take: Message, *, created_ns: int, running: bool) -> None:
        if (goal := self.live.get(goal_id)) is not None:
            take(goal)
        elif goal_id not in self._ended:
            self._adoption.hear(goal_id, take, created_ns=created_ns, running=running)

    def _take_report(self, goal: Goal, report: StatusReport, stamp_ns: int) -> None:
        if report.status.terminal:
            self.results.expect(goal, report.status, stamp_ns)
        else:
            self.move(goal, report.status, report.accepted_ns if report.status is GoalStatus.ACCEPTED else stamp_ns)
        self.results.request(goal)

    def _take_feedback(self, goal: Goal, feedback: Json, stamp_ns: int) -> None:
        if goal.status.final:
            return
        if goal.status is GoalStatus.LOST or (goal.status is GoalStatus.PENDING and goal.origin == "external"):
            self.move(goal, GoalStatus.EXECUTING, stamp_ns)
        self._goal_heard[goal.goal_id] = time.monotonic()
        goal.hear(feedback, utc_now())
        self._publish(feedback_event, goal, stamp_ns)

    # ------------------------------------------------------------------ goals

    def add(self, goal: Goal) -> None:
        """Track a goal that is being sent."""
        self.live[goal.goal_id] = goal
        self.taken_up.discard(goal.goal_id)
        if goal.status is GoalStatus.LOST:  # it is being sent again
            self.move(goal, GoalStatus.PENDING)
        else:
            self._publish(status_event, goal, nanoseconds(goal.created_at))  # before any message from the server

    def take_up(self, goal: Goal) -> None:
        """Resume tracking a goal that was running according to the history, and request its result."""
        adopted = self.live.get(goal.goal_id)
        if adopted is None and goal.goal_id not in self._ended:
            self.taken_up.add(goal.goal_id)
            self._begin(goal, self._adoption.claim(goal.goal_id), runs=not goal.status.terminal)
        elif adopted is not None and adopted.origin != goal.origin:  # the history was away at first
            adopted.remember(goal)
            self._publish(status_event, adopted, time.time_ns())
            self._history.record(adopted)

    def _adopt(self, goal_id: str, known: Goal | None, newcomer: Newcomer) -> None:
        """Track a goal that this process did not send, using its entry in the history. Leave an ended goal as it is.

        If it ended since this gateway started and another gateway saw that, publish the end to our readers, too.
        """
        if known is not None and known.status.final:
            self._note_ended(goal_id)
            if known.finished_at is not None and known.finished_at > self._started:
                self._tell_end(known, time.time_ns())
            self._let_go(goal_id)
            return
        created_at = moment(newcomer.created_ns)
        goal = known or Goal(goal_id, self.port.action_name, self.port.action_type, created_at, origin="external")
        self._begin(goal, newcomer.messages, runs=newcomer.running)

    def _begin(self, goal: Goal, messages: Iterable[Message], *, runs: bool) -> None:
        log.info("goal %s on %s, %s, origin %s", goal.goal_id, goal.action_name, goal.status.value, goal.origin)
        self.live[goal.goal_id] = goal
        for take in messages:
            take(goal)
        self.results.request(goal)
        if runs:
            for seen in self.on_seen:
                seen(goal)

    def move(self, goal: Goal, status: GoalStatus, stamp_ns: int | None = None) -> None:
        """Move a goal to a state that is not terminal, unless that is a step back."""
        was_lost = goal.status is GoalStatus.LOST
        if goal.goal_id in self.live:
            self._goal_heard[goal.goal_id] = time.monotonic()
        if not goal.advance(status, utc_now()):
            return
        self._publish(status_event, goal, stamp_ns or time.time_ns())
        self._history.record(goal)
        if was_lost:
            log.info("goal %s is back", goal.goal_id)
            self.on_return(goal)

    def stall(self, goal: Goal, *, stalled: bool) -> None:
        """Set or clear a goal's `stalled` flag."""
        if goal.stalled is not stalled:
            goal.stalled = stalled
            self._publish(status_event, goal, time.time_ns())

    def lose(self, goal: Goal, error: GoalError) -> None:
        """Mark a goal as lost because the action server is gone. It stays tracked, as it may return."""
        if not goal.lose(error, utc_now()):
            return
        log.warning("goal %s is lost: %s", goal.goal_id, error.detail)
        self._publish(status_event, goal, time.time_ns())
        self._history.record(goal)
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
        """End a goal for good; `stamp_ns` is when the server reported it. The end is stored, then published."""
        if not goal.advance(status, utc_now()):
            if goal.status is status and goal.result is None and result is not None:  # a late result
                goal.result, goal.error = result, error
                self._history.record(goal)
            return
        goal.result = result
        goal.error = error or (None if status is GoalStatus.SUCCEEDED else goal.error)
        source_ns = stamp_ns or time.time_ns()
        self._history.record(goal)
        self._tell_end(goal, source_ns)
        self._retire(goal)
        self._note_ended(goal.goal_id)

    def _tell_end(self, goal: Goal, source_ns: int) -> None:
        """Store the events of the end, then publish them: as stored, if another gateway was first."""
        place = self._places.pop(goal.goal_id, None) or self._hub.hold(source_ns)
        end = [status_event(goal, place.stamp, source_ns)]
        if goal.status is not GoalStatus.REJECTED:
            end.append(result_event(goal, place.stamp, source_ns))
        self._seals.spawn(self._seal(goal, end, place))

    def _reserve(self, goal_id: str, stamp_ns: int) -> None:
        """Hold back later events until the result of an ended goal has arrived.

        Needed only if another gateway may publish the end first: a reader that moves there must not have received
        later events here.
        """
        if self._history.shared and goal_id not in self._ended and goal_id not in self._places:
            self._places[goal_id] = self._hub.hold(stamp_ns)
            asyncio.get_running_loop().call_later(RESERVE_FOR, self._expire, goal_id)

    def _expire(self, goal_id: str) -> None:
        if goal_id in self._places:
            log.warning("goal %s: what follows its end is told before it; its result is awaited", goal_id)
            self._let_go(goal_id)

    def _let_go(self, goal_id: str) -> None:
        """Publish the events held back, as the result is late or has been published before."""
        if (place := self._places.pop(goal_id, None)) is not None:
            place.release()

    async def _seal(self, goal: Goal, end: list[Event], place: Hold) -> None:
        told = end
        try:
            told = await self._history.seal(goal, end)
        finally:
            place.release(told)
            if told[-1].id != goal.last_event_id:
                goal.last_event_id = told[-1].id
                self._history.record(goal)
            self._release(goal)

    def _publish(self, make: MakeEvent, goal: Goal, source_ns: int) -> None:
        self._hub.publish(make(goal, self._hub.clock.stamp(source_ns), source_ns))

    def _retire(self, goal: Goal) -> None:
        self.live.pop(goal.goal_id, None)
        self.taken_up.discard(goal.goal_id)
        self._goal_heard.pop(goal.goal_id, None)
        self.results.retire(goal)
        for told in self.on_end:
            told(goal)

    def _note_ended(self, goal_id: str) -> None:
        self._ended[goal_id] = None
        if len(self._ended) > MAX_REMEMBERED:
            self._ended.popitem(last=False)

    # ------------------------------------------------------------------ waiting, and the end

    async def wait_terminal(self, goal: Goal, timeout: float) -> None:
        """Wait until the goal has ended or the gateway closes, at most `timeout` seconds."""
        if goal.status.terminal or self._hub.closing:
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
        await self._adoption.close()
        await self.results.close()
        await self._seals.drain()
        await self.tasks.close()
