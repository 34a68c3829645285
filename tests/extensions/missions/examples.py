"""Missions for tests, and what is known of their robots."""

import json
from datetime import UTC, datetime, timedelta
from typing import Any

from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.progress import start
from dock_gateway.extensions.missions.schema import MissionBody

NOON = datetime(2026, 11, 30, 12, tzinfo=UTC)
DOCK, UNDOCK = {"dock": {}}, {"undock": {}}
CALL = {"call": {"service": "/reset"}}
PUBLISH = {"publish": {"topic": "/light", "message": {"data": True}}}
NAVIGATE = {"navigate": {"pose": {"x": 1, "y": 2}}}
FIBONACCI = {"action": {"name": "/fibonacci", "goal": {"order": 5}}}


def queued(*steps: dict[str, Any], robot: str | None = "/", **fields: Any) -> MissionEntry:
    """A mission that has not begun."""
    body = MissionBody.model_validate_json(json.dumps({"steps": [*steps], **fields}))
    return body.entry(robot).model_copy(update={"group": body.group, "created_at": NOON})


def begun(*steps: dict[str, Any], **fields: Any) -> MissionEntry:
    """A mission that began at noon."""
    return start(queued(*steps, **fields), NOON)


def goal(status: GoalStatus, code: str | None = None) -> Goal:
    """The goal of a step."""
    error = None if code is None else GoalError(code, "as the test says")
    made = Goal("goal", "/dock", "pkg/action/T", NOON, error=error)
    made.status = status
    return made


def after(seconds: float) -> datetime:
    """Return a time of that day."""
    return NOON + timedelta(seconds=seconds)
