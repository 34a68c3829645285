"""Which action docks each robot, and which one undocks it: picked by what is on the ROS graph."""

import logging
from collections.abc import Callable, Iterator, Mapping
from typing import Protocol

from dock_gateway.core.dock_adapters.catalog import ADAPTERS, DockingCatalog, DockingPair
from dock_gateway.core.goal import Verb

log = logging.getLogger(__name__)


class DockingAction(Protocol):
    """What the choice depends on."""

    name: str
    type: str
    verb: Verb | None

    @property
    def family(self) -> str:
        """Who defines its type."""

    @property
    def on_graph(self) -> bool:
        """Whether it has a server, or had one a moment ago."""

    @property
    def busy(self) -> bool:
        """Whether a goal is running on it."""


class DockingActions:
    """Picks, for each robot, one of the actions that can dock it, and one of those that can undock it.

    An action with a running goal stays: a goal must not change the server that others of its robot are sent to.
    Otherwise the first one in the catalog's order that has a server is picked; for undocking, one of the same family
    as the docking action comes before it, as nav2's server remembers where it has docked the robot. If none has a
    server, the last one that was picked stays.

    Args:
        catalog: The actions that are looked for.
        actions: All known actions, by name.

    Attributes:
        on_change: Called with the namespace of a robot when another action is picked.
    """

    def __init__(self, catalog: DockingCatalog, actions: Mapping[str, DockingAction]) -> None:
        self.catalog = catalog
        self.on_change: list[Callable[[str], None]] = []
        self._actions = actions
        self._picked: dict[str, DockingPair] = {}

    def of(self, namespace: str) -> DockingPair:
        """Return the names of a robot's docking and undocking action, whether or not they have a server."""
        before = self._picked.get(namespace)
        dock = self._pick("dock", namespace)
        undock = self._pick("undock", namespace, "" if dock is None else dock.family)
        return DockingPair(
            dock.name if dock else before.dock if before else self.catalog.names("dock", namespace)[0],
            undock.name if undock else before.undock if before else self.catalog.names("undock", namespace)[0],
        )

    def name(self, verb: Verb, namespace: str) -> str:
        """Return the name of one of the two."""
        dock, undock = self.of(namespace)
        return dock if verb == "dock" else undock

    def all_names(self, namespace: str, *verbs: Verb) -> frozenset[str]:
        """Return the names of all actions that dock or undock a robot or may have done so; of one verb or of both."""
        return frozenset(
            name
            for verb in verbs or ADAPTERS
            for name in self.catalog.names(verb, namespace)
            if (found := self._actions.get(name)) is None or found.verb == verb
        )

    def _pick(self, verb: Verb, namespace: str, family: str = "") -> DockingAction | None:
        offered = [*self._offered(verb, namespace)]
        if busy := next((action for action in offered if action.busy), None):
            return busy
        there = [action for action in offered if action.on_graph]
        if family and there and not self.catalog.is_configured(verb, there[0].name):
            there.sort(key=lambda action: action.family != family)  # a stable sort
        return there[0] if there else None

    def _offered(self, verb: Verb, namespace: str) -> Iterator[DockingAction]:
        for name in self.catalog.names(verb, namespace):
            action = self._actions.get(name)
            if action is not None and action.verb == verb:
                yield action

    def update(self) -> None:
        """Note what is picked now for each robot; report changes."""
        robots = {self.catalog.robot_of(action.name, [action.type]) for action in self._actions.values() if action.verb}
        for namespace in sorted(filter(None, robots)):
            pair, before = self.of(namespace), self._picked.get(namespace)
            if pair == before:
                continue
            self._picked[namespace] = pair
            if any(map(self._on_graph, pair)):
                log.info("robot %s docks with %s, undocks with %s", namespace, *map(self._describe, pair))
            for listener in self.on_change:
                listener(namespace)

    def _on_graph(self, name: str) -> bool:
        return (action := self._actions.get(name)) is not None and action.on_graph

    def _describe(self, name: str) -> str:
        return f"{name} ({self._actions[name].type if self._on_graph(name) else 'no server'})"

    def forget(self, namespace: str) -> None:
        """Forget what was picked for a robot that is gone."""
        self._picked.pop(namespace, None)
