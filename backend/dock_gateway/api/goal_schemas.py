"""The shapes of what is told of goals on any action, beside the goals themselves; as in `schemas`, for types alone."""

from datetime import datetime
from typing import Any, Literal

from dock_gateway.api.schemas import ActionGoal, GoalError, GoalState, Schema
from dock_gateway.goals import GoalStatus


class ActionStatusEvent(GoalState):
    """The state of a goal on any action changed."""

    type: Literal["status"]
    id: str
    time: datetime
    goal: dict[str, Any] | None


class ActionFeedbackEvent(Schema):
    """Feedback of a goal on any action."""

    type: Literal["feedback"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    feedback: dict[str, Any]


class ActionResultEvent(Schema):
    """A goal on any action ended."""

    type: Literal["result"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    status: GoalStatus
    result: dict[str, Any] | None
    error: GoalError | None


class GoalHistory(Schema):
    """The events of a goal, oldest first; `next_after` where there are more, `complete` where none was given up."""

    events: list[ActionStatusEvent | ActionFeedbackEvent | ActionResultEvent]
    next_after: str | None
    complete: bool


class ExportedGoal(ActionGoal):
    """A goal with its events, oldest first; `complete` where none was given up."""

    complete: bool
    events: list[ActionStatusEvent | ActionFeedbackEvent | ActionResultEvent]
