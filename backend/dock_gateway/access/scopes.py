"""Whether what a request or a command is about lies within its user's grant."""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from dock_gateway.core.alerts import Alerts
from dock_gateway.core.errors import NotAllowed, not_covered
from dock_gateway.core.grant import Grant
from dock_gateway.core.namespace import ALL_ROBOTS, read_namespace
from dock_gateway.core.share import Share
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.docking_actions import DockingActions
from dock_gateway.goals.goals import Goals
from dock_gateway.http.operation import Scope
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import read_goal_id
from dock_gateway.robots.robots import Robots
from dock_gateway.settings import Settings

# The query and path parameters of a request, or the fields of a command.
Names = Mapping[str, Any]


async def require_covered(parts: Parts, grant: Grant, scope: Scope, names: Names, what: str) -> None:
    """Refuse a request or a command that is about robots, actions or topics beyond a grant.

    Raises:
        NotAllowed: It is (`not_covered`).
        InvalidField: A name is not valid.
        NotFound: There is no such goal or alert, or it is beyond the grant, which is the same to who asks.
        ServedElsewhere: It is about a robot that another gateway serves.
    """
    await _require_granted(parts, grant.own, scope, names, what)
    if grant.share is not None:
        await _require_served(parts, grant.own, scope, names)


async def _require_granted(parts: Parts, grant: Grant, scope: Scope, names: Names, what: str) -> None:
    if scope is Scope.TOPIC:
        covered = grant.covers_topic(topic := _topic(parts, names))
        about = f"the topic {topic[:100]}"
    elif scope is Scope.PUBLISHING:  # a grant may be limited to some topics alone
        covered = grant.covers_publishing(topic := _topic(parts, names))
        about = f"publishing on the topic {topic[:100]}"
    elif not grant.limited or scope in (Scope.ANY, Scope.LISTED):
        return
    elif scope is Scope.EVERY:
        raise NotAllowed(f"{what} is about every robot, and your access is limited", code="not_covered")
    else:
        covered, about = await _CHECKS[scope](parts, grant, names)
    if not covered:
        raise not_covered(about)


async def _require_served(parts: Parts, grant: Grant, scope: Scope, names: Names) -> None:
    """Refuse what is about robots beyond this gateway's share. What only reads the ROS graph is not."""
    share = parts[Share]
    match scope:
        case Scope.ROBOTS if _all_or_one(names) == ALL_ROBOTS:
            return  # all of the share
        case Scope.ROBOT | Scope.ROBOTS | Scope.DOCK | Scope.UNDOCK:
            share.require_robot(_namespace(parts, names))
        case Scope.NEW_GOAL if names.get("action") is None:
            share.require_robot(_namespace(parts, names))
        case Scope.NEW_GOAL:
            namespace = None if names.get("robot") is None else _namespace(parts, names)
            name = parts[Settings].resolve(str(names["action"]), namespace)
            share.require(name, f"the action {name[:100]}")
        case Scope.ACTION:
            share.require(name := f"/{names['name']}", f"the action {name[:100]}")
        case Scope.GOAL:
            goal = await parts[Goals].get(read_goal_id(str(names.get("goal_id"))), grant)
            share.require(goal.action_name, f"goals of the action {goal.action_name}")
        case Scope.SERVICE | Scope.NODE | Scope.PUBLISHING:
            field = {Scope.SERVICE: "service", Scope.NODE: "node", Scope.PUBLISHING: "topic"}[scope]
            name = _topic(parts, names) if scope is Scope.PUBLISHING else _graph_name(parts, names, field)
            share.require(name, f"the {field} {name[:100]}")


async def _robot(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    robot = _namespace(parts, names)
    return grant.covers_robot(robot), _describe_robot(robot, names)


async def _robots(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    if _all_or_one(names) == ALL_ROBOTS:  # a limit to `/` is only the robot without a namespace
        return grant.covers_every_robot, "every robot; name one of yours with `robot`"
    return await _robot(parts, grant, names)


async def _dock(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    robot = _namespace(parts, names)
    return grant.covers_action(parts[DockingActions].of(robot).dock), _describe_robot(robot, names)


async def _undock(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    robot = _namespace(parts, names)
    return grant.covers_action(parts[DockingActions].of(robot).undock), _describe_robot(robot, names)


async def _action(_: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    name = f"/{names['name']}"
    return grant.covers_action(name), f"the action {name[:100]}"


async def _goal(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    if "name" in names and not grant.covers_action(name := f"/{names['name']}"):
        return False, f"the action {name[:100]}"
    # An unknown goal and another's: the same answer.
    await parts[Goals].get(read_goal_id(str(names.get("goal_id"))), grant)
    return True, ""


async def _command_goal(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    if names.get("action") is None:
        return await _dock(parts, grant, names)
    namespace = None if names.get("robot") is None else _namespace(parts, names)
    if namespace is not None and not grant.covers_robot(namespace):
        return False, _describe_robot(namespace, names)
    name = parts[Settings].resolve(str(names["action"]), namespace)
    return grant.covers_action(name), f"the action {name[:100]}"


async def _alert(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    parts[Alerts].get(names["alert_id"], grant)
    return True, ""


async def _approval(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    parts[Approvals].get(names["approval_id"], grant)
    return True, ""


async def _place(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    kind = "node" if "node" in names else "service"
    name = _graph_name(parts, names, kind)
    return grant.covers_place(name), f"the {kind} {name[:100]}"


async def _service(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    name = _graph_name(parts, names, "service")
    return grant.covers_service(name), f"calls of the service {name[:100]}"


async def _node(parts: Parts, grant: Grant, names: Names) -> tuple[bool, str]:
    name = _graph_name(parts, names, "node")
    return grant.covers_parameters(name), f"setting parameters of the node {name[:100]}"


_CHECKS: dict[Scope, Callable[[Parts, Grant, Names], Awaitable[tuple[bool, str]]]] = {
    Scope.ROBOT: _robot,
    Scope.ROBOTS: _robots,
    Scope.DOCK: _dock,
    Scope.UNDOCK: _undock,
    Scope.ACTION: _action,
    Scope.GOAL: _goal,
    Scope.NEW_GOAL: _command_goal,
    Scope.ALERT: _alert,
    Scope.APPROVAL: _approval,
    Scope.PLACE: _place,
    Scope.SERVICE: _service,
    Scope.NODE: _node,
}


def _namespace(parts: Parts, names: Names) -> str:
    robot = names.get("robot")
    return parts[Robots].default_namespace if robot is None else read_namespace(str(robot))


def _all_or_one(names: Names) -> str:
    robot = names.get("robot")
    return ALL_ROBOTS if robot is None else read_namespace(str(robot))


def _describe_robot(robot: str, names: Names) -> str:
    return f"the robot {robot}" + ("; name one of yours with `robot`" if names.get("robot") is None else "")


def _topic(parts: Parts, names: Names) -> str:
    return f"/{names['name']}" if "name" in names else _graph_name(parts, names, "topic")


def _graph_name(parts: Parts, names: Names, field: str) -> str:
    return parts[Settings].resolve(str(names.get(field, "")), "")
