"""The subject of a request or a command: its names are read here, for rights, `421` and the audit log."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.goal import Verb
from dock_gateway.core.namespace import ALL_ROBOTS
from dock_gateway.http.operation import Scope
from dock_gateway.settings import Settings

# The query and path parameters of a request, or the fields of a command.
Names = Mapping[str, Any]
# What is on the ROS graph besides actions, and the name that says where.
ON_GRAPH = {Scope.TOPIC: "topic", Scope.PUBLISHING: "topic", Scope.SERVICE: "service", Scope.NODE: "node"}


@dataclass(frozen=True)
class Subject:
    """The subject of a request or a command, as it names it: a name may be one that is not valid.

    Attributes:
        scope: What kind of subject it is.
        robot: The robot, or `ALL_ROBOTS`; several as a tuple; None: the configured one, if it is about a robot.
        action: The absolute name of an action; None: the one that docks or undocks the robot, as `verb` says.
        verb: `dock` or `undock`.
        identity: The id of a goal, an alert or an approval.
        kind: `topic`, `service` or `node`; empty if it is none of them.
        name: Its absolute name.
    """

    scope: Scope
    robot: Any = None
    action: str | None = None
    verb: Verb = "dock"
    identity: Any = None
    kind: str = ""
    name: str = ""


def read_subject(scope: Scope, names: Names, settings: Settings) -> Subject:
    """Return what the names of a request or a command are about. Names that its scope does not know say nothing."""
    robot, named = names.get("robot"), f"/{names['name']}" if "name" in names else None
    about: dict[str, Any] = {}
    match scope:
        case Scope.ROBOT | Scope.DOCK:
            about["robot"] = robot
        case Scope.UNDOCK:
            about = {"robot": robot, "verb": "undock"}
        case Scope.NEW_GOAL | Scope.APPROVAL:  # what a program that asks its person says of the goal is recorded, too
            about = {"robot": robot, "identity": names.get("approval_id")}
            if names.get("verb") == "undock":
                about["verb"] = "undock"
            if (action := names.get("action")) is not None:
                about["action"] = settings.resolve(str(action), None if robot is None else str(robot))
        case Scope.ANY | Scope.ROBOTS if scope is Scope.ROBOTS or "robot" in names:  # `robot` of ANY: a stop's
            about["robot"] = ALL_ROBOTS if robot is None else robot
        case Scope.ACTION | Scope.GOAL:
            about |= {"action": named, "identity": names.get("goal_id")}
        case Scope.ALERT:
            about["identity"] = names.get("alert_id")
        case Scope.TOPIC | Scope.PUBLISHING | Scope.SERVICE | Scope.NODE | Scope.LOOKED_AT:
            kind = ON_GRAPH.get(scope) or ("node" if "node" in names else "service")
            in_path = named if kind == "topic" else None
            about |= {"kind": kind, "name": in_path or settings.resolve(str(names.get(kind, "")), "")}
    return Subject(scope, **about)
