"""Automatic docking: checks the robots once a second, and docks those that a rule says should dock."""

import asyncio
import logging
import time
import uuid
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from datetime import timedelta
from typing import Any

from dock_gateway.core.battery import PowerSupply
from dock_gateway.core.errors import Conflict, GatewayError, Unavailable, is_by_stop
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import GoalStatus
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.tasks import Tasks
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.automation.activity import Activity
from dock_gateway.extensions.automation.decision import DecisionEntry, DecisionOutcome, RuleMode, WaitReason
from dock_gateway.extensions.automation.decisions import DecisionLog
from dock_gateway.extensions.automation.policy import DockingPolicy, RobotFacts
from dock_gateway.extensions.automation.rule import RuleEntry
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.fleet.robot_state import CHARGES, RobotState
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedBook

log = logging.getLogger(__name__)

# Seconds between two checks of the robots.
INTERVAL = 1.0
MAX_RULES = 50
# Looks between two reads of what other gateways have stored.
SYNC_EVERY = 2
# How long after a decision without an outcome its gateway must have ended.
INTERRUPTED_AFTER = timedelta(minutes=1)
# Seconds for which the battery of a docked robot must be discharging until the robot counts as off its charger.
OFF_CHARGER = 30.0


class AutomaticDocking:
    """Applies the rules to the robots, and sends the goals.

    Args:
        fleet: The state of the robots.
        actions: All actions.
        robot_actions: Which of them dock each robot.
        history: Finds goals that were sent before a restart.
        activity: Since when robots stand still.
        rules: The rules.
        decisions: The decisions.
        shared: Returns the robots that may be other names of one robot.
        at_work: Returns whether a robot has work that must not be interrupted.
    """

    def __init__(
        self,
        fleet: Fleet,
        actions: ActionRegistry,
        robot_actions: RobotActions,
        history: History,
        *,
        activity: Activity,
        rules: SharedBook[RuleEntry],
        decisions: DecisionLog,
        shared: Callable[[], Collection[str]] = frozenset,
        at_work: Callable[[str], bool] = lambda _: False,
        interval: float = INTERVAL,
        sync_every: int = SYNC_EVERY,
    ) -> None:
        self._interval = interval
        self._sync_every = sync_every
        self._fleet = fleet
        self._actions = actions
        self._robot_actions = robot_actions
        self._history = history
        self._activity = activity
        self._rules = rules
        self.decisions = decisions
        self._shared = shared
        self._at_work = at_work
        self._policy = DockingPolicy()
        self._waits: dict[tuple[str, str], WaitReason] = {}
        self._answers: bool | None = None  # whether the history does
        self._off_since: dict[str, float] = {}  # docked robots whose batteries discharge
        self._deciding: set[str] = set()  # robots
        self._evaluations = 0
        self._tasks = Tasks("docking automatically")

    def start(self) -> None:
        """Check the robots from now on."""
        self._tasks.spawn(self._run())

    # ------------------------------------------------------------------ rules

    async def documents(self, grant: Grant = UNLIMITED) -> list[dict[str, Any]]:
        """Return the rules as `GET /automation/rules` shows them, by name.

        A limited grant gets those that apply to its robots, or name one of them, without the other robots.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        rules = await self._rules.read()
        states = self._fleet.states()
        if grant.limited:
            states = [state for state in states if grant.covers_robot(state.name)]
            groups = {group for state in states for group in state.label.groups}
            rules = {key: _narrow(rule, grant, groups) for key, rule in rules.items()}
            rules = {key: rule for key, rule in rules.items() if rule.robots.names or _applies(rule, states)}
        return [
            self._document(rule_id, rule, states)
            for rule_id, rule in sorted(rules.items(), key=lambda item: (item[1].name.casefold(), item[0]))
        ]

    async def document(self, rule_id: str, grant: Grant = UNLIMITED) -> dict[str, Any]:
        """Return a rule as `GET /automation/rules/{rule_id}` shows it.

        Raises:
            NotFound: There is none, or it is not about robots of the grant (`rule_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        for rule in await self.documents(grant):
            if rule["id"] == rule_id:
                return rule
        raise self._rules.missing(rule_id)

    async def replace(
        self, rule_id: str, rule: RuleEntry, condition: Condition = UNCONDITIONAL
    ) -> tuple[dict[str, Any], bool]:
        """Store a rule, new or changed; return it, and whether it is new. It starts from the beginning with each robot.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            Conflict: `limit_reached`.
            Unavailable: The history does not answer (`history_unavailable`); the rule is what it was.
        """
        new = await self._rules.replace(rule_id, rule, condition=condition)
        log.info("rule %s (%r) of automatic docking: %s, by %s", rule_id, rule.name, rule.mode.value, rule.changed_by)
        await self._begin_anew(rule_id)
        return self._document(rule_id, rule, self._fleet.states()), new

    async def remove(self, rule_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a rule.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: `rule_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the rule is still there.
        """
        await self._rules.remove(rule_id, condition)
        log.info("rule %s of automatic docking removed", rule_id)
        await self._begin_anew(rule_id)

    async def _begin_anew(self, rule_id: str) -> None:
        self._waits = {key: wait for key, wait in self._waits.items() if key[0] != rule_id}
        await self.decisions.sync()
        self.decisions.close_rule(rule_id)
        await self.decisions.save()

    def _document(self, rule_id: str, rule: RuleEntry, states: list[RobotState]) -> dict[str, Any]:
        default = WaitReason.OFF if rule.mode is RuleMode.OFF else WaitReason.DECIDING
        return {
            "id": rule_id,
            "etag": self._rules.etag(rule),
            **rule.model_dump(),
            "applies_to": [
                {"robot": state.name, "waits_for": self._waits.get((rule_id, state.name), default).value}
                for state in states
                if _applies(rule, [state])
            ],
        }

    # ------------------------------------------------------------------ checking

    async def _run(self) -> None:
        while True:
            try:
                await self._evaluate()
            except Exception:
                log.exception("while checking which robots should dock")
            await asyncio.sleep(self._interval)

    async def _evaluate(self) -> None:
        if self._evaluations % self._sync_every == 0:
            answers = await self._rules.sync()
            if answers and (
                self._active or self._evaluations == 0 or self.decisions.unsaved or self.decisions.given_up()
            ):
                answers = await self.decisions.sync()
            self._heard(answers=answers)
        self._evaluations += 1
        if not self._active:
            self._activity.watch(set())
            self._waits = {}
            return
        states = self._fleet.states()
        self._activity.keep({state.name for state in states})
        facts = self._facts(states)
        verdict = self._policy.decide(self._rules.all(), facts, self.decisions.all(), utc_now(), time.monotonic())
        self._waits = verdict.waits
        self._activity.watch(verdict.watched)
        if not self._answers:
            self._waits |= {(each.rule_id, each.robot): WaitReason.HISTORY_UNAVAILABLE for each in verdict.decisions}
            return
        self.decisions.close_series(verdict.recovered)
        for decision in verdict.decisions:
            if decision.robot not in self._deciding:
                self._deciding.add(decision.robot)
                self._tasks.spawn(self._carry_out(decision, self._rules.get(decision.rule_id)))
        for identity, decision in self.decisions.interrupted(utc_now() - INTERRUPTED_AFTER).items():
            if decision.robot not in self._deciding:
                self._deciding.add(decision.robot)
                self._tasks.spawn(self._resolve(identity, decision))

    @property
    def _active(self) -> bool:
        return any(rule.mode is not RuleMode.OFF for rule in self._rules.all().values())

    def _heard(self, *, answers: bool) -> None:
        if not answers and self._answers is not False and self._active:
            log.warning("the history does not answer: no automatic docking until it does")
        elif answers and self._answers is False and self._active:
            log.info("the history answers again: automatic docking goes on")
        self._answers = answers

    def _facts(self, states: list[RobotState]) -> list[RobotFacts]:
        servers = Counter(state.dock.action_name for state in states if state.dock is not None and _is_there(state))
        return [self._facts_of(state, servers) for state in states]

    def _facts_of(self, state: RobotState, servers: Mapping[str, int]) -> RobotFacts:
        name, reading, server = state.name, state.battery.reading, state.dock
        heard = state.battery.age is not None
        fresh = heard and state.battery.stale_since is None
        if state.goals or state.lost:
            self._activity.active(name)
        last = state.last_goal
        failed = last is not None and last.status is not GoalStatus.SUCCEEDED
        return RobotFacts(
            name=name,
            groups=tuple(state.label.groups),
            heard=heard or (server is not None and server.available),
            fresh=fresh,
            battery=reading.percentage,
            docked=(state.on_dock and not self._left_charger(state, fresh))
            or (fresh and reading.power_supply in CHARGES),
            reachable=server is not None and server.available and server.answering and not server.duplicate,
            shares_dock=server is not None and (servers.get(server.action_name, 0) > 1 or name in self._shared()),
            goal_running=bool(state.goals),
            goal_lost=bool(state.lost),
            at_work=self._at_work(name),
            stopped=_stopped(state.stop),
            still_since=self._activity.still_since(name),
            person_at=self._activity.person_at(name),
            failed_at=last.finished_at if last is not None and failed else None,
        )

    def _left_charger(self, state: RobotState, fresh: bool) -> bool:
        """Whether a robot that a goal has left docked has been off its charger for a while, as after it has slid off.

        A battery that takes no current is NOT_CHARGING on its dock; one that is DISCHARGING has no charger, or a dead
        one.
        """
        touches = state.simulator is not None and state.simulator["contact"]
        if touches or not fresh or state.battery.reading.power_supply != PowerSupply.DISCHARGING:
            self._off_since.pop(state.name, None)
            return False
        now = time.monotonic()
        return now - self._off_since.setdefault(state.name, now) >= OFF_CHARGER

    # ------------------------------------------------------------------ carrying out

    async def _carry_out(self, decision: DecisionEntry, rule: RuleEntry | None) -> None:
        identity = uuid.uuid4().hex
        try:
            await self._rules.sync()
            if self._rules.get(decision.rule_id) != rule:
                return  # another gateway has changed it, and the earlier decisions no longer count
            await self.decisions.claim(identity, decision)
            if decision.outcome is DecisionOutcome.SENDING:
                decision = await self._send(identity, decision)
            self.decisions.finish(identity, decision)
            await self.decisions.save()
        except Conflict:
            await self.decisions.sync()
        except Unavailable:
            self._heard(answers=False)
        finally:
            self._deciding.discard(decision.robot)

    async def _send(self, identity: str, decision: DecisionEntry) -> DecisionEntry:
        """Send the goal of a claimed decision, unless something has changed since; return what came of it."""
        if not await self._rules.sync():
            return decision.model_copy(update={"outcome": DecisionOutcome.REFUSED, "code": "history_unavailable"})
        # No wait from here to the submission, which notices every stop that comes later.
        facts = {robot.name: robot for robot in self._facts(self._fleet.states()) if robot.name == decision.robot}
        obstacle = self._obstacle(decision, facts)
        if obstacle is not None:
            held = obstacle is WaitReason.STOP_LATCHED
            return decision.model_copy(
                update={
                    "outcome": DecisionOutcome.HELD if held else DecisionOutcome.SKIPPED,
                    "code": obstacle.value,
                    "detail": facts[decision.robot].stopped if held else None,
                }
            )
        try:
            action = self._actions.get(self._robot_actions.docking_pair(decision.robot).dock)
            if action is None:
                raise Unavailable(f"{decision.robot} has no docking server")
            message = action.read_docking_request()
            goal = await action.submitter.submit(message, _key(identity), sender=None)
        except GatewayError as error:
            outcome = DecisionOutcome.HELD if is_by_stop(error) else DecisionOutcome.REFUSED
            goal_id = error.extra.get("goal_id")
            return decision.model_copy(
                update={"outcome": outcome, "code": error.code, "detail": error.detail, "goal_id": goal_id}
            )
        return decision.model_copy(update={"outcome": DecisionOutcome.SENT, "goal_id": goal.goal_id})

    def _obstacle(self, decision: DecisionEntry, facts: Mapping[str, RobotFacts]) -> WaitReason | None:
        rule, robot = self._rules.all().get(decision.rule_id), facts.get(decision.robot)
        if robot is None:
            return WaitReason.SERVER_UNAVAILABLE
        return self._policy.obstacle(decision.rule_id, rule, robot, time.monotonic())

    async def _resolve(self, identity: str, decision: DecisionEntry) -> None:
        """Find out what came of a decision whose gateway has ended."""
        try:
            goal = await self._history.by_key(_key(identity))
            if goal is not None and not goal.unsent:
                decision = decision.model_copy(update={"outcome": DecisionOutcome.SENT, "goal_id": goal.goal_id})
            else:
                detail = "the gateway ended before it sent the goal"
                decision = decision.model_copy(
                    update={"outcome": DecisionOutcome.REFUSED, "code": "interrupted", "detail": detail}
                )
            self.decisions.finish(identity, decision)
        except Unavailable:
            return  # later
        finally:
            self._deciding.discard(decision.robot)

    async def close(self) -> None:
        """Stop docking robots."""
        await self._tasks.close()


def _key(identity: str) -> str:
    """Return the idempotency key of a decision's goal."""
    return f"automatic-docking-{identity}"


def _is_there(state: RobotState) -> bool:
    """Return whether a robot is there: the one of the settings is always known."""
    return not state.default or state.battery.age is not None


def _stopped(stop: Mapping[str, Any]) -> str | None:
    if not stop["latched"]:
        return None
    by = f" by {stop['by']}" if stop["by"] else ""
    return f"stopped{by} at {stop['stopped_at']:%H:%M:%S} UTC"


def _narrow(rule: RuleEntry, grant: Grant, groups: Collection[str]) -> RuleEntry:
    """Return a rule without the robots beyond a grant, and without groups that have none of its robots."""
    chosen = {
        "names": tuple(filter(grant.covers_robot, rule.robots.names)),
        "groups": tuple(group for group in rule.robots.groups if group in groups),
    }
    return rule.model_copy(update={"robots": rule.robots.model_copy(update=chosen)})


def _applies(rule: RuleEntry, states: Iterable[RobotState]) -> bool:
    """Return whether a rule applies to any of these robots."""
    return any(rule.robots.covers(state.name, tuple(state.label.groups)) for state in states)
