"""Goals of a site as those of the hub, and what happens to them. Plain data in, plain data out."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal
from uuid import UUID

import orjson

from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_hub import fields
from dock_hub.fields import ForeignDocumentError

# Bytes of a goal or its result, and of its last feedback. A larger one is left out; the site has it.
MAX_MESSAGE, MAX_FEEDBACK = 128 * 1024, 4096
ORIGINS = ("gateway", "automation", "external")
VERBS = ("dock", "undock", None)


@dataclass(frozen=True)
class Happening:
    """A change of a goal that a site has reported.

    Attributes:
        kind: Its state changed, or it ended with a result.
        goal: The goal as it was then, with names of the hub.
        at: When it happened, by the site's clock.
    """

    kind: Literal["status", "result"]
    goal: Goal
    at: datetime


def read_goal(site: str, document: Any) -> Goal:
    """Return a goal of a site as one of the hub: of `GET /goals` or a snapshot, or of a `status` event.

    Raises:
        ForeignDocumentError: It is not a goal.
    """
    try:
        origin, verb = document["origin"], document["verb"]
        if origin not in ORIGINS or verb not in VERBS:
            raise ForeignDocumentError(f"a goal has the origin {origin!r:.40} and the verb {verb!r:.40}")
        goal = Goal(
            goal_id=read_goal_id(document["goal_id"]),
            action_name=fields.name(site, document["action_name"]),
            action_type=fields.text(site, document["action_type"]),
            created_at=read_time(document["created_at"]),
            origin=origin,
            verb=verb,
            status=GoalStatus(document["status"]),
            goal=_message(document["goal"]),
            feedback=_message(document.get("feedback"), MAX_FEEDBACK),
            result=_message(document.get("result")),
            error=read_error(document["error"]),
            stage=fields.maybe(fields.text)(site, document["stage"]),
            retries=fields.maybe(fields.count)(site, document["retries"]),
            stalled=fields.flag(site, document["stalled"]),
            finished_at=None if document["finished_at"] is None else read_time(document["finished_at"]),
            feedback_count=fields.count(site, document["feedback_count"]),
        )
        goal.updated_at = read_time(document["updated_at"])
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, ForeignDocumentError):
            raise
        raise ForeignDocumentError(f"not a goal: {type(error).__name__}: {error}") from None
    return goal


def finish_goal(goal: Goal, event: Any) -> None:
    """Give a goal of the hub what the `result` event of a site says: how it ended.

    Raises:
        ForeignDocumentError: It is not such an event.
    """
    try:
        status = GoalStatus(event["status"])
        if not status.terminal:
            raise ForeignDocumentError(f"a result of a goal that is {status}")
        goal.result, goal.error = _message(event["result"]), read_error(event["error"])
        if goal.status is not status:
            goal.status, goal.stalled = status, False
            goal.updated_at = goal.finished_at = read_time(event["time"])
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, ForeignDocumentError):
            raise
        raise ForeignDocumentError(f"not the end of a goal: {type(error).__name__}: {error}") from None


def ends_of(goal: Goal) -> list[Happening]:
    """Return the events of a goal's end, as they follow from the goal: those of the site may be gone."""
    if not goal.status.final:
        return []
    at = goal.finished_at or goal.updated_at
    return [Happening("status", goal, at), Happening("result", goal, at)]


def read_goal_id(value: Any) -> str:
    """Return the id of a goal.

    Raises:
        ForeignDocumentError: It is not a UUID.
    """
    try:
        return str(UUID(value))
    except (ValueError, TypeError, AttributeError):
        raise ForeignDocumentError(f"{value!r:.60} is not the id of a goal") from None


def read_time(value: Any) -> datetime:
    """Return a time.

    Raises:
        ForeignDocumentError: It is none, or has no time zone.
    """
    try:
        time = datetime.fromisoformat(value)
    except (ValueError, TypeError):
        time = None
    if time is None or time.tzinfo is None or not 1971 < time.year < 2200:
        raise ForeignDocumentError(f"{value!r:.60} is not a time")
    return time


def read_error(value: Any) -> GoalError | None:
    """Return why a goal did not succeed.

    Raises:
        ForeignDocumentError: It is not an error of a goal.
    """
    if value is None:
        return None
    if not isinstance(value, dict):
        raise ForeignDocumentError(f"{value!r:.60} is not the error of a goal")
    return GoalError(fields.text("", value.get("code")), fields.text("", value.get("detail")))


def size_of(goal: Goal) -> int:
    """Return the bytes of the messages of a goal."""
    return sum(len(message) for message in (goal.goal, goal.feedback, goal.result) if message is not None)


def _message(value: Any, most: int = MAX_MESSAGE) -> bytes | None:
    if value is None:
        return None
    if not isinstance(value, dict):
        raise ForeignDocumentError(f"{value!r:.60} is not a message")
    message = orjson.dumps(value)
    return message if len(message) <= most else None
