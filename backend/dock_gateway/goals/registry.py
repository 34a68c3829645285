"""All actions on the ROS graph: registered when they appear, removed when they are gone."""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from dock_gateway.core.discovery import Discovery
from dock_gateway.core.errors import GatewayError, NotFound, NotInstalled
from dock_gateway.core.event import status_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import is_hidden, parent_of
from dock_gateway.core.goal import LOST_FOR, Goal, GoalError, GoalStatus, Verb
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.listeners import Hooks, Listeners
from dock_gateway.core.share import EVERYTHING, Share
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.action import FORGET_AFTER, Action
from dock_gateway.goals.action_context import ActionContext, BeforeSend, Gate
from dock_gateway.goals.action_document import Uninstalled
from dock_gateway.goals.expected_goals import ExpectedGoals
from dock_gateway.goals.goal_machine import GoalChange, GoalMachine
from dock_gateway.goals.goal_publisher import GoalPublisher
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.goals.liveness import ServerState
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.goals.tracker import BeforeLost, about_to_be_lost
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.action_port import ActionKind, ActionPort
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import Scan
from dock_gateway.settings import Settings
from dock_gateway.storage import History

log = logging.getLogger(__name__)


class DockingServerStates(NamedTuple):
    """The states of a robot's docking and undocking servers."""

    dock: ServerState
    undock: ServerState


class ActionRegistry:
    """All known actions.

    Args:
        settings: Names and deadlines.
        bridge: Runs calls on the ROS thread.
        fanout: Receives events.
        history: Stores goals.
        reasons: Why goals were rejected or aborted.
        interlock: The latched stops.
        robots: All robots.
        robot_actions: The robots of the actions, and which of these dock and undock them.
        share: The robots whose actions these are.
        limits: How long to wait for what is not yet known of goals.
        forget_after: Seconds after which an action that is off the graph is removed.

    Attributes:
        robot_actions: The robots of the actions.
        remarks: Each returns what is wrong around the robot of an action, or "": added to the reason of goals that are
            aborted.
        before_send: Called and awaited before each goal is sent through the gateway; what it raises refuses the goal.
        gates: Called and awaited with each goal before it is stored and sent, whoever sends it; what one raises refuses
            the goal, and what it returns are other fields for its message.
        before_lost: Called with a goal of any action that is about to be lost; what was done is added to the reason.
        on_sent: Called with a goal of any action when this gateway sends it.
        on_change: Called with a goal of any action after each of its events before its end.
        on_end: Called with a goal of any action when no further events of it are expected.
        on_lost: Called with a goal of any action that is lost. It may return.
    """

    def __init__(
        self,
        settings: Settings,
        bridge: Bridge,
        fanout: Fanout,
        history: History,
        reasons: PendingFacts[GoalError],
        *,
        interlock: Interlock,
        robots: RobotRegistry,
        robot_actions: RobotActions,
        share: Share = EVERYTHING,
        limits: GoalLimits = LIMITS,
        forget_after: float = FORGET_AFTER,
    ) -> None:
        self._settings = settings
        self._bridge = bridge
        self._robots = robots
        self.robot_actions = robot_actions
        self._catalog = robot_actions.catalog
        self._share = share
        self._forget_after = forget_after
        self.remarks = Hooks[Callable[[str], str]]()
        self.before_send = Hooks[BeforeSend]()
        self.before_lost = Hooks[BeforeLost]()
        self.gates = Hooks[Gate]()
        self._context = ActionContext(
            settings, fanout, history, reasons, interlock, limits, self.before_send, self.before_lost, self.gates
        )
        self.on_sent = Listeners[[Goal]]("a goal is sent")
        self.on_change = Listeners[[Goal]]("a goal has changed")
        self.on_end = Listeners[[Goal]]("a goal has ended")
        self.on_lost = Listeners[[Goal]]("a goal is lost")
        self._publisher = GoalPublisher(fanout, history)
        interlock.on_heard.append(self._hear_stop)
        interlock.on_latch.append(self._cancel_under)
        fanout.on_close.append(self._release_all)
        self._actions: dict[str, Action] = {}
        self._configured_namespace = parent_of(settings.resolve("dock"))
        self._pinned: set[str] = set()
        self._types: dict[str, list[str]] = {}  # on the graph, by action
        self._discovery = Discovery("action", settings.max_actions, "max_actions")
        self._changed = asyncio.Event()
        self._expected = ExpectedGoals()
        self._started = time.monotonic()
        self._dropped_before = self._ignored_before = 0  # on actions that have been removed

    def expect(self, goals: list[Goal]) -> None:
        """Take over goals that were running when the gateway ended, each once, when its action appears.

        A goal that was lost for longer than `LOST_FOR` is taken over only if it is seen again.
        """
        for goal in goals:
            if not self._share.covers(goal.action_name):
                continue
            if goal.status is GoalStatus.LOST and utc_now() - goal.updated_at > LOST_FOR:
                continue
            if action := self._actions.get(goal.action_name):
                action.tracker.take_up(goal)
            else:
                self._expected.add(goal)

    async def pin(self, verb: Verb) -> None:
        """Join the preferred docking or undocking action of the configured robot, and keep it even without a server.

        Raises:
            Unavailable: The ROS thread is down.
        """
        preferred = self._catalog.preferred(verb)
        name = self._catalog.names(verb)[0]
        self._pinned.add(name)
        try:
            await self.open(name, preferred.likely_type)
        except (ImportError, TypeError) as error:
            log.warning("the settings name %s, which is probably %s: %s", name, preferred.likely_type, error)

    async def open(self, name: str, type_name: str) -> Action:
        """Join an action.

        Args:
            name: Absolute name of the action.
            type_name: Its type, from the graph or from the settings, never from a client.

        Raises:
            ImportError: The type's package is not installed.
            TypeError: The type has fields that a .msg file cannot have.
            Unavailable: The ROS thread is down.
        """
        kind = await asyncio.to_thread(ActionKind, type_name)
        port = await self._bridge.call(lambda: ActionPort(self._bridge, name, kind), undo=ActionPort.close)
        found = self._catalog.find(name, [type_name])
        adapter = None if found is None else found[0]
        robot = self._catalog.robot_of(name, [type_name])
        action = Action(
            port,
            self._context,
            adapter=adapter,
            remark=lambda: " ".join(filter(None, (remark(name) for remark in self.remarks))),
            default_dock=self._context.settings.default_dock_of(robot or self._configured_namespace),
            pinned=name in self._pinned,
            ping_idle=name in self._pinned or robot == self._configured_namespace,
        )
        for news, listeners in (
            (GoalChange.SENT, self.on_sent),
            (GoalChange.CHANGED, self.on_change),
            (GoalChange.RETIRED, self.on_end),
            (GoalChange.LOST, self.on_lost),
        ):
            action.tracker.on[news].append(listeners)
        self._actions[name] = action
        self.robot_actions.add(action)
        expected = self._expected.take(name)
        try:
            for goal in expected:
                action.tracker.take_up(goal)
            tracker = action.tracker
            await self._bridge.call(
                lambda: port.listen(tracker.on_status, tracker.on_feedback, action.on_loss, tracker.known)
            )
        except BaseException:
            await self._forget(action)
            self.expect(expected)
            raise
        log.info("action %s (%s)", name, type_name)
        return action

    async def update(self, scan: Scan) -> bool:
        """Add actions that appeared, remove those that are gone; return whether some are still to be added.

        Raises:
            Unavailable: The ROS thread is down.
        """
        scan = replace(scan, actions={name: types for name, types in scan.actions.items() if self._share.covers(name)})
        self._types = scan.actions
        leaving = set[str]()  # ROS has to let go of a name before it takes it with another type
        for action in list(self._actions.values()):
            if types := scan.actions.get(action.name):
                action.last_seen = time.monotonic()
            unseen = action.unseen_for > self._forget_after and not action.pinned
            replaced = types is not None and action.type not in types and not self._is_fixed(action)
            # A lost goal may return, but not to a server of another type.
            expected = any(not (replaced and goal.status.terminal) for goal in action.tracker.live.values())
            if (unseen or replaced) and not expected:
                if types is not None and replaced:
                    log.warning("action %s was of type %s, and is now of type %s", action.name, action.type, types[0])
                await self._forget(action)
                leaving.add(action.name)
        if self._expected and time.monotonic() - self._started > self._forget_after:
            self._give_up()
        self._discovery.keep(scan.actions)
        new = [name for name in scan.actions if name not in self._actions and name not in leaving]
        new.sort(key=lambda name: (self._catalog.find(name, scan.actions[name]) is None, is_hidden(name)))
        try:
            more = await self._discovery.take_up(new, self._actions, self._take_up)
            return more or not leaving.isdisjoint(scan.actions)
        finally:
            self.robot_actions.update()
            self._changed.set()
            self._changed.clear()

    def _give_up(self) -> None:
        """Mark goals whose action has not come back as lost, until it does."""
        for goal in self._expected:
            if goal.status.terminal:
                continue
            error = GoalError("action_server_lost", "the action has no server any more")
            goal.lose(about_to_be_lost(goal, error, self.before_lost), utc_now())
            self._publisher.publish_now(status_event, goal)
            self.on_lost(goal)

    async def _take_up(self, name: str) -> None:
        types = self._types[name]
        type_name = self._type_of(name)
        if len(types) > 1:
            log.warning("action %s has more than one type: %s; using %s", name, ", ".join(types), type_name)
        await self.open(name, type_name)

    def _is_fixed(self, action: Action) -> bool:
        """Return whether the settings fix the type of an action, whatever is on the graph."""
        verb = action.verb
        return verb is not None and action.pinned and self._catalog.preferred(verb).strict

    def _type_of(self, name: str) -> str:
        """Return the type of an action on the graph. If it has several, which is a mistake, prefer the expected one."""
        found = self._catalog.find(name, self._types[name])
        return self._types[name][0] if found is None else found[1]

    async def _forget(self, action: Action) -> None:
        log.info("action %s left the ROS graph", action.name)
        del self._actions[action.name]
        self.robot_actions.remove(action.name)
        self._dropped_before += action.feedback_dropped
        self._ignored_before += action.unknown_goals_ignored
        await action.close()
        self._bridge.to_ros(action.port.close)

    def all(self) -> list[Action]:
        """Return the actions that can be used, sorted by name."""
        return sorted(self._actions.values(), key=lambda action: action.name)

    def uninstalled(self) -> list[Uninstalled]:
        """Return the actions on the graph that cannot be used, sorted by name."""
        failed = sorted(self._discovery.failed.items())
        return [Uninstalled(name, self._type_of(name), self._verb_of(name), failure.why) for name, failure in failed]

    def _verb_of(self, name: str) -> Verb | None:
        found = self._catalog.find(name, self._types[name])
        return None if found is None else found[0].verb

    def get(self, name: str) -> Action | None:
        """Return an action by its absolute name, or None if it is unknown or cannot be used."""
        return self._actions.get(name)

    def under(self, namespace: str) -> list[Action]:
        """Return the actions of a robot: those in its namespace or below it, and those that all robots share."""
        return [action for action in self.all() if self.robot_actions.is_below(action.name, namespace)]

    def _hear_stop(self, namespace: str) -> None:
        for action in self.under(namespace):
            action.delivery.stop()

    def _cancel_under(self, namespace: str) -> None:
        for action in self.under(namespace):
            action.delivery.stop()
            action.canceler.cancel_unwanted()

    async def find(self, name: str) -> Action:
        """Return an action by its absolute name, waiting for it to appear.

        Raises:
            NotFound: `action_not_found`: it has no server.
            ServedElsewhere: Its robot is not one of this gateway's.
            NotInstalled: It cannot be used; the detail says why.
        """
        self._share.require(name, f"the action {name[:100]}")
        try:
            async with asyncio.timeout(self._settings.server_wait):
                while name not in self._actions and name not in self._discovery.failed:
                    await self._changed.wait()
        except TimeoutError:
            raise NotFound(f"there is no server for the action {name}", code="action_not_found") from None
        self._require_installed(name)
        return self._actions[name]

    async def find_docking(self, verb: Verb, robot: str | None = None, grant: Grant = UNLIMITED) -> Action:
        """Return the action that docks or undocks a robot, waiting for one to appear; default: the configured robot.

        It may be another one than when the request was authorized.

        Raises:
            NotFound: There is no such robot (`robot_not_found`), or it has no such action (`action_not_found`).
            NotAllowed: The grant does not cover the action (`not_allowed`).
            ServedElsewhere: The robot is not one of this gateway's.
            NotInstalled: It cannot be used; the detail says why.
        """
        namespace = self._robots.get(robot).namespace
        try:
            async with asyncio.timeout(self._settings.server_wait):
                while (action := self._actions.get(self.robot_actions.docking_name(verb, namespace))) is None:
                    for name in self._discovery.failed.keys() & self.robot_actions.docking_names(namespace, verb):
                        if self._verb_of(name) == verb:
                            self._require_installed(name)
                    await self._changed.wait()
        except TimeoutError:
            name = self.robot_actions.docking_name(verb, namespace)
            raise NotFound(f"there is no server for the action {name}", code="action_not_found") from None
        grant.require_action(action.name)
        return action

    def _require_installed(self, name: str) -> None:
        if failure := self._discovery.failed.get(name):
            detail = f"{name} is of type {self._type_of(name)}: {failure.why}"
            raise NotInstalled(detail)

    def goal(self, goal_id: str) -> Goal | None:
        """Return a running or lost goal of any action."""
        return next((goal for action in self._actions.values() if (goal := action.tracker.live.get(goal_id))), None)

    def action_of(self, goal_id: str) -> str | None:
        """Return the name of the action of a goal that this process knows."""
        goal = self.goal(goal_id)
        return None if goal is None else goal.action_name

    def on_progress(self, goal_id: str, stage: str | None, retries: int | None, stamp_ns: int) -> None:
        """Store the progress of a goal that its action server reported."""
        for action in self._actions.values():
            if goal := action.tracker.live.get(goal_id):
                action.tracker.apply(GoalMachine.progress, goal, stage, retries, stamp_ns)

    def servers_of(self, namespace: str) -> DockingServerStates:
        """Return the states of a robot's docking and undocking servers, even if they have never been seen."""
        names = self.robot_actions.docking_pair(namespace)
        return DockingServerStates(self._server(names.dock), self._server(names.undock))

    def _server(self, name: str) -> ServerState:
        if action := self._actions.get(name):
            return action.watch.state
        found = self._catalog.find(name)
        return ServerState(name, "" if found is None else found[1], available=False, answering=False)

    def verb_of(self, name: str) -> Verb | None:
        """Return whether an action docks or undocks a robot; None if it does neither, or is unknown."""
        action = self._actions.get(name)
        return None if action is None else action.verb

    def running(self) -> list[Goal]:
        """Return the running goals of all actions."""
        return [goal for action in self._actions.values() for goal in action.tracker.running()]

    def lost(self) -> list[Goal]:
        """Return the lost goals that may return, of all actions, including those that have not come back."""
        known = (goal for action in self._actions.values() for goal in action.tracker.live.values())
        return [goal for goal in (*known, *self._expected) if goal.status is GoalStatus.LOST]

    @property
    def feedback_dropped(self) -> int:
        """Number of feedback messages of all actions not read since the gateway started."""
        return self._dropped_before + sum(action.feedback_dropped for action in self._actions.values())

    @property
    def unknown_goals_ignored(self) -> int:
        """Number of messages of all actions about too many unknown goals since the gateway started."""
        return self._ignored_before + sum(action.unknown_goals_ignored for action in self._actions.values())

    def duplicates(self) -> list[str]:
        """Return the names of the actions with more than one action server."""
        return [name for name, action in self._actions.items() if action.watch.state.duplicate]

    def _release_all(self) -> None:
        """Wake every caller that waits for a goal, as the gateway is about to close."""
        for action in self._actions.values():
            action.tracker.release_all()

    async def close(self) -> None:
        """Close every action."""
        for action in self.all():
            try:
                await action.close()
            except GatewayError as error:
                log.debug("while closing %s: %s", action.name, error)
        await self._publisher.drain()
