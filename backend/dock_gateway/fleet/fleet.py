"""The state of all robots: puts it together, and publishes its changes."""

import asyncio
import logging
from collections import defaultdict
from collections.abc import Iterable, Mapping
from datetime import datetime
from typing import Any

import orjson

from dock_gateway.core.event import fleet_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import parent_of
from dock_gateway.core.goal import Goal, GoalStatus, encode
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.narrowing import narrow_robots
from dock_gateway.core.tasks import cancel
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.robot_state import RobotState
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.hints import Join, Sight, find_join, split_robots
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.labels import Labels
from dock_gateway.robots.last_goals import LastGoals, latest
from dock_gateway.robots.registry import Robot, RobotRegistry
from dock_gateway.robots.simulator import Simulators
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

# Seconds between two checks for changes.
INTERVAL = 0.5


class Fleet:
    """Combines the state of each robot, and publishes changes while there are subscribers.

    Args:
        settings: Names.
        fanout: Receives events, and knows the subscribers.
        robots: The robots.
        actions: The actions.
        robot_actions: Which of them dock and undock each robot.
        hints: Which docking servers and batteries are on the graph.
        interlock: The latched stops.
        simulators: The simulators.
        last_goals: How docking and undocking goals ended.
        labels: The display names and groups.
        alerts: Checks the robots for alerts.
    """

    def __init__(
        self,
        settings: Settings,
        fanout: Fanout,
        *,
        robots: RobotRegistry,
        actions: ActionRegistry,
        robot_actions: RobotActions,
        hints: DockingHints,
        interlock: Interlock,
        simulators: Simulators,
        last_goals: LastGoals,
        labels: Labels,
        alerts: AlertBoard,
    ) -> None:
        self._settings = settings
        self._fanout = fanout
        self._robots = robots
        self._actions = actions
        self._robot_actions = robot_actions
        self._hints = hints
        self._interlock = interlock
        self._simulators = simulators
        self._last_goals = last_goals
        self._labels = labels
        self._alerts = alerts
        self._published: dict[str, bytes] = {}
        self._task = asyncio.create_task(self._run())

    # ------------------------------------------------------------------ state

    def states(self) -> list[RobotState]:
        """Return the current state of every robot, by name."""
        return self._see(self._robots.all())[0]

    def state(self, robot: str) -> RobotState | None:
        """Return the current state of a robot; None if there is none."""
        return self._see([self._robots.get(robot)])[0][0] if robot in self._robots else None

    def _see(self, robots: Iterable[Robot]) -> tuple[list[RobotState], list[Goal]]:
        """Return the current states of robots, and the lost goals on actions that belong to no robot."""
        running, lost = self._actions.running(), self._actions.lost()
        newest = _newest([*lost, *(goal for goal in running if goal.status is not GoalStatus.PENDING)])
        running_of, lost_of = self._by_robot(running), self._by_robot(lost)
        states = [
            self._state(robot, running_of.get(robot.namespace, []), lost_of.get(robot.namespace, []), newest)
            for robot in robots
        ]
        return states, self._unresolved(lost_of.get(None, []), frozenset(), newest)

    def _unresolved(self, lost: list[Goal], docking: frozenset[str], newest: Mapping[str, datetime]) -> list[Goal]:
        """Return the lost goals after which nothing has been learned of the robot.

        A later goal on the same action, or one that docks or undocks the robot, shows that an action server controls
        the robot again; if it is lost, too, it stands for both.

        Args:
            lost: The lost goals of a robot, or those of none.
            docking: The actions that dock and undock the robot.
            newest: By action, when the newest goal was sent that is lost, or that a server has accepted.
        """
        found = []
        for goal in lost:
            self._last_goals.watch(goal.action_name)
            names = docking | {goal.action_name}
            ran = self._last_goals.ran(*names)
            followed = any(newest.get(name, goal.created_at) > goal.created_at for name in names)
            if not followed and not (ran is not None and _ended_later(ran, goal)):
                found.append(goal)
        return found

    def _by_robot(self, goals: list[Goal]) -> dict[str | None, list[Goal]]:
        found: dict[str | None, list[Goal]] = defaultdict(list)
        for goal in sorted(goals, key=lambda goal: goal.created_at, reverse=True):
            owner = self._robots.owner(goal.action_name)
            found[None if owner is None else owner.namespace].append(goal)
        return found

    def _state(self, robot: Robot, running: list[Goal], lost: list[Goal], newest: Mapping[str, datetime]) -> RobotState:
        name = robot.namespace
        names = self._robot_actions.docking_pair(name)
        all_names = self._robot_actions.docking_names(name)
        dock, undock = self._actions.get(names.dock), self._actions.get(names.undock)
        simulator = self._simulators.find(name)
        ended = [goal for goal in lost if goal.action_name in all_names]
        succeeded = self._last_goals.succeeded(*all_names)
        return RobotState(
            name=name,
            label=self._labels.get(name),
            default=name == self._robots.default_namespace,
            battery=robot.battery,
            battery_topic=self._settings.battery_of(name),
            publisher=robot.publisher,
            stop=self._interlock.shown(name),
            simulator=None if simulator is None else simulator.document(),
            dock=None if dock is None else dock.watch.state,
            undock=None if undock is None else undock.watch.state,
            goals=running,
            lost=self._unresolved(lost, all_names, newest),
            last_goal=latest([self._last_goals.last(*all_names), *ended]),
            left_docked=None if succeeded is None else succeeded.verb == "dock",
        )

    def _duplicates(self) -> dict[str, list[str]]:
        """Return, by robot, the actions that have more than one server."""
        found: dict[str, list[str]] = defaultdict(list)
        for name in self._actions.duplicates():
            owner = self._robots.owner(name)
            found[parent_of(name) if owner is None else owner.namespace].append(name)
        return found

    def documents(self, namespace: str | None = None, grant: Grant = UNLIMITED) -> list[dict[str, Any]]:
        """Return the robots of a grant as `GET /robots` shows them, or only the one of a namespace.

        Raises:
            InvalidField: The namespace is not valid.
            NotFound: `robot_not_found`.
        """
        only = None if namespace is None else self._robots.get(namespace).namespace
        states = [state for state in self.states() if grant.covers_robot(state.name)]
        sights = self._hints.sights(grant)
        return [state.document(grant, _join(state, sights)) for state in states if only in (None, state.name)]

    # ------------------------------------------------------------------ publishing

    async def _run(self) -> None:
        while True:
            await asyncio.sleep(INTERVAL)
            try:
                self.update()
            except Exception:
                log.exception("while updating the overview of robots")

    def update(self) -> None:
        """Update the alerts; publish the robots that have changed, if there are subscribers."""
        states, strays = self._see(self._robots.all())
        sights = self._hints.sights()
        self._alerts.update(states, strays, self._duplicates(), split_robots(sights))
        if not self._fanout.watched("robots"):
            self._published = {}
            return
        now = {state.name: encode(state.document(join=_join(state, sights))) for state in states}
        changed = [orjson.Fragment(document) for name, document in now.items() if self._published.get(name) != document]
        gone = sorted(self._published.keys() - now.keys())
        self._published = now
        if changed or gone:
            self._fanout.publish(fleet_event("robots", utc_now(), narrow_robots, robots=changed, gone=gone))

    async def close(self) -> None:
        """Stop checking."""
        await cancel(self._task)


def _newest(goals: list[Goal]) -> dict[str, datetime]:
    """Return, by action, when the newest of these goals was sent."""
    found: dict[str, datetime] = {}
    for goal in goals:
        found[goal.action_name] = max(goal.created_at, found.get(goal.action_name, goal.created_at))
    return found


def _ended_later(goal: Goal, lost: Goal) -> bool:
    """Return whether a goal was sent after a lost one, and ended after that was lost."""
    ended, lost_at = goal.finished_at or goal.updated_at, lost.finished_at or lost.updated_at
    return goal.created_at > lost.created_at and ended > lost_at


def _join(state: RobotState, sights: list[Sight]) -> Join | None:
    """Return what would give a robot a docking server that has none, but a battery."""
    alone = state.battery.age is not None and (state.dock is None or not state.dock.available)
    return find_join(state.name, sights) if alone else None
