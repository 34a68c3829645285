"""Finds the actions of a robot, those that dock and undock it among them, and the robot of an action."""

import logging
from collections.abc import Iterable, Iterator
from typing import Protocol

from dock_gateway.core.dock_adapters.catalog import ADAPTERS, DockingCatalog, DockingPair
from dock_gateway.core.filters import lineage, parent_of, prefix_of
from dock_gateway.core.goal import Verb
from dock_gateway.core.grant import Grant
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.namespace import read_namespace
from dock_gateway.robots.robots import RobotLabels, RobotNames
from dock_gateway.settings import Settings
from dock_gateway.storage import History

log = logging.getLogger(__name__)


class KnownAction(Protocol):
    """The part of an action that the choice of a robot's docking actions needs."""

    name: str
    type: str
    verb: Verb | None

    @property
    def family(self) -> str:
        """The family of its type: who defines it."""

    @property
    def on_graph(self) -> bool:
        """Whether it has a server, or had one a moment ago."""

    @property
    def busy(self) -> bool:
        """Whether a goal is running on it."""


class RobotActions:
    """Maps robots to their actions, and actions to their robots.

    It picks, for each robot, one of the actions that can dock it, and one of those that can undock it. An action with a
    running goal stays: a goal must not change the server that the robot's other goals are sent to. Otherwise the first
    one in the catalog's order that has a server is picked; for undocking, one of the same family as the docking action
    comes before it, as nav2's server remembers where it has docked the robot. If none has a server, the last one that
    was picked stays.

    Args:
        settings: Name the docking actions.
        robots: The robots on the graph.
        labels: The labels of robots, and their groups. A robot with a label need not be on the graph.
        history: Knows all actions that have had goals.

    Attributes:
        catalog: The docking actions that are looked for.
        on_change: Called with the namespace of a robot when another docking action is picked.
    """

    def __init__(self, settings: Settings, robots: RobotNames, labels: RobotLabels, history: History) -> None:
        self.catalog = DockingCatalog(settings)
        self.on_change = Listeners[[str]]("another docking action is picked")
        self._robots = robots
        self._labels = labels
        self._history = history
        self._actions: dict[str, KnownAction] = {}
        self._picked: dict[str, DockingPair] = {}

    # ------------------------------------------------------------------ the actions of a robot

    def add(self, action: KnownAction) -> None:
        """Take an action into account that the gateway has joined."""
        self._actions[action.name] = action

    def remove(self, name: str) -> None:
        """Take an action no longer into account."""
        del self._actions[name]

    def update(self) -> None:
        """Pick the docking actions of each robot; report changes."""
        robots = {self.catalog.robot_of(action.name, [action.type]) for action in self._actions.values() if action.verb}
        for robot in sorted(filter(None, robots)):
            pair, before = self.docking_pair(robot), self._picked.get(robot)
            if pair == before:
                continue
            self._picked[robot] = pair
            if any(map(self._on_graph, pair)):
                log.info("robot %s docks with %s, undocks with %s", robot, *map(self._describe, pair))
            self.on_change(robot)

    def forget(self, robot: str) -> None:
        """Forget what was picked for a robot that is gone."""
        self._picked.pop(robot, None)

    def docking_pair(self, robot: str) -> DockingPair:
        """Return the names of a robot's docking and undocking action, whether or not they have a server."""
        before = self._picked.get(robot)
        dock = self._pick("dock", robot)
        undock = self._pick("undock", robot, "" if dock is None else dock.family)
        return DockingPair(
            dock.name if dock else before.dock if before else self.catalog.names("dock", robot)[0],
            undock.name if undock else before.undock if before else self.catalog.names("undock", robot)[0],
        )

    def docking_name(self, verb: Verb, robot: str) -> str:
        """Return the name of one of the two."""
        dock, undock = self.docking_pair(robot)
        return dock if verb == "dock" else undock

    def docking_names(self, robot: str, *verbs: Verb) -> frozenset[str]:
        """Return the names of all actions that dock or undock a robot or may have done so; of one verb or of both."""
        return frozenset(
            name
            for verb in verbs or ADAPTERS
            for name in self.catalog.names(verb, robot)
            if (found := self._actions.get(name)) is None or found.verb == verb
        )

    def is_below(self, action_name: str, namespace: str) -> bool:
        """Return whether an action is one of the robots in a namespace or below, or one that all robots share."""
        return action_name in self.catalog.shared or self.catalog.place_of(action_name).startswith(prefix_of(namespace))

    def on_graph_below(self, namespace: str) -> bool:
        """Return whether an action that the gateway has joined is in a namespace or below."""
        return self._any_below(self._actions, namespace)

    async def had_goals(self, namespace: str) -> bool:
        """Return whether the history has goals of a namespace or below.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return self._any_below(await self._history.action_names(), namespace)

    def _any_below(self, names: Iterable[str], namespace: str) -> bool:
        prefix = prefix_of(namespace)
        return any(self.catalog.place_of(name).startswith(prefix) for name in names)

    def homed_in(self, robot: str | None) -> frozenset[str]:
        """Return the actions elsewhere that belong to robots in a namespace; none without one, as all are meant then.

        Raises:
            InvalidField: The namespace is not valid.
        """
        return frozenset() if robot is None else self.catalog.homed_in(read_namespace(robot))

    async def choose_actions(self, grant: Grant, group: str | None) -> frozenset[str] | None:
        """Return the actions that a grant covers, and whose robots are in a group now; None if that is every action.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        if group is None and not (grant.limited or grant.share):
            return None
        names = await self._history.action_names()
        chosen = frozenset(filter(grant.covers_action, names))
        if group is None:
            return chosen
        members, robots = self._labels.in_group(group), self.robots_of(names)
        return frozenset(name for name in chosen if robots[name] in members)

    # ------------------------------------------------------------------ the robot of an action

    def robots_of(self, action_names: Iterable[str]) -> dict[str, str]:
        """Return the robot of each action, also of those that have left the graph: the longest namespace containing it.

        A namespace with a label or with goals of a docking action is a robot, too, even if it is not on the graph now.
        An action in no robot's namespace belongs to the namespace that it is in.
        """
        names = frozenset(action_names)
        gone = {parent_of(name) for name in names if self._docks_in_its_namespace(name)}
        robots = gone.union(self._labels.robots(), self._robots.namespaces())
        return {name: self._robot_among(robots, name) for name in names}

    def _docks_in_its_namespace(self, name: str) -> bool:
        namespace = parent_of(name)
        return self.catalog.may_be_robot(namespace) and name in self.docking_names(namespace)

    def _robot_among(self, robots: set[str], action_name: str) -> str:
        namespace = parent_of(self.catalog.place_of(action_name))
        return next((each for each in reversed([*lineage(namespace)]) if each in robots), namespace)

    # ------------------------------------------------------------------ picking

    def _pick(self, verb: Verb, robot: str, family: str = "") -> KnownAction | None:
        candidates = [*self._candidates(verb, robot)]
        if busy := next((action for action in candidates if action.busy), None):
            return busy
        there = [action for action in candidates if action.on_graph]
        if family and there and not self.catalog.is_configured(verb, there[0].name):
            there.sort(key=lambda action: action.family != family)  # a stable sort
        return there[0] if there else None

    def _candidates(self, verb: Verb, robot: str) -> Iterator[KnownAction]:
        for name in self.catalog.names(verb, robot):
            action = self._actions.get(name)
            if action is not None and action.verb == verb:
                yield action

    def _on_graph(self, name: str) -> bool:
        return (action := self._actions.get(name)) is not None and action.on_graph

    def _describe(self, name: str) -> str:
        return f"{name} ({self._actions[name].type if self._on_graph(name) else 'no server'})"
