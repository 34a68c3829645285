"""Automatic docking: checks the robots once a second, and docks those that a rule says should dock."""

import logging
import time
import uuid
from collections.abc import Coroutine
from datetime import datetime, timedelta

from dock_gateway.core.errors import Conflict, DockOccupied, GatewayError, Unavailable, is_by_stop
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.automation.activity import Activity
from dock_gateway.extensions.automation.decision import DecisionEntry, DecisionOutcome, WaitReason
from dock_gateway.extensions.automation.facts import FactReader
from dock_gateway.extensions.automation.policy import DockingPolicy, RobotFacts
from dock_gateway.extensions.automation.rule import RuleEntry
from dock_gateway.extensions.automation.rules import DockingRules
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.storage import History

log = logging.getLogger(__name__)

# Seconds between two checks of the robots.
INTERVAL = 1.0
# Checks between two reads of what other gateways have stored.
SYNC_EVERY = 2
# Seconds after which a rule tries again to dock a robot whose dock another robot had: it waits in that dock's queue.
ASK_AGAIN = 10.0
# How long after a decision without an outcome its gateway must have ended.
INTERRUPTED_AFTER = timedelta(minutes=1)


class AutomaticDocking:
    """Applies the rules to the robots, and sends the goals.

    Args:
        rules: The rules and their decisions.
        facts: Reads what the rules go by.
        activity: Since when robots stand still.
        actions: All actions.
        robot_actions: Which of them dock each robot.
        history: Finds goals that were sent before a restart.
        robots: All robots, whose missions are asked to let them charge.
        interval: See `INTERVAL`.
        sync_every: See `SYNC_EVERY`.
    """

    def __init__(
        self,
        rules: DockingRules,
        facts: FactReader,
        activity: Activity,
        *,
        actions: ActionRegistry,
        robot_actions: RobotActions,
        history: History,
        robots: RobotRegistry,
        interval: float = INTERVAL,
        sync_every: int = SYNC_EVERY,
    ) -> None:
        self._robots = robots
        self._interval = interval
        self._sync_every = sync_every
        self._rules = rules
        self._book = rules.book
        self._decisions = rules.decisions
        self._facts = facts
        self._activity = activity
        self._last_stops = rules.last_stops
        self._actions = actions
        self._robot_actions = robot_actions
        self._history = history
        self._policy = DockingPolicy()
        self._answers: bool | None = None  # whether the history does
        self._deciding: set[str] = set()  # robots
        self._occupied: dict[str, float] = {}  # when another robot had the dock of a robot
        self._checks = 0
        self._tasks = Tasks("docking automatically")

    def start(self) -> None:
        """Check the robots from now on."""
        self._tasks.repeat(self._check, self._interval, "checking which robots should dock")

    async def close(self) -> None:
        """Stop docking robots."""
        await self._tasks.close()

    def save_holds(self, _: str) -> None:
        """Store at once that a robot was stopped, or released: a gateway that is killed would forget it."""
        if self._last_stops.unsaved:
            self._tasks.spawn(self._last_stops.save())

    def on_end(self, goal: Goal) -> None:
        """Continue the automatic docking of a robot whose goal has succeeded, unless a rule or a mission sent it."""
        robot = self._robots.owner(goal.action_name)
        if robot is None or goal.status is not GoalStatus.SUCCEEDED or goal.origin == "automation":
            return
        if self._rules.holds(robot.namespace):
            self._tasks.spawn(self._allow(robot.namespace, goal.created_at))

    async def _allow(self, robot: str, since: datetime) -> None:
        try:
            await self._last_stops.allow(robot, since)
        except Unavailable as error:
            log.warning("the automatic docking of %s stays on hold: %s", robot, error)

    # ------------------------------------------------------------------ checking

    async def _check(self) -> None:
        if self._checks % self._sync_every == 0:
            await self._sync()
        self._checks += 1
        if not self._rules.any_on:
            self._activity.watch(set())
            self._rules.waits = {}
            return
        facts = self._facts.read()
        self._activity.keep(facts)
        decisions = self._decisions.all()
        verdict = self._policy.decide(self._book.all(), facts.values(), decisions, utc_now(), time.monotonic())
        self._rules.waits = verdict.waits
        self._activity.watch(verdict.watched)
        for robot, below in verdict.asked.items():
            self._robots.on_low_battery(robot, below)
        if not self._answers:
            self._rules.waits |= {
                (each.rule_id, each.robot): WaitReason.HISTORY_UNAVAILABLE for each in verdict.decisions
            }
            return
        self._decisions.close_series(verdict.recovered)
        for decision in verdict.decisions:
            if self._waits_for_dock(decision):
                self._rules.waits[decision.rule_id, decision.robot] = WaitReason.DOCK_OCCUPIED
                continue
            self._spawn(decision, self._carry_out(decision, self._book.get(decision.rule_id)))
        for identity, decision in self._decisions.interrupted(utc_now() - INTERRUPTED_AFTER).items():
            self._spawn(decision, self._resolve(identity, decision))

    def _waits_for_dock(self, decision: DecisionEntry) -> bool:
        """Return whether another robot had the dock of a robot a moment ago."""
        occupied = self._occupied.get(decision.robot)
        return (
            decision.outcome is DecisionOutcome.SENDING
            and decision.scheduled_at is None
            and occupied is not None
            and time.monotonic() - occupied < ASK_AGAIN
        )

    async def _sync(self) -> None:
        """Read the rules of other gateways, and their decisions and holds if these may count."""
        answers = await self._book.sync()
        if answers and self._rules.any_on:
            await self._last_stops.sync()
        if answers and (
            self._rules.any_on or self._checks == 0 or self._decisions.unsaved or self._decisions.given_up()
        ):
            answers = await self._decisions.sync()
        self._note_history(answers=answers)

    def _note_history(self, *, answers: bool) -> None:
        if not answers and self._answers is not False and self._rules.any_on:
            log.warning("the history does not answer: no automatic docking until it does")
        elif answers and self._answers is False and self._rules.any_on:
            log.info("the history answers again: automatic docking goes on")
        self._answers = answers

    # ------------------------------------------------------------------ carrying out

    def _spawn(self, decision: DecisionEntry, work: Coroutine[None, None, None]) -> None:
        """Work on a decision in the background, unless there is one about its robot that is being worked on."""
        if decision.robot in self._deciding:
            work.close()
            return
        self._deciding.add(decision.robot)
        self._tasks.spawn(work).add_done_callback(lambda _: self._deciding.discard(decision.robot))

    async def _carry_out(self, decision: DecisionEntry, rule: RuleEntry | None) -> None:
        identity = uuid.uuid4().hex
        try:
            await self._book.sync()
            if self._book.get(decision.rule_id) != rule:
                return  # another gateway has changed it, and the earlier decisions no longer count
            await self._decisions.claim(identity, decision)
            if decision.outcome is DecisionOutcome.SENDING:
                decision = await self._send(identity, decision)
            self._decisions.finish(identity, decision)
            await self._decisions.save()
        except DockOccupied:  # no attempt: it is decided again
            self._occupied[decision.robot] = time.monotonic()
            self._rules.waits[decision.rule_id, decision.robot] = WaitReason.DOCK_OCCUPIED
            self._decisions.put(identity, None)
            await self._decisions.save()
        except Conflict:
            await self._decisions.sync()
        except Unavailable:
            self._note_history(answers=False)

    async def _send(self, identity: str, decision: DecisionEntry) -> DecisionEntry:
        """Send the goal of a claimed decision, unless something has changed since; return what came of it.

        Raises:
            DockOccupied: Another robot has the dock, and the rule may wait for it.
        """
        await self._last_stops.sync()
        if not await self._book.sync():
            return decision.model_copy(update={"outcome": DecisionOutcome.REFUSED, "code": "history_unavailable"})
        # No wait from here to the submission, which notices every stop that comes later.
        robot = self._facts.read().get(decision.robot)
        obstacle = self._obstacle(decision, robot)
        if obstacle is not None:
            held = obstacle is WaitReason.STOP_LATCHED
            return decision.model_copy(
                update={
                    "outcome": DecisionOutcome.HELD if held else DecisionOutcome.SKIPPED,
                    "code": obstacle.value,
                    "detail": robot.stopped if robot is not None and held else None,
                }
            )
        try:
            action = self._actions.get(self._robot_actions.docking_pair(decision.robot).dock)
            if action is None:
                raise Unavailable(f"{decision.robot} has no docking server")
            message = action.read_docking_request()
            goal = await action.submitter.submit(message, _key(identity), sender=None)
        except DockOccupied as error:
            if decision.scheduled_at is None:
                raise
            return decision.model_copy(
                update={"outcome": DecisionOutcome.REFUSED, "code": error.code, "detail": error.detail}
            )
        except GatewayError as error:
            outcome = DecisionOutcome.HELD if is_by_stop(error) else DecisionOutcome.REFUSED
            goal_id = error.extra.get("goal_id")
            return decision.model_copy(
                update={"outcome": outcome, "code": error.code, "detail": error.detail, "goal_id": goal_id}
            )
        return decision.model_copy(update={"outcome": DecisionOutcome.SENT, "goal_id": goal.goal_id})

    def _obstacle(self, decision: DecisionEntry, robot: RobotFacts | None) -> WaitReason | None:
        if robot is None:
            return WaitReason.SERVER_UNAVAILABLE
        rule = self._book.get(decision.rule_id)
        return self._policy.obstacle(decision.rule_id, rule, robot, time.monotonic())

    async def _resolve(self, identity: str, decision: DecisionEntry) -> None:
        """Find out what came of a decision whose gateway has ended."""
        try:
            goal = await self._history.by_key(_key(identity))
        except Unavailable:
            return  # later
        if goal is not None and not goal.unsent:
            result = {"outcome": DecisionOutcome.SENT, "goal_id": goal.goal_id}
        else:
            detail = "the gateway ended before it sent the goal"
            result = {"outcome": DecisionOutcome.REFUSED, "code": "interrupted", "detail": detail}
        self._decisions.finish(identity, decision.model_copy(update=result))


def _key(identity: str) -> str:
    """Return the idempotency key of a decision's goal."""
    return f"automatic-docking-{identity}"
