"""Schedules for tests."""

import json
from datetime import datetime
from typing import Any

from dock_gateway.extensions.missions.schedules.schedule import ScheduleBody, ScheduleEntry

HOURLY: dict[str, Any] = {"every": {"minutes": 60}}
MISSION: dict[str, Any] = {"steps": [{"wait": {"seconds": 60}}]}


def body(**fields: Any) -> ScheduleBody:
    """A schedule as clients send it."""
    times = {} if fields.keys() & {"once", "daily", "every"} else HOURLY
    return ScheduleBody.model_validate_json(json.dumps({"mission": MISSION} | times | fields))


def schedule(now: datetime, **fields: Any) -> ScheduleEntry:
    """A schedule that was stored."""
    return body(**fields).entry("/", now, None)
