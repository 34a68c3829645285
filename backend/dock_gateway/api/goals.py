"""What `/dock`, `/actions/…` and `/goals` have in common: sending, listing and finding goals."""

import uuid
from typing import Any

from fastapi import Request
from starlette.responses import Response

from dock_gateway.actions import Action
from dock_gateway.api.answers import goal_response, json_response
from dock_gateway.api.requests import read_json, read_key, read_wait
from dock_gateway.errors import NotFound
from dock_gateway.gateway import Gateway
from dock_gateway.goals import Goal, GoalStatus
from dock_gateway.history import Wanted

HEADERS = [
    {"name": "Prefer", "in": "header", "schema": {"type": "string"}, "example": "wait=30"},
    {"name": "Idempotency-Key", "in": "header", "schema": {"type": "string", "minLength": 1, "maxLength": 200}},
]


async def send_goal(request: Request, action: Action, base: str, default: dict[str, Any] | None = None) -> Response:
    """Send the goal in the body, or `default`; wait for its end where `Prefer` asks for it.

    Args:
        request: The request.
        action: The action.
        base: Path that a goal id is appended to for `Location`.
        default: The goal's fields where the body is empty; None where it must not be. A message's defaults are a goal
            only for who says `{}`: zeros may well be a pose to drive to.
    """
    wait, key = read_wait(request), read_key(request)
    message = action.port.goal_codec.parse(await read_json(request, empty=default))
    goal = await action.goals.submit(message, key)
    if wait:
        await action.goals.wait(goal, wait)
    return goal_response(goal, f"{base}/{goal.goal_id}", 200 if wait and goal.status.terminal else 202)


async def list_goals(gateway: Gateway, wanted: Wanted, limit: int, cursor: uuid.UUID | None) -> Response:
    """A page of goals, newest first."""
    goals, next_cursor = await gateway.page(wanted, limit, str(cursor) if cursor else None)
    return json_response({"goals": [goal.document() for goal in goals], "next_cursor": next_cursor})


def on_action(action: Action, statuses: list[GoalStatus] | None) -> Wanted:
    """The goals of one action, in these states."""
    return Wanted(frozenset({action.name}), statuses=frozenset(statuses or ()))


async def find_goal(gateway: Gateway, action: Action, goal_id: str) -> Goal:
    """A goal of this action.

    Raises:
        NotFound: There is none with this id.
    """
    goal = await gateway.goal(goal_id)
    if goal.action_name != action.name:
        raise NotFound(f"goal {goal_id} is on {goal.action_name}, not on {action.name}", code="goal_not_found")
    return goal
