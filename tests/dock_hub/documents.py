"""Documents of a site."""

from datetime import UTC, datetime
from typing import Any

import orjson

from dock_gateway.core.goal import Goal, GoalError, GoalStatus, encode
from tests.support import small_site

AT = datetime(2026, 11, 27, 12, 0, 0, 123456, tzinfo=UTC)
GOAL_ID = "6a8c2b0a-5c63-4d0e-9c1e-0d7a9c4d5e6f"


def ended_goal() -> Goal:
    """A goal that has every field."""
    goal = Goal(GOAL_ID, "/robot1/dock", "pkg/action/Dock", AT, verb="dock", goal=b'{"a":1}', result=b'{"b":[null]}')
    goal.status, goal.finished_at, goal.error = GoalStatus.ABORTED, AT, GoalError("blocked", "a box")
    goal.last_event_id, goal.feedback_count, goal.stage, goal.retries = "0-z-x", 3, "approach", 1
    return goal


def decoded(document: object) -> Any:
    """What a reader makes of a document that is sent."""
    return orjson.loads(encode(document))


ROBOT = small_site.ROBOT | {"last_goal": decoded(ended_goal().state())}
