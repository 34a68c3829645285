"""Goals where they are sent: `/dock`, `/undock` and `/actions/{name}/goals` are one router at three paths.

A goal itself is at `/goals/{goal_id}`, wherever it was sent.
"""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Verb
from dock_gateway.core.grant import Role
from dock_gateway.doors.rest.answers import HEADERS, answer_goal, answer_sent
from dock_gateway.goals.goal_path import at_goal
from dock_gateway.goals.history_routes import answer_page
from dock_gateway.goals.queries import GoalQuery
from dock_gateway.goals.schema import Goal, GoalPage
from dock_gateway.http.openapi import body, docking_body
from dock_gateway.http.operation import Audit, Scope, carries_out, operation
from dock_gateway.http.parts import AllParts
from dock_gateway.http.principal import TheGrant, ThePrincipal, read_own_key
from dock_gateway.http.requests import (
    WITH_POSITION,
    Answer,
    CursorQuery,
    GoalId,
    GraphName,
    LimitQuery,
    RobotQuery,
    read_body,
    read_json,
    read_wait,
)
from dock_gateway.http.resource import LOCATION_HEADER
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations.goals import CancelGoal, SendGoal, cancel_goal, send_goal
from dock_gateway.storage import GoalFilter


@dataclass(frozen=True)
class Target:
    """Where a request sends its goal, or which goals it lists.

    Attributes:
        verb: What the goals do with their robot, if the path says that.
        action: Absolute name of their action, if the path says that.
        robot: The robot that the query names; None: the configured one.
    """

    verb: Verb | None = None
    action: str | None = None
    robot: str | None = None

    def narrow(self, wanted: GoalFilter) -> GoalFilter:
        """Return the filter of those of the goals that are sent here."""
        names = wanted.action_names if self.action is None else frozenset({self.action})
        return replace(wanted, verb=self.verb, action_names=names)


Find = Callable[..., Awaitable[Target]]


@dataclass(frozen=True)
class GoalCollection:
    """One of the paths where goals are sent.

    Attributes:
        path: The path.
        tag: Its section in the OpenAPI document.
        names: The names of its operations: send, list.
        description: What sending a goal does.
        body: Schema of the request.
        scope: What sending is about.
        target: Dependency that returns where goals are sent, from the path and the query.
        place: The same, from the path alone.
        listed: Whether its list is documented.
    """

    path: str
    tag: str
    names: tuple[str, str]
    description: str
    body: dict[str, Any]
    scope: Scope
    target: Find
    place: Find
    listed: bool = True


AT: dict[str, Any] = {"headers": LOCATION_HEADER}


def routes_of(goals: GoalCollection) -> APIRouter:
    """Return the routes of one of these paths."""
    router = APIRouter(route_class=ApiRoute, tags=[goals.tag], prefix=goals.path)
    send, listing = goals.names

    @router.post(
        "",
        name=send,
        description=goals.description,
        status_code=202,
        response_model=Goal,
        responses={200: {"model": Goal, "description": "It ended"} | AT, 202: AT},
        openapi_extra={**goals.body, "parameters": HEADERS},
    )
    @carries_out(send_goal, goals.scope)
    async def send_one(
        request: Request, parts: AllParts, principal: ThePrincipal, target: Annotated[Target, Depends(goals.target)]
    ) -> Response:
        began, wait, key = utc_now(), read_wait(request), read_own_key(request)
        order = SendGoal(await _read_goal(request), target.action, target.verb or "dock", target.robot, key)
        action, goal = await send_goal(parts, principal, order)
        return await answer_sent(request, parts, action, goal, wait, began=began)

    @router.get("", name=listing, include_in_schema=goals.listed, responses=WITH_POSITION)
    @operation(Role.VIEWER, Scope.LISTED, Audit.NEVER, errors=(404,))
    async def list_sent(
        parts: AllParts,
        grant: TheGrant,
        place: Annotated[Target, Depends(goals.place)],
        query: Annotated[GoalQuery, Query()],
        *,
        limit: LimitQuery = 50,
        cursor: CursorQuery = None,
    ) -> Answer[GoalPage]:
        """List goals, newest first. This is `GET /goals` with the `verb` of this path."""
        wanted = place.narrow(await query.to_filter(parts, grant))
        return await answer_page(parts, grant, wanted, limit, cursor)

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


def _docks(verb: Verb, description: str, body: dict[str, Any], scope: Scope) -> GoalCollection:
    """Return the goals of `/dock` or `/undock`."""

    async def place() -> Target:
        return Target(verb)

    async def target(robot: RobotQuery = None) -> Target:
        return Target(verb, robot=robot)

    names = (verb, f"list_{verb}_goals")
    return GoalCollection(f"/{verb}", verb.capitalize(), names, description, body, scope, target, place)


async def _of_action(name: GraphName) -> Target:
    return Target(action=f"/{name}")


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
)
ACTION = GoalCollection(
    "/actions/{name:graph_name}/goals",
    "Actions",
    ("send_action_goal", "list_action_goals"),
    "Send a goal. The body holds the fields of the goal message; `{}` sends its defaults.",
    body({"type": "object", "description": "The goal message's own fields"}, required=True),
    Scope.ACTION,
    _of_action,
    _of_action,
    listed=False,  # `GET /goals?action=` is the documented way
)
dock, undock, of_action = routes_of(DOCK), routes_of(UNDOCK), routes_of(ACTION)
canceling = APIRouter(route_class=ApiRoute, tags=["Goals"])


@at_goal(canceling, "POST", "/cancel", name="cancel_goal", status_code=202, responses={202: AT})
@carries_out(cancel_goal)
async def cancel(goal_id: GoalId, parts: AllParts, principal: ThePrincipal) -> Answer[Goal]:
    """Ask the action server to cancel a goal of any client."""
    return answer_goal(parts, await cancel_goal(parts, principal, CancelGoal(goal_id)), 202)
