"""`/actions`: the operations of `/dock` for every action on the graph whose interface package is installed."""

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request

from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import NotFound
from dock_gateway.core.filters import is_hidden, parent_of
from dock_gateway.core.goal import Goal, Verb
from dock_gateway.core.grant import Role
from dock_gateway.doors.rest.answers import HEADERS, answer_page, answer_sent
from dock_gateway.goals.action import Action
from dock_gateway.goals.action_schema import ActionInfo, ActionList
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.schema import ActionGoal, ActionGoalPage
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, carries_out, operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import TheGrant, ThePrincipal, read_own_key
from dock_gateway.http.requests import (
    Answer,
    CursorQuery,
    GoalId,
    GraphName,
    LimitQuery,
    StatusQuery,
    goal_response,
    json_response,
    read_json,
    read_wait,
)
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations.goals import CancelGoal, SendGoal, cancel_goal, send_goal
from dock_gateway.storage import GoalFilter

router = APIRouter(route_class=ApiRoute, tags=["Actions"], prefix="/actions")

GOAL_BODY = body({"type": "object", "description": "The goal message's own fields"}, required=True)


async def find_goal(goals: Goals, action: Action, goal_id: str) -> Goal:
    """Return a goal of this action.

    Raises:
        NotFound: The action has no goal with this id.
    """
    goal = await goals.get(goal_id)
    if goal.action_name != action.name:
        raise NotFound(f"goal {goal_id} is on {goal.action_name}, not on {action.name}", code="goal_not_found")
    return goal


HiddenQuery = Annotated[bool, Query(description="Whether to list hidden actions, too")]


@router.get("")
@operation(Role.VIEWER, Scope.LISTED)
async def list_actions(
    actions: Part[ActionRegistry], grant: TheGrant, *, hidden: HiddenQuery = False
) -> Answer[ActionList]:
    """List every action on the graph. If an action's interface package is missing, `hint` says what to install.

    As in ROS, an action is hidden if a part of its name begins with `_`. Those that dock or undock a robot are listed.
    """

    def listed(name: str, verb: Verb | None) -> bool:
        return grant.covers_action(name) and (hidden or verb is not None or not is_hidden(name))

    found = [action.document() for action in actions.all() if listed(action.name, action.verb)]
    missing = [
        {
            "action_name": entry.name,
            "action_type": entry.type,
            "verb": entry.verb,
            "available": True,
            "answering": False,
            "duplicate": False,
            "installed": False,
            "hint": entry.hint,
            "running_goals": 0,
            "feedback_dropped": 0,
            "unknown_goals_ignored": 0,
        }
        for entry in actions.uninstalled()
        if listed(entry.name, entry.verb)
    ]
    return json_response({"actions": [*found, *missing]})


@router.post(
    "/{name:graph_name}/goals",
    status_code=202,
    responses={200: {"model": ActionGoal, "description": "It ended"}},
    openapi_extra={**GOAL_BODY, "parameters": HEADERS},
)
@carries_out(send_goal, Scope.ACTION)
async def send_action_goal(
    name: GraphName, request: Request, parts: AllParts, principal: ThePrincipal
) -> Answer[ActionGoal]:
    """Send a goal. The body holds the fields of the goal message; `{}` sends its defaults."""
    wait, key = read_wait(request), read_own_key(request)

    async def read(action: Action) -> Any:
        audited(request, action_name=action.name, robot=parent_of(action.name))
        # Not empty: to use a message's defaults, a client has to send `{}`. All zeros may be a pose to drive to.
        return await action.read_goal(await read_json(request))

    action, goal = await send_goal(parts, principal, SendGoal(read, action=f"/{name}", key=key))
    return await answer_sent(request, action, goal, f"/actions{action.name}/goals", wait)


@router.get("/{name:graph_name}/goals")
@operation(Role.VIEWER, Scope.ACTION)
async def list_action_goals(
    name: GraphName,
    actions: Part[ActionRegistry],
    goals: Part[Goals],
    *,
    status: StatusQuery = None,
    limit: LimitQuery = 50,
    cursor: CursorQuery = None,
) -> Answer[ActionGoalPage]:
    """List the goals of an action, newest first."""
    action = await actions.find(f"/{name}")
    wanted = GoalFilter(frozenset({action.name}), statuses=frozenset(status or ()))
    return await answer_page(goals, wanted, limit, cursor)


@router.get("/{name:graph_name}/goals/{goal_id}")
@operation(Role.VIEWER, Scope.GOAL)
async def get_action_goal(
    name: GraphName, goal_id: GoalId, actions: Part[ActionRegistry], goals: Part[Goals]
) -> Answer[ActionGoal]:
    """Return one goal of an action."""
    action = await actions.find(f"/{name}")
    goal = await find_goal(goals, action, goal_id)
    return goal_response(goal, f"/actions{action.name}/goals/{goal_id}")


@router.post("/{name:graph_name}/goals/{goal_id}/cancel", status_code=202)
@carries_out(cancel_goal)
async def cancel_action_goal(
    name: GraphName, goal_id: GoalId, parts: AllParts, principal: ThePrincipal
) -> Answer[ActionGoal]:
    """Ask the action server to cancel a goal, whoever sent it."""
    action = await parts[ActionRegistry].find(f"/{name}")
    await find_goal(parts[Goals], action, goal_id)
    goal = await cancel_goal(parts, principal, CancelGoal(goal_id))
    return goal_response(goal, f"/actions{action.name}/goals/{goal_id}", 202)


@router.get("/{name:graph_name}")
@operation(Role.VIEWER, Scope.ACTION)
async def get_action(name: GraphName, actions: Part[ActionRegistry]) -> Answer[ActionInfo]:
    """Return one action."""
    return json_response((await actions.find(f"/{name}")).document())
