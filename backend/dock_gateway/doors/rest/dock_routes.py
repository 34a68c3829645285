"""`/dock` and `/undock`: goals on a robot's docking and undocking actions. `/docks`: those that its server knows."""

from dataclasses import dataclass
from typing import Any

from fastapi import APIRouter, Request

from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import NotFound
from dock_gateway.core.filters import parent_of
from dock_gateway.core.goal import Goal as GoalRecord
from dock_gateway.core.goal import Verb
from dock_gateway.core.grant import Role
from dock_gateway.doors.rest.answers import HEADERS, answer_page, answer_sent
from dock_gateway.goals.action import Action
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.goals.schema import Goal, GoalPage
from dock_gateway.http.openapi import docking_body
from dock_gateway.http.operation import Scope, carries_out, operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import TheGrant, ThePrincipal, read_own_key
from dock_gateway.http.requests import (
    Answer,
    CursorQuery,
    GoalId,
    LimitQuery,
    RobotQuery,
    StatusQuery,
    goal_response,
    json_response,
    read_json,
    read_wait,
)
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations.goals import CancelGoal, SendGoal, cancel_goal, send_goal
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.schema import DockList
from dock_gateway.storage import GoalFilter


@dataclass(frozen=True)
class Operations:
    """The operations at `/dock` or `/undock`.

    Attributes:
        verb: `dock` or `undock`. Also the path.
        description: What sending a goal does.
        body: Schema of the simple request.
        scope: The action of the robot that they are about.
        prefix: Prefix of the names of the other operations.
    """

    verb: Verb
    description: str
    body: dict[str, Any]
    scope: Scope
    prefix: str = ""

    @property
    def path(self) -> str:
        """`/dock` or `/undock`."""
        return f"/{self.verb}"


WAITING = "`Prefer: wait=30` waits for the end. `Idempotency-Key` makes a retry return the first goal that was sent."
TYPES = "The robot's docking server decides which further fields there are: those of its goal message are taken, too."
DOCK = Operations(
    "dock",
    "Send the robot to its charging dock.\n\nAn empty body asks for CHARGING, at the default dock. `dock_id` names the "
    "dock, where the docking server knows docks by name; with our own server, `nearest` means the dock that the robot "
    f"is nearest to. {TYPES} {WAITING}",
    docking_body("dock_id"),
    Scope.DOCK,
)
UNDOCK = Operations(
    "undock",
    "Drive the robot off its charging dock. Our own server's goal succeeds immediately if the robot is known not to be "
    "docked, and is aborted (`DOCKED_UNKNOWN`) if nothing tells.\n\n"
    f"An empty body asks for a battery that is not charging, 2 or 3. {TYPES} {WAITING}",
    docking_body(),
    Scope.UNDOCK,
    "undock_",
)


async def find_goal(goals: Goals, verb: Verb, goal_id: str) -> GoalRecord:
    """Return a goal that docks or undocks a robot.

    Raises:
        NotFound: There is no such goal, or it is one of another kind.
    """
    goal = await goals.get(goal_id)
    if goal.verb != verb:
        raise NotFound(f"goal {goal_id} is on {goal.action_name}: see /goals/{goal_id}", code="goal_not_found")
    return goal


def goal_routes(operations: Operations) -> APIRouter:
    """Return the routes of a verb."""
    verb, path = operations.verb, operations.path
    router = APIRouter(route_class=ApiRoute, tags=[verb.capitalize()], prefix=path)

    @router.post(
        "",
        name=verb,
        description=operations.description,
        status_code=202,
        responses={200: {"model": Goal, "description": "It ended"}},
        openapi_extra={**operations.body, "parameters": HEADERS},
    )
    @carries_out(send_goal, operations.scope)
    async def send_docking_goal(
        request: Request, parts: AllParts, principal: ThePrincipal, robot: RobotQuery = None
    ) -> Answer[Goal]:
        wait, key = read_wait(request), read_own_key(request)

        async def read(action: Action) -> Any:
            audited(request, action_name=action.name, robot=parent_of(action.name))
            return action.parse_request(await read_json(request, empty=action.default_request))

        action, goal = await send_goal(parts, principal, SendGoal(read, verb=verb, robot=robot, key=key))
        return await answer_sent(request, action, goal, path, wait)

    @router.get("", name=f"list_{operations.prefix}goals")
    @operation(Role.VIEWER, operations.scope, errors=(404,))
    async def list_goals(
        robot_actions: Part[RobotActions],
        actions: Part[ActionRegistry],
        robots: Part[RobotRegistry],
        goals: Part[Goals],
        grant: TheGrant,
        *,
        robot: RobotQuery = None,
        status: StatusQuery = None,
        limit: LimitQuery = 50,
        cursor: CursorQuery = None,
    ) -> Answer[GoalPage]:
        """List goals, newest first."""
        await robot_actions.find(verb, robot)
        names = actions.docking.all_names(robots.get(robot).namespace, verb)
        covered = frozenset(filter(grant.covers_action, names))
        wanted = GoalFilter(names, statuses=frozenset(status or ()), among=covered)
        return await answer_page(goals, wanted, limit, cursor)

    @router.get("/{goal_id}", name=f"get_{operations.prefix}goal")
    @operation(Role.VIEWER, Scope.GOAL)
    async def get_goal(goal_id: GoalId, goals: Part[Goals]) -> Answer[Goal]:
        """Return one goal, of any robot."""
        return goal_response(await find_goal(goals, verb, goal_id), f"{path}/{goal_id}")

    @router.post("/{goal_id}/cancel", name=f"cancel_{operations.prefix}goal", status_code=202)
    @carries_out(cancel_goal)
    async def cancel_docking_goal(
        goal_id: GoalId, goals: Part[Goals], parts: AllParts, principal: ThePrincipal
    ) -> Answer[Goal]:
        """Ask the action server to cancel a goal, whoever sent it."""
        await find_goal(goals, verb, goal_id)
        goal = await cancel_goal(parts, principal, CancelGoal(goal_id))
        return goal_response(goal, f"{path}/{goal_id}", 202)

    return router


docks_router = APIRouter(route_class=ApiRoute, tags=["Dock"])


@docks_router.get("/docks")
@operation(Role.VIEWER, Scope.DOCK)
async def list_docks(
    robot_actions: Part[RobotActions], docks: Part[Docks], robot: RobotQuery = None
) -> Answer[DockList]:
    """List the docks of the robot's docking server, in its order. There are none if it knows no docks by name."""
    action = await robot_actions.find("dock", robot)
    return json_response(await docks.document(action.name, action.family))


routers = (goal_routes(DOCK), goal_routes(UNDOCK), docks_router)
