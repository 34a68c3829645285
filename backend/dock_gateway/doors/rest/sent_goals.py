"""Goals where they are sent: `/dock`, `/undock` and `/actions/{name}/goals` are one router at three paths.

`/goals/{goal_id}/cancel` cancels a goal on any action.
"""

from collections.abc import Awaitable, Callable, Collection
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request
from pydantic import BaseModel
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.goal import Goal as GoalRecord
from dock_gateway.core.goal import GoalStatus, Verb
from dock_gateway.core.grant import Grant, Role
from dock_gateway.doors.rest.answers import HEADERS, answer_page, answer_sent
from dock_gateway.goals.goal_path import GoalPath
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.goals.schema import ActionGoal, ActionGoalPage, Goal, GoalPage
from dock_gateway.http.openapi import body, docking_body
from dock_gateway.http.operation import Scope, carries_out, operation
from dock_gateway.http.parts import AllParts, Parts
from dock_gateway.http.principal import TheGrant, ThePrincipal, read_own_key
from dock_gateway.http.requests import (
    CursorQuery,
    GoalId,
    GraphName,
    LimitQuery,
    RobotQuery,
    StatusQuery,
    goal_response,
    read_body,
    read_json,
    read_wait,
)
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations.goals import CancelGoal, SendGoal, cancel_goal, send_goal
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.storage import GoalFilter


@dataclass(frozen=True)
class GoalsAt(GoalPath):
    """A path where goals are sent, listed, read and canceled.

    Attributes:
        robot: The robot that the query names; None: the configured one.
    """

    robot: str | None = None

    async def goal(self, parts: Parts, goal_id: str) -> GoalRecord:
        """Return one of the goals.

        Raises:
            NotFound: There is no such goal, or it is one of another place; or no such action.
        """
        if self.action is not None:
            await parts[ActionRegistry].find(self.action)
        goal = await parts[Goals].get(goal_id)
        self.require(goal)
        return goal

    async def select(self, parts: Parts, grant: Grant, statuses: Collection[GoalStatus]) -> GoalFilter:
        """Return the filter of the goals of its action, or of the robot's actions of its verb.

        Raises:
            NotFound: There is no such action or robot, or the robot has no such action.
        """
        wanted = frozenset(statuses)
        if self.action is not None:
            return GoalFilter(frozenset({(await parts[ActionRegistry].find(self.action)).name}), statuses=wanted)
        verb = self.verb or "dock"
        await parts[ActionRegistry].find_docking(verb, self.robot)
        names = parts[RobotActions].docking_names(parts[RobotRegistry].get(self.robot).namespace, verb)
        return GoalFilter(names, statuses=wanted, among=frozenset(filter(grant.covers_action, names)))

    def answer(self, goal: GoalRecord, status: int = 200) -> Response:
        """Answer with a goal."""
        return goal_response(goal, f"{self.path}/{goal.goal_id}", status)


Find = Callable[..., Awaitable[GoalsAt]]


@dataclass(frozen=True)
class GoalCollection:
    """One of the paths where goals are sent.

    Attributes:
        path: The path.
        tag: Its section in the OpenAPI document.
        names: The names of its operations: send, list, get, cancel.
        description: What sending a goal does.
        body: Schema of the request.
        scope: What sending and listing are about.
        goal: Model of a goal.
        page: Model of a page of goals.
        place: Dependency that returns the place of a goal, from the path.
        sends: Dependency that returns the place of goals that are sent or listed, from the path and the query.
    """

    path: str
    tag: str
    names: tuple[str, str, str, str]
    description: str
    body: dict[str, Any]
    scope: Scope
    goal: type[BaseModel]
    page: type[BaseModel]
    place: Find
    sends: Find


def routes_of(goals: GoalCollection) -> APIRouter:
    """Return the routes of one of these paths."""
    router = APIRouter(route_class=ApiRoute, tags=[goals.tag], prefix=goals.path)
    send, listing, get, cancel = goals.names

    @router.post(
        "",
        name=send,
        description=goals.description,
        status_code=202,
        response_model=goals.goal,
        responses={200: {"model": goals.goal, "description": "It ended"}},
        openapi_extra={**goals.body, "parameters": HEADERS},
    )
    @carries_out(send_goal, goals.scope)
    async def send_one(
        request: Request, parts: AllParts, principal: ThePrincipal, place: Annotated[GoalsAt, Depends(goals.sends)]
    ) -> Response:
        wait, key = read_wait(request), read_own_key(request)
        order = SendGoal(await _read_goal(request), place.action, place.verb or "dock", place.robot, key)
        action, goal = await send_goal(parts, principal, order)
        return await answer_sent(request, action, goal, place.path, wait)

    @router.get("", name=listing, response_model=goals.page)
    @operation(Role.VIEWER, goals.scope)
    async def list_goals(
        parts: AllParts,
        grant: TheGrant,
        place: Annotated[GoalsAt, Depends(goals.sends)],
        *,
        status: StatusQuery = None,
        limit: LimitQuery = 50,
        cursor: CursorQuery = None,
    ) -> Response:
        """List goals, newest first."""
        return await answer_page(parts[Goals], await place.select(parts, grant, status or ()), limit, cursor)

    @router.get("/{goal_id}", name=get, response_model=goals.goal)
    @operation(Role.VIEWER, Scope.GOAL)
    async def get_goal(goal_id: GoalId, parts: AllParts, place: Annotated[GoalsAt, Depends(goals.place)]) -> Response:
        """Return one goal."""
        return place.answer(await place.goal(parts, goal_id))

    _add_cancel(router, cancel, goals.goal, goals.place)
    return router


async def _read_goal(request: Request) -> object:
    """Return the decoded body of a request; None if there is none.

    Raises:
        InvalidField: It is `null`.
        MalformedRequest: It is not JSON, or has another content type.
    """
    if not await read_body(request):
        return None
    if (goal := await read_json(request)) is None:
        raise InvalidField([FieldError("", "an object", got(goal))])
    return goal


def _add_cancel(router: APIRouter, name: str, model: type[BaseModel], place: Find) -> None:
    """Add the route that cancels a goal."""

    @router.post("/{goal_id}/cancel", name=name, status_code=202, response_model=model)
    @carries_out(cancel_goal)
    async def cancel(
        goal_id: GoalId, parts: AllParts, principal: ThePrincipal, place: Annotated[GoalsAt, Depends(place)]
    ) -> Response:
        """Ask the action server to cancel a goal, whoever sent it."""
        await place.goal(parts, goal_id)
        return place.answer(await cancel_goal(parts, principal, CancelGoal(goal_id)), 202)


def _docks(verb: Verb, description: str, body: dict[str, Any], scope: Scope, prefix: str = "") -> GoalCollection:
    """Return the goals of `/dock` or `/undock`, whose operations have names with a prefix."""
    path = f"/{verb}"

    async def here() -> GoalsAt:
        return GoalsAt.of_verb(verb)

    async def of_robot(robot: RobotQuery = None) -> GoalsAt:
        return GoalsAt(path, verb, robot=robot)

    names = (verb, f"list_{prefix}goals", f"get_{prefix}goal", f"cancel_{prefix}goal")
    return GoalCollection(path, verb.capitalize(), names, description, body, scope, Goal, GoalPage, here, of_robot)


async def _of_action(name: GraphName) -> GoalsAt:
    return GoalsAt.of_action(name)


async def _anywhere() -> GoalsAt:
    return GoalsAt.of_all()


WAITING = "`Prefer: wait=30` waits for the end. `Idempotency-Key` makes a retry return the first goal that was sent."
TYPES = "The robot's docking server decides which further fields there are: those of its goal message are taken, too."
DOCK = _docks(
    "dock",
    "Send the robot to its charging dock.\n\nAn empty body asks for CHARGING, at the default dock. `dock_id` names the "
    "dock, where the docking server knows docks by name; with our own server, `nearest` means the dock that the robot "
    f"is nearest to. {TYPES} {WAITING}",
    docking_body("dock_id"),
    Scope.DOCK,
)
UNDOCK = _docks(
    "undock",
    "Drive the robot off its charging dock. Our own server's goal succeeds immediately if the robot is known not to be "
    "docked, and is aborted (`DOCKED_UNKNOWN`) if nothing tells.\n\n"
    f"An empty body asks for a battery that is not charging, 2 or 3. {TYPES} {WAITING}",
    docking_body(),
    Scope.UNDOCK,
    "undock_",
)
ACTION = GoalCollection(
    "/actions/{name:graph_name}/goals",
    "Actions",
    ("send_action_goal", "list_action_goals", "get_action_goal", "cancel_action_goal"),
    "Send a goal. The body holds the fields of the goal message; `{}` sends its defaults.",
    body({"type": "object", "description": "The goal message's own fields"}, required=True),
    Scope.ACTION,
    ActionGoal,
    ActionGoalPage,
    _of_action,
    _of_action,
)
dock, undock, of_action = routes_of(DOCK), routes_of(UNDOCK), routes_of(ACTION)
anywhere = APIRouter(route_class=ApiRoute, tags=["Goals"], prefix="/goals")
_add_cancel(anywhere, "cancel_any_goal", ActionGoal, _anywhere)
