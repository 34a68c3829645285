"""Answers to those who send and cancel goals."""

from datetime import datetime
from http import HTTPStatus
from typing import Any

from fastapi import Request

from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import NotAuthenticated
from dock_gateway.core.goal import Goal
from dock_gateway.core.request import wait_while_permitted
from dock_gateway.goals.action import Action
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goal_path import GOAL
from dock_gateway.http.openapi import IDEMPOTENCY_KEY
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import Answer, json_response

HEADERS = [{"name": "Prefer", "in": "header", "schema": {"type": "string"}, "example": "wait=30"}, IDEMPOTENCY_KEY]


async def answer_sent(
    request: Request, parts: Parts, action: Action, goal: Goal, wait: float, *, began: datetime
) -> Answer[Any]:
    """Answer a request that has sent a goal; before that, wait for its end if the `Prefer` header asks for it.

    Args:
        request: The request.
        parts: The parts of the gateway.
        action: The action.
        goal: The goal.
        wait: Seconds to wait at most.
        began: When the request was read: a goal that is older was sent by an earlier one with the same key.
    """
    trail = audited(request, goal_id=goal.goal_id)
    if wait:
        await trail.record(HTTPStatus.ACCEPTED)  # the gateway may be killed before the goal ends
        try:
            await wait_while_permitted(action.tracker.wait_terminal(goal, wait))
        except NotAuthenticated as ended:
            raise NotAuthenticated(f"{ended.detail}; the goal goes on", code=ended.code, goal_id=goal.goal_id) from None
    return answer_goal(parts, goal, 200 if (wait or goal.created_at < began) and goal.status.terminal else 202)


def answer_goal(parts: Parts, goal: Goal, status: int) -> Answer[Any]:
    """Answer with a goal, and with its path as `Location`."""
    return json_response(parts[GoalDocuments].brief(goal), status, {"Location": GOAL.format(goal_id=goal.goal_id)})
