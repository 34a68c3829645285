"""Faults on the ROS graph around the robots, as alerts show them. Pure: observations in, texts out."""

from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

from dock_gateway.core.filters import is_hidden
from dock_gateway.core.graph import Peer, Topic
from dock_gateway.setting_groups.one_robot import describe_table


class FindingKind(StrEnum):
    """The kinds of findings. Each is a kind of alert, too."""

    WRONG_TOPIC_TYPE = "wrong_topic_type"
    DUPLICATE_BASE = "duplicate_base"
    ROBOT_SEEN_TWICE = "robot_seen_twice"
    ROBOTS_CLAIMED_TWICE = "robots_claimed_twice"
    COMMANDS_LOST = "commands_lost"


@dataclass(frozen=True)
class Finding:
    """Something that is wrong. `robot`: a namespace, or None for the gateway. `critical`: an operator has to act."""

    kind: FindingKind
    robot: str | None
    title: str
    detail: str
    critical: bool = False


@dataclass(frozen=True)
class Expected:
    """The expected types of a topic.

    Attributes:
        types: The types that it can use.
        setting: The setting that names another topic; empty if there is none.
        vital: What does not work on a topic of another type, if the safety of the robot depends on it.
    """

    types: tuple[str, ...]
    setting: str = ""
    vital: str = ""


def wrong_type(robot: str | None, topic: Topic, expected: Expected, gateways: Iterable[str]) -> Finding | None:
    """Return the finding that a topic has another type than expected; None if it has not.

    Args:
        robot: The robot whose topic it is.
        topic: The topic.
        expected: The expected types.
        gateways: Nodes that do not count.
    """
    ours = frozenset(gateways)
    others = [each for each in (*topic.publishers, *topic.subscribers) if each.node not in ours]
    strange = [each for each in others if each.type not in expected.types]
    if not strange:
        return None
    users = sorted({f"{each.type} by {each.node or 'a program that is not a ROS node'}" for each in strange})
    fits = len(strange) < len(others)
    unused = "Whoever expects the other type gets nothing." if fits else "The gateway does not use it."
    vital = "" if fits or not expected.vital else f" {expected.vital}"
    rename = f" or set {expected.setting} to the right topic" if expected.setting else ""
    return Finding(
        FindingKind.WRONG_TOPIC_TYPE,
        robot,
        "Wrong type of a topic",
        f"{topic.name} is used as {_listed(users)}, but its type has to be {' or '.join(expected.types)}. "
        f"{unused}{vital} Give it another name in that node{rename}.",
        critical=bool(vital),
    )


def wrong_action(robot: str, action: str, types: list[str], expected: str, verb: str) -> Finding:
    """Return the finding that an action is of another type than the settings say."""
    return Finding(
        FindingKind.WRONG_TOPIC_TYPE,
        robot,
        "Wrong type of an action",
        f"{action} is of type {_listed(types)}, but DOCK_GATEWAY_{verb.upper()}_ACTION_TYPE is {expected}. The gateway "
        "sends no goals there. Correct the setting, or leave it empty to use the type on the ROS graph.",
    )


def two_bases(robot: str, velocity: Topic, odometry: Topic, settled: Container[Peer]) -> Iterator[Finding]:
    """Yield the findings that a robot has more than one base: each of them moves with every command.

    A base subscribes to velocity, does not publish it, and publishes odometry, or there is another node of its name.

    Args:
        robot: The robot.
        velocity: Its topic of velocity.
        odometry: Its topic of odometry.
        settled: The nodes that have been there for long enough to be alive.
    """
    sources = {peer for each in odometry.publishers if (peer := each.peer) in settled}
    talking = {each.node for each in velocity.publishers}
    listening = {
        peer
        for each in velocity.subscribers
        if (peer := each.peer) in settled and each.node not in talking and not is_hidden(each.node or "")
    }
    counts = Counter(node for node, _ in listening)
    bases = {peer for peer in listening if peer in sources or (peer[0] is not None and counts[peer[0]] > 1)}
    for what, topic, peers in (("subscribe to", velocity, bases), ("publish", odometry, sources)):
        if len(peers) > 1:
            yield Finding(
                FindingKind.DUPLICATE_BASE,
                robot,
                "More than one base",
                f"{_nodes(peers)} {what} {topic.name}: more than one base moves with every command to {robot}. Start "
                "each robot in a namespace (`-r __ns:=/robot2`) or in a ROS domain (ROS_DOMAIN_ID) of its own.",
                critical=True,
            )


def seen_twice(robots: Mapping[str, str], node: str) -> Finding:
    """Return the finding that one node docks several robots, which may be one robot.

    Args:
        robots: Their docking actions.
        node: The node that serves these.
    """
    (robot, action), *others = sorted(robots.items())
    other, other_action = others[0]
    names = " and ".join(f"{name} ({by})" for name, by in [(robot, action), *others[:2]])
    (line,) = describe_table(robot, dock_action=other_action)
    return Finding(
        FindingKind.ROBOT_SEEN_TWICE,
        robot,
        "One robot by two names?",
        f"{node} serves the docking actions of {names}. Automatic docking sends them no goals, as they may be one "
        f"robot. If they are, set {line}: {other} then has no docking server "
        "of its own. If they are not, set DOCK_GATEWAY_ALLOW_SHARED_SERVERS=true.",
    )


def claimed_twice(conflict: str | None) -> Iterator[Finding]:
    """Yield the finding that another gateway on the same database serves robots of this one."""
    if conflict is not None:
        title, advice = "Two gateways serve the same robots", "Both go on. Stop one, or give each its own `robots`."
        yield Finding(FindingKind.ROBOTS_CLAIMED_TWICE, None, title, f"{conflict}. {advice}", critical=True)


def commands_lost(robot: str, node: str, seconds: float) -> Finding:
    """Return the finding that a robot was stopped, as its commands ended while it moved and a docking goal ran.

    Args:
        robot: The robot.
        node: Who commanded it last.
        seconds: How long there was no command.
    """
    return Finding(
        FindingKind.COMMANDS_LOST,
        robot,
        "Robot stopped: no commands",
        f"{node} moved {robot} and then sent no command for {seconds:g} s while its goal is running, so zero velocity "
        "was sent. Check that the robot stands still, then start the node again.",
        critical=True,
    )


def _nodes(peers: Iterable[Peer]) -> str:
    counts = Counter(node or "a program that is not a ROS node" for node, _ in peers)
    return _listed([name if count == 1 else f"{count} nodes {name}" for name, count in sorted(counts.items())])


def merge(findings: Iterable[Finding]) -> Iterator[Finding]:
    """Merge the findings of one kind about one robot into one."""
    merged: dict[tuple[FindingKind, str | None], Finding] = {}
    for each in findings:
        key = each.kind, each.robot
        before = merged.get(key)
        merged[key] = (
            each
            if before is None
            else replace(before, detail=f"{before.detail} {each.detail}", critical=before.critical or each.critical)
        )
    yield from merged.values()


def _listed(parts: list[str], most: int = 3) -> str:
    """Return the first parts of a list, and how many more there are."""
    shown = ", ".join(parts[:most])
    return shown if len(parts) <= most else f"{shown} and {len(parts) - most} more"
