"""The types of docking actions in their order of preference, and the names under which they are looked for."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from dock_gateway.core.dock_adapters import charging_dock, create3, nav2
from dock_gateway.core.dock_adapters.adapter import DockAdapter
from dock_gateway.core.filters import is_hidden, is_under, parent_of
from dock_gateway.core.goal import Verb
from dock_gateway.settings import Settings

# The preferred family first.
ADAPTERS: dict[Verb, tuple[DockAdapter, ...]] = {
    "dock": (charging_dock.DOCK, nav2.DOCK, create3.DOCK),
    "undock": (charging_dock.UNDOCK, nav2.UNDOCK, create3.UNDOCK),
}
# Robots whose names are remembered.
MAX_ROBOTS = 4096


class DockingPair(NamedTuple):
    """Absolute names of the docking and the undocking action of a robot."""

    dock: str
    undock: str


@dataclass(frozen=True)
class Candidate:
    """An action that can be behind `/dock` or `/undock`.

    Attributes:
        name: Its name; relative to the robot's namespace, unless it begins with a slash.
        likely_type: Its type, if its name tells.
        strict: Whether an action of another type is a different action.
        configured: Whether the settings name it.
        robot: The only robot whose action it is, if the settings say that.
    """

    name: str
    likely_type: str
    strict: bool
    configured: bool = False
    robot: str | None = None

    def matches(self, action_name: str, types: Collection[str] | None) -> bool:
        """Return whether an action on the graph is this one. `types` is None if its type is not known."""
        named = action_name == self.name or action_name.endswith(f"/{self.name}")
        return named and (not self.strict or types is None or self.likely_type in types)

    def namespace_of(self, action_name: str) -> str | None:
        """Return the namespace of the robot that an action of this name belongs to; None if of all robots."""
        if self.robot is not None:
            return self.robot
        return None if self.name.startswith("/") else action_name.removesuffix(f"/{self.name}") or "/"

    def type_among(self, types: Collection[str] | None) -> str:
        """Return its type: of the types on the graph, the likely one if it is there."""
        return self.likely_type if not types or self.likely_type in types else next(iter(types))


def adapter_for(verb: Verb, action_type: str) -> DockAdapter:
    """Return the adapter for a type."""
    return next((adapter for adapter in ADAPTERS[verb] if adapter.action_type == action_type), DockAdapter(verb))


class DockingCatalog:
    """Knows the actions that dock and undock robots, by name and type: those in the settings, and those of `ADAPTERS`.

    `dock`, `undock` and the like are names that other actions may have, too: there the type has to match. Every
    action with one of our own names, and every configured one, is what its name says.

    A robot's namespace is not hidden, unless it is the configured one: relays such as TurtleBot 4's offer the actions
    of a robot a second time in a hidden namespace, which is not a second robot.

    Attributes:
        shared: The actions that all robots share: those with an absolute name.
        homes: The robots of the actions that the settings name for single robots.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._configured_namespace = parent_of(settings.resolve("dock"))
        configured: dict[Verb, tuple[str, str]] = {
            "dock": (settings.dock_action, settings.dock_action_type),
            "undock": (settings.undock_action, settings.undock_action_type),
        }
        self._candidates = {verb: _candidates(verb, *names) for verb, names in configured.items()}
        own: dict[Verb, dict[str, str]] = {
            "dock": settings.own_actions("dock"),
            "undock": settings.own_actions("undock"),
        }
        self._own = {
            (verb, robot): Candidate(name, _likely_type(verb, name), strict=False, configured=True, robot=robot)
            for verb, names in own.items()
            for robot, name in names.items()
        }
        self.homes = {name: robot for names in own.values() for robot, name in names.items()}
        every = (each.name for candidates in self._candidates.values() for each in candidates)
        self.shared = frozenset(name for name in every if name.startswith("/"))
        self.names = lru_cache(MAX_ROBOTS)(self._names)

    def find(self, action_name: str, types: Collection[str] | None = None) -> tuple[DockAdapter, str] | None:
        """Return the adapter of an action and its type, or None if it neither docks nor undocks a robot.

        Args:
            action_name: Absolute name of the action.
            types: Its types on the graph; more than one is a fault there. None if they are not known.
        """
        for verb, candidate in self._matching(action_name, types):
            action_type = candidate.type_among(types)
            return adapter_for(verb, action_type), action_type
        return None

    def robot_of(self, action_name: str, types: Collection[str]) -> str | None:
        """Return the namespace of the robot that an action docks or undocks; None if of none, or of all of them."""
        for _, candidate in self._matching(action_name, types):
            return candidate.namespace_of(action_name)
        return None

    def _matching(self, action_name: str, types: Collection[str] | None) -> Iterator[tuple[Verb, Candidate]]:
        for (verb, _), candidate in self._own.items() if action_name in self.homes else ():
            if candidate.name == action_name:
                yield verb, candidate
        for verb, candidates in self._candidates.items():
            for candidate in candidates:
                if candidate.matches(action_name, types):
                    namespace = candidate.namespace_of(action_name)
                    if namespace is None or self.may_be_robot(namespace):
                        yield verb, candidate

    def may_be_robot(self, namespace: str) -> bool:
        """Return whether a namespace may hold a robot: it is not hidden, or it is configured."""
        return not is_hidden(namespace, self._configured_namespace)

    def preferred(self, verb: Verb, namespace: str | None = None) -> Candidate:
        """Return the action that is used where there is none, for a robot; default: the configured one."""
        return self._own.get((verb, namespace or self._configured_namespace)) or self._candidates[verb][0]

    def place_of(self, action_name: str) -> str:
        """Return an action's name, as if it were in the namespace of its robot."""
        robot = self.homes.get(action_name)
        return action_name if robot is None else f"{robot.rstrip('/')}/{action_name.rpartition('/')[2]}"

    def homed_in(self, namespace: str) -> frozenset[str]:
        """Return the actions, elsewhere, that the settings name for robots in a namespace."""
        return frozenset(name for name, robot in self.homes.items() if is_under(robot, namespace))

    def is_configured(self, verb: Verb, action_name: str) -> bool:
        """Return whether the settings name the action."""
        known = (*self._candidates[verb][:1], *(each for (of, _), each in self._own.items() if of == verb))
        return any(each.configured and each.matches(action_name, None) for each in known)

    def _names(self, verb: Verb, namespace: str | None = None) -> tuple[str, ...]:
        """Return the absolute names that a robot's action may have, the preferred one first.

        Args:
            verb: What the action does.
            namespace: The robot's namespace; None for the configured one.
        """
        own = self._own.get((verb, namespace or self._configured_namespace))
        candidates = (*([] if own is None else [own]), *self._candidates[verb])
        names = (self._settings.resolve(candidate.name, namespace) for candidate in candidates)
        others = self.homes.keys() - ({own.name} if own is not None else set())
        every = tuple(dict.fromkeys(names))
        return tuple(name for name in every if name not in others) or every


def _likely_type(verb: Verb, name: str) -> str:
    """Return the type of an action, if its name tells."""
    ours = ADAPTERS[verb][0]
    return next((each for each in ADAPTERS[verb] if each.action_name == name.rpartition("/")[2]), ours).action_type


def _candidates(verb: Verb, name: str, action_type: str) -> tuple[Candidate, ...]:
    ours = ADAPTERS[verb][0]
    known = tuple(Candidate(each.action_name, each.action_type, strict=each is not ours) for each in ADAPTERS[verb])
    if not name and not action_type:
        return known
    typed = (each for each in ADAPTERS[verb] if each.action_type == action_type)
    default = Candidate(
        name or next(typed, ours).action_name,
        action_type or _likely_type(verb, name),
        strict=bool(action_type),
        configured=True,
    )
    return default, *known
