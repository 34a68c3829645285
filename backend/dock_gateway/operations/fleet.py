"""Robots, actions and alerts: they are listed; robots are labeled, alerts acknowledged."""

from typing import Any

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import not_covered
from dock_gateway.core.filters import is_hidden
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.goals.action import Action
from dock_gateway.goals.action_document import Uninstalled
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.robots.labels import Labels, RobotLabel

Documents = list[dict[str, Any]]


@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER, errors=(404, 421))
async def list_robots(parts: Parts, principal: Principal, robot: str | None = None) -> Documents:
    """List the robots that were found: their state, battery, goals and stop; with `robot`, only that one.

    Raises:
        NotAllowed: The grant does not cover the robot (`not_allowed`).
        NotFound: There is no such robot.
    """
    if robot is not None and not principal.grant.own.covers_robot(name := read_namespace(robot)):
        raise not_covered(f"the robot {name}")
    return parts[Fleet].documents(robot, principal.grant)


@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
async def list_actions(parts: Parts, principal: Principal, *, hidden: bool = False) -> Documents:
    """List the actions on the ROS graph. Without its interface package, an action is not `installed`.

    As in ROS, an action is hidden if a part of its name begins with `_`. Those that dock or undock a robot are listed.

    Args:
        parts: Know the actions.
        principal: The user, who is shown those that their grant covers.
        hidden: Whether to list hidden actions, too.
    """
    actions = parts[ActionRegistry]
    known: list[Action | Uninstalled] = [*actions.all(), *actions.uninstalled()]
    return [
        action.document()
        for action in known
        if principal.grant.covers_action(action.name)
        and (hidden or action.verb is not None or not is_hidden(action.name))
    ]


@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
async def list_alerts(parts: Parts, principal: Principal) -> Documents:
    """List the active alerts: critical ones first, then oldest first."""
    return parts[AlertBoard].documents(principal.grant)


@operation(Role.VIEWER, Scope.ALERT, Audit.NEVER)
async def get_alert(parts: Parts, principal: Principal, alert_id: str) -> dict[str, Any]:
    """Return an active alert.

    Raises:
        NotFound: There is no such alert (`alert_not_found`).
    """
    return parts[AlertBoard].document(alert_id, principal.grant)


@operation(Role.OPERATOR, Scope.ALERT)
async def acknowledge_alert(
    parts: Parts, _: Principal, alert_id: str, by: str | None, condition: Condition = UNCONDITIONAL
) -> dict[str, Any]:
    """Acknowledge an alert, or with `by` None withdraw that. Return the alert.

    Raises:
        NotFound: There is no such alert (`alert_not_found`).
        ChangedMeanwhile: The alert has not the version of the condition.
    """
    return await parts[AlertBoard].acknowledge(alert_id, by, condition)


@operation(Role.SUPERVISOR, Scope.EVERY, errors=(409,))
async def label_robot(
    parts: Parts, _: Principal, robot: str, label: RobotLabel, condition: Condition = UNCONDITIONAL
) -> None:
    """Replace the display name and the groups of a robot.

    Raises:
        ChangedMeanwhile: The label has not the version of the condition.
        Conflict: There are too many labels.
    """
    await parts[Labels].replace(robot, label, condition)
