"""`/goals`: the goals of every action; and sending, listing and finding goals for `/dock` and `/actions/…`."""

import uuid
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import Annotated, Any, Literal

import orjson
from fastapi import APIRouter, Depends, Query, Request
from starlette.responses import Response

from dock_gateway.core.errors import NotAuthenticated, NotFound, Unavailable
from dock_gateway.core.event import KINDS, STORED_KINDS
from dock_gateway.core.filters import parent_of
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.grant import Role
from dock_gateway.core.request import wait_while_permitted
from dock_gateway.gateway import Gateway
from dock_gateway.goals.action import Action
from dock_gateway.goals.schema import ActionGoal, GoalHistory, TaggedGoalPage
from dock_gateway.http.audit_trail import audited
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.principal import read_own_key
from dock_gateway.http.problems import problems
from dock_gateway.http.queries import EVENT_ID, QUERY, GoalFilterQuery
from dock_gateway.http.requests import (
    CursorQuery,
    GoalId,
    LimitQuery,
    TheGateway,
    goal_response,
    json_response,
    known_query,
    read_json,
    read_wait,
)
from dock_gateway.storage import GoalFilter

HEADERS = [
    {"name": "Prefer", "in": "header", "schema": {"type": "string"}, "example": "wait=30"},
    {"name": "Idempotency-Key", "in": "header", "schema": {"type": "string", "minLength": 1, "maxLength": 200}},
]


async def send_goal(
    request: Request, action: Action, base: str, *, pick: Callable[[], Awaitable[Action]] | None = None
) -> Response:
    """Send the goal in the body. Wait for its end if the `Prefer` header asks for it.

    Args:
        request: The request.
        action: The action.
        base: Path of the goals. `Location` is this path followed by the goal id.
        pick: For requests to dock or undock: returns the robot's action as it is picked now. Their body may be empty.
            The body of other goals must not: to use a message's defaults, a client has to send `{}`, as all zeros may
            be a pose to drive to.
    """
    audited(request, action_name=action.name, robot=parent_of(action.name))
    wait, key = read_wait(request), read_own_key(request)
    if pick is None:
        message = action.port.goal_codec.parse(await read_json(request))
        goal = await action.submitter.submit(message, key)
    else:
        action, goal = await _send_docking_goal(
            action, pick, await read_json(request, empty=action.default_request), key
        )
        audited(request, action_name=action.name)
    trail = audited(request, goal_id=goal.goal_id)
    if wait:
        await trail.record(HTTPStatus.ACCEPTED)  # the gateway may be killed before the goal ends
        try:
            await wait_while_permitted(action.tracker.wait_terminal(goal, wait))
        except NotAuthenticated as ended:
            raise NotAuthenticated(f"{ended.detail}; the goal goes on", code=ended.code, goal_id=goal.goal_id) from None
    return goal_response(goal, f"{base}/{goal.goal_id}", 200 if wait and goal.status.terminal else 202)


async def _send_docking_goal(
    action: Action, pick: Callable[[], Awaitable[Action]], body: object, key: str | None
) -> tuple[Action, Goal]:
    """Send a goal to an action or, if it has no server and another one is picked meanwhile, to that one.

    Raises:
        Conflict: `stopped`: a stop was requested meanwhile.
    """
    stops = action.delivery.stops
    try:
        return action, await action.submitter.submit(action.parse_request(body), key)
    except Unavailable:
        if action.on_graph or (other := await pick()) is action:
            raise
    action.delivery.require_no_stop_since(stops)
    return other, await other.submitter.submit(other.parse_request(body), key)


async def list_goals(gateway: Gateway, wanted: GoalFilter, limit: int, cursor: uuid.UUID | None) -> Response:
    """Return a page of goals, newest first."""
    goals, next_cursor = await gateway.page(wanted, limit, str(cursor) if cursor else None)
    return json_response({"goals": [goal.document() for goal in goals], "next_cursor": next_cursor})


def on_action(action: Action, statuses: list[GoalStatus] | None) -> GoalFilter:
    """Return a filter for the goals of one action in these states."""
    return GoalFilter(frozenset({action.name}), statuses=frozenset(statuses or ()))


async def find_goal(gateway: Gateway, action: Action, goal_id: str) -> Goal:
    """Return a goal of this action.

    Raises:
        NotFound: The action has no goal with this id.
    """
    goal = await gateway.goal(goal_id)
    if goal.action_name != action.name:
        raise NotFound(f"goal {goal_id} is on {goal.action_name}, not on {action.name}", code="goal_not_found")
    return goal


router = APIRouter(tags=["Goals"], prefix="/goals")

NO_QUERY = Depends(known_query())


@router.get(
    "",
    response_model=TaggedGoalPage,
    responses=problems(422, 503),
    dependencies=[Depends(known_query(*QUERY, "limit", "cursor"))],
)
@operation(Role.VIEWER, Scope.LISTED)
async def list_all_goals(
    gateway: TheGateway, wanted: GoalFilterQuery, limit: LimitQuery = 50, cursor: CursorQuery = None
) -> Response:
    """List the goals of all actions with their tags, newest first."""
    goals, next_cursor = await gateway.page(wanted, limit, str(cursor) if cursor else None)
    return json_response({"goals": await with_tags(gateway, goals), "next_cursor": next_cursor})


async def with_tags(gateway: Gateway, goals: list[Goal]) -> list[dict[str, Any]]:
    """Return the documents of goals, with their tags."""
    tags = await gateway.history.notes.tags_of([goal.goal_id for goal in goals])
    return [goal.document() | {"tags": tags.get(goal.goal_id, ())} for goal in goals]


@router.get("/{goal_id}", response_model=ActionGoal, responses=problems(404, 422, 503), dependencies=[NO_QUERY])
@operation(Role.VIEWER, Scope.GOAL)
async def get_any_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
    """Return one goal, on any action."""
    return goal_response(await gateway.goal(goal_id), f"/goals/{goal_id}")


@router.post(
    "/{goal_id}/cancel",
    status_code=202,
    response_model=ActionGoal,
    responses=problems(404, 409, 422, 503, 504),
    dependencies=[NO_QUERY],
)
@operation(Role.OPERATOR, Scope.GOAL)
async def cancel_any_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
    """Ask the action server to cancel a goal, on any action, whoever sent it."""
    return goal_response(await gateway.cancel(goal_id), f"/goals/{goal_id}", 202)


TypeQuery = Annotated[
    list[Literal["status", "feedback", "result", "pose"]] | None,
    Query(description="Only events of these types; by default all but `pose`"),
]
AfterQuery = Annotated[
    str | None, Query(pattern=f"^{EVENT_ID.pattern}$", description="Id of the event that they follow")
]


@router.get(
    "/{goal_id}/history",
    response_model=GoalHistory,
    responses=problems(404, 422, 503),
    dependencies=[Depends(known_query("type", "after", "limit"))],
)
@operation(Role.VIEWER, Scope.GOAL)
async def goal_history(
    goal_id: GoalId,
    gateway: TheGateway,
    *,
    type: TypeQuery = None,  # noqa: A002 - it is what the events call it
    after: AfterQuery = None,
    limit: Annotated[int, Query(ge=1, le=5000)] = 1000,
) -> Response:
    """List the events of a goal as they were sent on the streams, oldest first; or the stored poses of its robot."""
    goal = await gateway.goal(goal_id)
    kinds = frozenset(STORED_KINDS[name] for name in type or KINDS)
    complete = await gateway.history.knows_all_of(goal)
    events = await gateway.history.events_of(goal_id, kinds=kinds, after=after or "", limit=limit + 1)
    page = events[:limit]
    return json_response(
        {
            "events": [orjson.Fragment(event.data) for event in page],
            "next_after": page[-1].id if len(events) > limit else None,
            "complete": complete,
        }
    )
