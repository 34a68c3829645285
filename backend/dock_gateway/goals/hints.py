"""Hints for a robot without a docking server: what is on the ROS graph, and the settings that join it. Pure."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from dock_gateway.core.filters import is_under
from dock_gateway.setting_groups.one_robot import describe_table

# The maximum number of names in one sentence.
MAX_NAMES = 5


@dataclass(frozen=True)
class Sight:
    """The docking server and the battery that a robot has on the graph.

    Attributes:
        robot: Its namespace.
        dock: Its docking action, if that has a server.
        undock: Its undocking action, if that has a server.
        battery: Its battery topic, if a message has arrived.
    """

    robot: str
    dock: str | None = None
    undock: str | None = None
    battery: str | None = None


@dataclass(frozen=True)
class Join:
    """A docking server and a battery that are perhaps of one robot.

    Attributes:
        robot: The robot, by the namespace of its battery.
        other: The namespace of its docking server.
        settings: Lines that make them one robot.
        detail: All of that in a sentence.
    """

    robot: str
    other: str
    settings: list[str]
    detail: str


@dataclass(frozen=True)
class Hint:
    """A hint for a robot without a docking server.

    Attributes:
        detail: What is on the graph, and what to do.
        settings: Lines that join the robot with a docking server.
        robots: The robots with a docking server and a battery.
    """

    detail: str
    settings: list[str] = field(default_factory=list)
    robots: list[str] = field(default_factory=list)


def find_join(robot: str, sights: Iterable[Sight]) -> Join | None:
    """Return what would give a robot a docking server, if only one that has no battery comes into question.

    Nothing is joined by itself: the wrong robot would move.

    Args:
        robot: A robot without a docking server.
        sights: All robots.
    """
    servers = [each for each in sights if each.dock and not each.battery and each.robot != robot]
    related = [each for each in servers if robot != "/" != each.robot and _are_related(each.robot, robot)]
    candidates = related or servers
    if len(candidates) != 1:
        return None
    (server,) = candidates
    lines = describe_table(robot, dock_action=server.dock, undock_action=server.undock or None)
    detail = (
        f"If {server.dock} docks {robot}, set {' and '.join(lines)} in the configuration file, and restart the gateway."
    )
    return Join(robot, server.robot, lines, detail)


def docking_hint(robot: str, sights: Sequence[Sight]) -> Hint | None:
    """Return the hint for a robot without a docking server; None if there is nothing on the graph to point at.

    Args:
        robot: The robot.
        sights: All robots that may be named.
    """
    others = [each for each in sights if each.robot != robot]
    own = next((each for each in sights if each.robot == robot), Sight(robot))
    actions = [each.dock for each in others if each.dock]
    batteries = [each.battery for each in sights if each.battery and not each.dock]
    if not actions and not [each for each in others if each.battery]:
        return None
    parts = []
    if actions:
        parts.append(f"Docking actions on the ROS graph: {_listed(actions)}.")
    if batteries:
        parts.append(f"Batteries of robots without a docking server: {_listed(batteries)}.")
    robots = [each.robot for each in others if each.dock and each.battery]
    halves = [each.robot for each in sights if each.battery and not each.dock]
    subject = robot if own.battery or not halves else halves[0] if len(halves) == 1 else None
    join = None if subject is None else find_join(subject, sights)
    if join is not None:
        parts.append(join.detail)
    elif subject is not None or not robots:
        parts += _advise(subject or robot, others)
    if subject not in (None, robot):
        parts.append(f"Then name it, with ?robot={subject}.")
    if robots:
        parts.append(f"Robots with a docking server: {_listed(robots)}. Name one, as with ?robot={robots[0]}.")
    return Hint(" ".join(parts), [] if join is None else join.settings, robots)


def split_robots(sights: Sequence[Sight]) -> list[Join]:
    """Return the robots that are probably in two parts: nested, or the only two on the graph."""
    halves = [each for each in sights if each.battery and not each.dock]
    servers = [each for each in sights if each.dock and not each.battery]
    whole = [each for each in sights if each.dock and each.battery]
    found = []
    for half in halves:
        join = find_join(half.robot, sights)
        if join is None:
            continue
        alone = len(halves) == len(servers) == 1 and not whole
        nested = "/" not in (join.robot, join.other) and _are_related(join.robot, join.other)
        if alone or nested:
            found.append(join)
    return found


def _advise(robot: str, others: Iterable[Sight]) -> list[str]:
    """Say how one of several docking servers without a battery becomes that of a robot."""
    servers = [each.dock for each in others if each.dock and not each.battery]
    if not servers:
        return []
    (line,) = describe_table(robot, dock_action="/its/name")
    return [f"If one of them docks {robot}, set {line} in the configuration file, and restart the gateway."]


def _are_related(one: str, other: str) -> bool:
    return is_under(one, other) or is_under(other, one)


def _listed(names: list[str]) -> str:
    rest = len(names) - MAX_NAMES
    return ", ".join(names[:MAX_NAMES]) + (f" and {rest} more" if rest > 0 else "")
