"""`/dock` and `/undock`: goals on a robot's docking and undocking actions."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.actions.registry import Action
from dock_gateway.core.errors import NotFound
from dock_gateway.core.goal import Goal as GoalRecord
from dock_gateway.gateway import Gateway
from dock_gateway.robots.battery import CHARGING
from dock_gateway.web.openapi import battery_body
from dock_gateway.web.problems import problems
from dock_gateway.web.requests import (
    CursorQuery,
    GoalId,
    LimitQuery,
    RobotQuery,
    StatusQuery,
    TheGateway,
    goal_response,
    known_query,
)
from dock_gateway.web.routes import goals
from dock_gateway.web.schemas.goals import Goal, GoalPage

NOT_CHARGING: dict[str, Any] = {"desired_battery_state": {}}


@dataclass(frozen=True)
class Verb:
    """The operations at `/dock` or `/undock`.

    Attributes:
        name: `dock` or `undock`. Also the path.
        description: What sending a goal does.
        default: The goal that an empty body sends.
        action_of: Returns the action of the named robot; None means the configured robot.
        prefix: Prefix of the names of the other operations.
    """

    name: str
    description: str
    default: dict[str, Any]
    action_of: Callable[[Gateway, str | None], Awaitable[Action]]
    prefix: str = ""

    @property
    def path(self) -> str:
        """`/dock` or `/undock`."""
        return f"/{self.name}"


WAITING = "`Prefer: wait=30` waits for the end. `Idempotency-Key` makes a retry return the first goal that was sent."
DOCK = Verb(
    "dock",
    f"Send the robot to its charging dock.\n\nAn empty body asks for CHARGING. {WAITING}",
    CHARGING,
    Gateway.dock_of,
)
UNDOCK = Verb(
    "undock",
    "Drive the robot off its charging dock. If it is not docked, the goal succeeds immediately.\n\n"
    f"An empty body asks for a battery that is not charging, 2 or 3. {WAITING}",
    NOT_CHARGING,
    Gateway.undock_of,
    "undock_",
)


def goal_routes(verb: Verb) -> APIRouter:
    """Return the routes of a verb."""
    router = APIRouter(tags=[verb.name.capitalize()], prefix=verb.path)

    @router.post(
        "",
        name=verb.name,
        description=verb.description,
        status_code=202,
        response_model=Goal,
        responses={
            200: {"model": Goal, "description": "It ended"},
            **problems(400, 404, 409, 413, 415, 422, 429, 503, 504),
        },
        openapi_extra={**battery_body(required=False, wrapped="desired_battery_state"), "parameters": goals.HEADERS},
        dependencies=[Depends(known_query("robot"))],
    )
    async def send_goal(request: Request, gateway: TheGateway, robot: RobotQuery = None) -> Response:
        return await goals.send_goal(request, await verb.action_of(gateway, robot), verb.path, verb.default)

    @router.get(
        "",
        name=f"list_{verb.prefix}goals",
        response_model=GoalPage,
        responses=problems(404, 422),
        dependencies=[Depends(known_query("robot", "status", "limit", "cursor"))],
    )
    async def list_goals(
        gateway: TheGateway,
        robot: RobotQuery = None,
        status: StatusQuery = None,
        limit: LimitQuery = 50,
        cursor: CursorQuery = None,
    ) -> Response:
        """List goals, newest first."""
        wanted = goals.on_action(await verb.action_of(gateway, robot), status)
        return await goals.list_goals(gateway, wanted, limit, cursor)

    async def find_goal(gateway: Gateway, goal_id: str) -> GoalRecord:
        goal = await gateway.goal(goal_id)
        if gateway.settings.verb_of(goal.action_name) != verb.name:
            raise NotFound(f"goal {goal_id} is on {goal.action_name}: see /goals/{goal_id}", code="goal_not_found")
        return goal

    @router.get("/{goal_id}", name=f"get_{verb.prefix}goal", response_model=Goal, responses=problems(404, 422))
    async def get_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
        """Return one goal, of any robot."""
        return goal_response(await find_goal(gateway, goal_id), f"{verb.path}/{goal_id}")

    @router.post(
        "/{goal_id}/cancel",
        name=f"cancel_{verb.prefix}goal",
        status_code=202,
        response_model=Goal,
        responses=problems(404, 409, 422, 503, 504),
    )
    async def cancel_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
        """Ask the action server to cancel a goal, whoever sent it."""
        await find_goal(gateway, goal_id)
        return goal_response(await gateway.cancel(goal_id), f"{verb.path}/{goal_id}", 202)

    return router


routers = (goal_routes(DOCK), goal_routes(UNDOCK))
