"""The states of all goals on one action: messages and requests in, changes and outputs out.

Pure: it knows no ROS, no task and no clock. Each input says when it happens, and adds to `outputs` what has to be done.
"""

import logging
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime
from enum import Enum, auto
from functools import partial

import orjson

from dock_gateway.core.dock_adapters.adapter import NO_REASON, DockAdapter
from dock_gateway.core.event import Event, Now, feedback_event, moment, nanoseconds, status_event
from dock_gateway.core.goal import NO_RESULT, Goal, GoalError, GoalStatus, Json, Origin, ResultAnswer
from dock_gateway.goals.adoption import Message, Newcomer, Newcomers
from dock_gateway.goals.limits import LIMITS, GoalLimits

log = logging.getLogger(__name__)

# Makes an event from a goal, the stamp of its id and the stamp of its source, in nanoseconds.
MakeEvent = Callable[[Goal, int, int], Event]


class GoalChange(Enum):
    """A change of a goal that other parts of the gateway react to.

    `SENT`: this process sends it. `SEEN`: it runs, which was not known so far. `RESUMED`: it is tracked again, as the
    history knows it. `CHANGED`: it has an event before its end. `LOST`, `RETURNED`: it was lost, or is back.
    `RETIRED`: no further events of it are expected.
    """

    SENT = auto()
    SEEN = auto()
    RESUMED = auto()
    CHANGED = auto()
    LOST = auto()
    RETURNED = auto()
    RETIRED = auto()


@dataclass(frozen=True, slots=True)
class PublishEvent:
    """Publish an event of a goal."""

    event: Event
    goal: Goal


@dataclass(frozen=True, slots=True)
class Store:
    """Store a goal as it is now."""

    goal: Goal


@dataclass(frozen=True, slots=True)
class AwaitResult:
    """Request a goal's result, unless that was done. `reported`: how and when it ended, if the server said so."""

    goal: Goal
    reported: tuple[GoalStatus, int] | None = None


@dataclass(frozen=True, slots=True)
class PublishEnd:
    """Store a goal and the events of its end, then publish these. `source_ns`: when it ended, in ns since 1970."""

    goal: Goal
    source_ns: int


@dataclass(frozen=True, slots=True)
class Notify:
    """Notify the parts that deal with goals."""

    news: GoalChange
    goal: Goal


Output = PublishEvent | Store | AwaitResult | PublishEnd | Notify


class GoalMachine:
    """Every goal on one action, from its first message to its end. Nothing else changes a goal's state.

    Args:
        action_name: Absolute name of the action.
        action_type: Its type.
        stamp: Returns the stamp of the next event's id from that of its source. Stamps rise.
        started: When the gateway started.
        adapter: What its messages say about a goal, if it docks or undocks robots.
        limits: How many goals to remember.

    Attributes:
        live: The running goals, and lost ones that may return.
        taken_up: Ids of goals from before a restart.
        unwanted: Why goals must not run, by their ids. A lost goal that returns in whatever state, even canceled
            already, has that error.
        newcomers: Unknown goals, which have to be looked up in the history.
        outputs: What has to be done, oldest first. The tracker removes each as it does it.
    """

    def __init__(
        self,
        action_name: str,
        action_type: str,
        stamp: Callable[[int], int],
        started: Now,
        adapter: DockAdapter | None = None,
        *,
        limits: GoalLimits = LIMITS,
    ) -> None:
        self.live: dict[str, Goal] = {}
        self.taken_up: set[str] = set()
        self.unwanted: dict[str, GoalError] = {}
        self.newcomers = Newcomers(limits)
        self.outputs: deque[Output] = deque()
        self._action = (action_name, action_type)
        self._adapter = adapter
        self._limits = limits
        self._verb = None if adapter is None else adapter.verb
        self._stamp = stamp
        self._started = moment(started.ns)
        self._ended: OrderedDict[str, None] = OrderedDict()
        self._heard_at: dict[str, float] = {}

    def running(self) -> list[Goal]:
        """Return the goals that have not ended, oldest first."""
        return [goal for goal in self.live.values() if not goal.status.terminal]

    def tracks(self, goal_id: str) -> bool:
        """Return whether a goal is tracked, or is being looked up; thread-safe."""
        return goal_id in self.live or goal_id in self.newcomers

    def ended(self, goal_id: str) -> bool:
        """Return whether the goal is known to have ended for good."""
        return goal_id in self._ended

    def heard_at(self, goal: Goal) -> float | None:
        """Return when the last news of a goal came, on the monotonic clock; None if there was none."""
        return self._heard_at.get(goal.goal_id)

    # ------------------------------------------------------------------ messages from the action server

    def report(self, now: Now, goal_id: str, status: GoalStatus, accepted_ns: int, stamp_ns: int) -> None:
        """Handle a goal's state in a message of `_action/status`."""
        take = partial(self._take_report, status, accepted_ns, stamp_ns)
        self._hear(now, goal_id, take, created_ns=accepted_ns or stamp_ns, running=not status.terminal)

    def feedback(self, now: Now, goal_id: str, feedback: Json, stamp_ns: int) -> None:
        """Handle a message of `_action/feedback`."""
        take = partial(self._take_feedback, feedback, stamp_ns)
        self._hear(now, goal_id, take, created_ns=stamp_ns, running=True)

    def progress(self, now: Now, goal: Goal, stage: str | None, retries: int | None, stamp_ns: int) -> None:
        """Handle the server's report on `/diagnostics` about a goal."""
        if not goal.status.terminal and goal.progress(stage, retries, moment(now.ns)):
            self._publish(status_event, goal, stamp_ns)
            self.outputs.append(Store(goal))

    def answered(self, now: Now, goal: Goal, answer: ResultAnswer, stamp_ns: int | None) -> None:
        """Handle the answer to a request for a goal's result; `stamp_ns` is when the server reported the goal's end.

        A goal that the server does not know is lost (`lose`).
        """
        status = answer.status
        if status is not None and status.terminal:
            status, error = self._judge(goal, status, answer)
            self.end(now, goal, status, result=answer.result, error=error, stamp_ns=stamp_ns)
        else:
            log.warning(
                "goal %s: ignored a result with the status %s, which does not end a goal",
                goal.goal_id,
                status and status.value,
                extra=_about(goal),
            )

    def _judge(self, goal: Goal, status: GoalStatus, answer: ResultAnswer) -> tuple[GoalStatus, GoalError | None]:
        """Return how a goal ended and why, according to its result, and note what that says about its retries."""
        error = answer.error
        if self._adapter is not None and answer.result is not None:
            outcome = self._adapter.outcome(status, orjson.loads(answer.result))
            if outcome.retries is not None and not goal.status.final:
                goal.retries = outcome.retries
            explained = error is not None and error.code != NO_REASON
            status, error = outcome.status, error if explained else outcome.error or error
        if error is not None and answer.remark and status is GoalStatus.ABORTED:
            error = replace(error, detail=f"{error.detail.rstrip('.')}. {answer.remark}")
        return status, error

    def _hear(self, now: Now, goal_id: str, take: Message, *, created_ns: int, running: bool) -> None:
        if (goal := self.live.get(goal_id)) is not None:
            take(now, goal)
        elif goal_id not in self._ended:
            self.newcomers.hear(goal_id, take, created_ns=created_ns, running=running, now=now.monotonic)

    def _take_report(self, status: GoalStatus, accepted_ns: int, stamp_ns: int, now: Now, goal: Goal) -> None:
        if status.terminal:
            self.outputs.append(AwaitResult(goal, reported=(status, stamp_ns)))
        else:
            self.move(now, goal, status, accepted_ns if status is GoalStatus.ACCEPTED else stamp_ns)
            self.outputs.append(AwaitResult(goal))

    def _take_feedback(self, feedback: Json, stamp_ns: int, now: Now, goal: Goal) -> None:
        progressed = self._note_progress(now, goal, feedback)
        if goal.status is GoalStatus.LOST or (goal.status is GoalStatus.PENDING and goal.origin == "external"):
            self.move(now, goal, GoalStatus.EXECUTING, stamp_ns)
        elif progressed:
            self._publish(status_event, goal, stamp_ns)
            self.outputs.append(Store(goal))
        self._heard_at[goal.goal_id] = now.monotonic
        goal.hear(feedback, moment(now.ns))
        self._publish(feedback_event, goal, stamp_ns)

    def _note_progress(self, now: Now, goal: Goal, feedback: Json) -> bool:
        """Note the stage and the retries in feedback; return whether they changed."""
        if self._adapter is None or not self._adapter.tells_stage:
            return False
        stage, retries = self._adapter.progress(orjson.loads(feedback))
        return goal.progress(stage, retries, moment(now.ns))

    # ------------------------------------------------------------------ new goals

    def new_goal(self, goal_id: str, created_at: datetime, origin: Origin) -> Goal:
        """Return a new goal on this action, which is not tracked yet."""
        return Goal(goal_id, *self._action, created_at, origin, self._verb)

    def add(self, now: Now, goal: Goal) -> None:
        """Track a goal that is being sent."""
        self._track(goal)
        self.taken_up.discard(goal.goal_id)
        if goal.status is GoalStatus.LOST:  # it is being sent again
            self.move(now, goal, GoalStatus.PENDING)
        else:
            self._publish(status_event, goal, nanoseconds(goal.created_at))  # before any message from the server
        self.outputs.append(Notify(GoalChange.SENT, goal))

    def take_up(self, now: Now, goal: Goal) -> None:
        """Resume tracking a goal that was running according to the history."""
        adopted = self.live.get(goal.goal_id)
        if adopted is None and goal.goal_id not in self._ended:
            self.taken_up.add(goal.goal_id)
            self._begin(now, goal, self.newcomers.claim(goal.goal_id), runs=not goal.status.terminal)
        elif adopted is not None and adopted.origin != goal.origin:  # the history was away at first
            adopted.remember(goal)
            self._publish(status_event, adopted, now.ns)
            self.outputs.append(Store(adopted))

    def adopt(self, now: Now, goal_id: str, known: Goal | None) -> None:
        """Track a newcomer, using its entry in the history if there is one. Leave an ended goal as it is.

        If it ended since this gateway started and another gateway saw that, publish the end to our readers, too.
        """
        if (newcomer := self.newcomers.claim(goal_id)) is None:
            return  # it has become known since
        if known is not None and known.status.final:
            self._note_ended(goal_id)
            if known.finished_at is not None and known.finished_at > self._started:
                self.outputs.append(PublishEnd(known, now.ns))
            return
        goal = known or self.new_goal(goal_id, moment(newcomer.created_ns), "external")
        self._begin(now, goal, newcomer, runs=newcomer.running)

    def _begin(self, now: Now, goal: Goal, newcomer: Newcomer | None, *, runs: bool) -> None:
        self._track(goal)
        goal.verb = goal.verb or self._verb  # an older gateway that shares the history stores none
        before = goal.status
        for take in newcomer.messages if newcomer else ():
            take(now, goal)
        self.outputs.append(AwaitResult(goal))
        if runs and (goal.status is before or before is not GoalStatus.PENDING):
            self.outputs.append(Notify(GoalChange.SEEN, goal))

    def _track(self, goal: Goal) -> None:
        log.info(
            "goal %s on %s, %s, origin %s",
            goal.goal_id,
            goal.action_name,
            goal.status.value,
            goal.origin,
            extra=_about(goal),
        )
        self.live[goal.goal_id] = goal

    # ------------------------------------------------------------------ changes

    def accept(self, now: Now, goal: Goal, stamp_ns: int) -> None:
        """Note that the action server accepted a goal."""
        self.move(now, goal, GoalStatus.ACCEPTED, stamp_ns)
        self.outputs.append(AwaitResult(goal))

    def move(self, now: Now, goal: Goal, status: GoalStatus, stamp_ns: int | None = None) -> None:
        """Move a goal to a state that is not terminal, unless that is a step back."""
        before = goal.status
        if goal.goal_id in self.live:
            self._heard_at[goal.goal_id] = now.monotonic
        if not self._advance(now, goal, status):
            return
        self._publish(status_event, goal, stamp_ns or now.ns)
        self.outputs.append(Store(goal))
        if before is GoalStatus.PENDING:
            self.outputs.append(Notify(GoalChange.SEEN, goal))
        elif before is GoalStatus.LOST:
            log.info("goal %s is no longer lost", goal.goal_id, extra=_about(goal))
            self.outputs.append(Notify(GoalChange.RETURNED, goal))

    def stall(self, now: Now, goal: Goal, *, stalled: bool) -> None:
        """Set or clear a goal's `stalled` flag."""
        if goal.stalled is not stalled:
            goal.stalled = stalled
            self._publish(status_event, goal, now.ns)

    def explain(self, _: Now, goal: Goal, error: GoalError | None) -> None:
        """Set why a goal that has not ended will not succeed; None: it may. It is published with the next change."""
        if not goal.status.terminal and goal.error != error:
            goal.error = error
            self.outputs.append(Store(goal))  # another gateway, or this one after a restart, cancels it for that

    def lose(self, now: Now, goal: Goal, error: GoalError) -> None:
        """Mark a goal as lost because the action server is gone. It stays tracked, as it may return."""
        if not goal.lose(error, moment(now.ns)):
            return
        log.warning("goal %s is lost: %s", goal.goal_id, error.detail, extra=_about(goal))
        self._publish(status_event, goal, now.ns)
        self.outputs += [Store(goal), Notify(GoalChange.LOST, goal)]
        lost = [other for other in self.live.values() if other.status is GoalStatus.LOST]
        for oldest in lost[: -self._limits.lost]:
            self._retire(oldest)

    def end(
        self,
        now: Now,
        goal: Goal,
        status: GoalStatus,
        *,
        result: Json | None = None,
        error: GoalError | None = None,
        stamp_ns: int | None = None,
    ) -> None:
        """End a goal for good; `stamp_ns` is when the server reported it."""
        if not self._advance(now, goal, status):
            if goal.status is status and goal.result is None and result is not None:  # a late result
                goal.result, goal.error = result, _reason(goal, error)
                self.outputs.append(Store(goal))
            return
        goal.result = result
        goal.error = _reason(goal, error)
        reason = f": {goal.error.code}, {goal.error.detail}" if goal.error else ""
        log.info("goal %s %s%s", goal.goal_id, status.value, reason, extra=_about(goal))
        self.outputs.append(PublishEnd(goal, stamp_ns or now.ns))
        self._retire(goal)
        self._note_ended(goal.goal_id)

    def _advance(self, now: Now, goal: Goal, status: GoalStatus) -> bool:
        """Move a goal on to `status`; return False where that would be a step back."""
        was_lost = goal.status is GoalStatus.LOST
        if not goal.advance(status, moment(now.ns)):
            return False
        if was_lost:
            goal.error = self.unwanted.get(goal.goal_id)
        return True

    def _publish(self, make: MakeEvent, goal: Goal, source_ns: int) -> None:
        self.outputs.append(PublishEvent(make(goal, self._stamp(source_ns), source_ns), goal))

    def _retire(self, goal: Goal) -> None:
        self.live.pop(goal.goal_id, None)
        self.taken_up.discard(goal.goal_id)
        self._heard_at.pop(goal.goal_id, None)
        self.outputs.append(Notify(GoalChange.RETIRED, goal))

    def _note_ended(self, goal_id: str) -> None:
        self._ended[goal_id] = None
        if len(self._ended) > self._limits.ended:
            self._ended.popitem(last=False)


def _reason(goal: Goal, error: GoalError | None) -> GoalError | None:
    """Return why a goal ended as it did. Why it was canceled outweighs that its result is missing."""
    if goal.status is GoalStatus.SUCCEEDED or goal.error is None or goal.error.code == NO_RESULT:
        return error
    missing = error is not None and error.code == NO_RESULT
    return goal.error if error is None or (missing and goal.status is GoalStatus.CANCELED) else error


def _about(goal: Goal) -> dict[str, str]:
    """Return the fields of a log line about a goal."""
    return {"goal_id": goal.goal_id}
