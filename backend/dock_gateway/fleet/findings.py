"""What is wrong on the ROS graph around the robots, as alerts show it. Pure: what was seen in, the words out."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum

from dock_gateway.core.graph import Topic


class FindingKind(StrEnum):
    """The kinds of findings. Each is a kind of alert, too."""

    WRONG_TOPIC_TYPE = "wrong_topic_type"


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
    """What the gateway expects of a topic.

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
        expected: What is expected of it.
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
