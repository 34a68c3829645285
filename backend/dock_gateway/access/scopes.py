"""Checks that the subject of a request or a command is within its user's grant, and within this gateway's share."""

from collections.abc import Callable

from dock_gateway.core.alerts import Alerts
from dock_gateway.core.errors import NotAllowed, not_covered
from dock_gateway.core.grant import Grant
from dock_gateway.core.namespace import ALL_ROBOTS, read_namespace
from dock_gateway.core.share import Share
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.operation import Scope, Trait
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import read_goal_id
from dock_gateway.http.subject import Names, Subject, read_subject
from dock_gateway.robots.robots import Robots
from dock_gateway.settings import Settings

# How a grant covers what has a name on the ROS graph, and what a refusal calls that.
_ON_GRAPH: dict[Scope, tuple[Callable[[Grant, str], bool], str]] = {
    Scope.TOPIC: (Grant.covers_topic, "the topic"),
    Scope.PUBLISHING: (Grant.covers_publishing, "publishing on the topic"),
    Scope.SERVICE: (Grant.covers_service, "calls of the service"),
    Scope.NODE: (Grant.covers_parameters, "setting parameters of the node"),
    Scope.LOOKED_AT: (Grant.covers_place, "the"),
}


async def require_covered(parts: Parts, grant: Grant, scope: Scope, names: Names, what: str) -> None:
    """Refuse a request or a command that is about robots, actions or topics beyond a grant.

    Raises:
        NotAllowed: It is (`not_allowed`).
        InvalidField: A name is not valid.
        NotFound: There is no such goal or alert, or it is beyond the grant, which is the same to who asks.
        ServedElsewhere: It is about a robot that another gateway serves.
    """
    subject = read_subject(scope, names, parts[Settings])
    of_topics = scope in (Scope.TOPIC, Scope.PUBLISHING)  # a grant may be limited to some topics alone
    if of_topics or (grant.limited and scope not in (Scope.ANY, Scope.LISTED)):
        await _require_granted(parts, grant.own, subject, what)
    if grant.share is not None and Trait.ABOUT_ROBOTS in scope.traits:
        await _require_served(parts, grant.own, subject)


async def _require_granted(parts: Parts, grant: Grant, subject: Subject, what: str) -> None:
    match subject.scope:
        case Scope.EVERY:
            raise NotAllowed(f"{what} is about every robot, and your access is limited", code="not_allowed")
        case Scope.ALERT:
            parts[Alerts].get(subject.identity, grant)
        case Scope.APPROVAL:
            parts[Approvals].get(subject.identity, grant)
        case scope if scope in _ON_GRAPH:
            covers, about = _ON_GRAPH[scope]
            noun = f"{about} {subject.kind}" if scope is Scope.LOOKED_AT else about
            _require(covers(grant, subject.name), f"{noun} {subject.name[:100]}")
        case Scope.ROBOTS if _robot(parts, subject) == ALL_ROBOTS:  # a limit to `/` is one robot: that without a name
            _require(grant.covers_every_robot, "every robot; name one of yours with `robot`")
        case Scope.ROBOT | Scope.ROBOTS:
            _require(grant.covers_robot(_robot(parts, subject)), _describe_robot(parts, subject))
        case _:
            await _require_action(parts, grant, subject)


async def _require_action(parts: Parts, grant: Grant, subject: Subject) -> None:
    """Refuse what is about an action beyond a grant: one that is named, that docks or undocks, or that a goal is on."""
    name = subject.action
    if subject.scope is Scope.NEW_GOAL and name is not None and subject.robot is not None:
        _require(grant.covers_robot(_robot(parts, subject)), _describe_robot(parts, subject))
    if name is not None:
        _require(grant.covers_action(name), f"the action {name[:100]}")
    elif subject.scope is not Scope.GOAL:
        name = parts[RobotActions].docking_name(subject.verb, _robot(parts, subject))
        _require(grant.covers_action(name), _describe_robot(parts, subject))
    if subject.scope is Scope.GOAL:  # an unknown goal and another's: the same answer
        await parts[Goals].get(read_goal_id(str(subject.identity)), grant)


async def _require_served(parts: Parts, grant: Grant, subject: Subject) -> None:
    """Refuse what is about robots beyond this gateway's share. What only reads the ROS graph is not."""
    share = parts[Share]
    if subject.scope is Scope.GOAL:
        goal = await parts[Goals].get(read_goal_id(str(subject.identity)), grant)
        share.require(goal.action_name, f"goals of the action {goal.action_name}")
    elif subject.kind:
        share.require(subject.name, f"the {subject.kind} {subject.name[:100]}")
    elif (name := subject.action) is not None:
        if subject.robot is not None:
            _robot(parts, subject)  # refused if it is not valid
        share.require(name, f"the action {name[:100]}")
    elif subject.scope is not Scope.ROBOTS or _robot(parts, subject) != ALL_ROBOTS:  # else all of the share
        share.require_robot(_robot(parts, subject))


def _require(covered: bool, about: str) -> None:
    if not covered:
        raise not_covered(about)


def _robot(parts: Parts, subject: Subject) -> str:
    return parts[Robots].default_namespace if subject.robot is None else read_namespace(str(subject.robot))


def _describe_robot(parts: Parts, subject: Subject) -> str:
    hint = "; name one of yours with `robot`" if subject.robot is None else ""
    return f"the robot {_robot(parts, subject)}{hint}"
