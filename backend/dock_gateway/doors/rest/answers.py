"""Answers to those who send and list goals, for `/dock` and `/actions/…`."""

import uuid
from http import HTTPStatus
from typing import Any

from fastapi import Request

from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import NotAuthenticated
from dock_gateway.core.goal import Goal
from dock_gateway.core.request import wait_while_permitted
from dock_gateway.goals.action import Action
from dock_gateway.goals.goals import Goals
from dock_gateway.http.requests import Answer, goal_response, json_response
from dock_gateway.storage import GoalFilter

HEADERS = [
    {"name": "Prefer", "in": "header", "schema": {"type": "string"}, "example": "wait=30"},
    {"name": "Idempotency-Key", "in": "header", "schema": {"type": "string", "minLength": 1, "maxLength": 200}},
]


async def answer_sent(request: Request, action: Action, goal: Goal, base: str, wait: float) -> Answer[Any]:
    """Answer a request that has sent a goal; before that, wait for its end if the `Prefer` header asks for it.

    Args:
        request: The request.
        action: The action.
        goal: The goal.
        base: Path of the goals. `Location` is this path followed by the goal id.
        wait: Seconds to wait at most.
    """
    trail = audited(request, goal_id=goal.goal_id)
    if wait:
        await trail.record(HTTPStatus.ACCEPTED)  # the gateway may be killed before the goal ends
        try:
            await wait_while_permitted(action.tracker.wait_terminal(goal, wait))
        except NotAuthenticated as ended:
            raise NotAuthenticated(f"{ended.detail}; the goal goes on", code=ended.code, goal_id=goal.goal_id) from None
    return goal_response(goal, f"{base}/{goal.goal_id}", 200 if wait and goal.status.terminal else 202)


async def answer_page(goals: Goals, wanted: GoalFilter, limit: int, cursor: uuid.UUID | None) -> Answer[Any]:
    """Answer with a page of goals, newest first."""
    page, next_cursor = await goals.page(wanted, limit, str(cursor) if cursor else None)
    return json_response({"goals": [goal.document() for goal in page], "next_cursor": next_cursor})
