"""What a schedule does at a time: rules over plain data, without a clock or a database."""

import uuid
from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime, timedelta

from dock_gateway.extensions.missions.schedules.schedule import IfRunning, ScheduleEntry

# A time that was missed is made up if it is no longer ago.
MAKE_UP = timedelta(hours=1)
MISSED, STILL_RUNNING = "schedule_missed", "still_running"


@dataclass(frozen=True)
class Run:
    """A mission is to be queued, with this id, for a time."""

    due_at: datetime
    mission_id: str


@dataclass(frozen=True)
class Skip:
    """No mission is queued for a time: why."""

    due_at: datetime
    code: str
    detail: str


def mission_id_of(schedule_id: str, due_at: datetime) -> str:
    """Return the id of the mission of a schedule at a time: each gateway comes to the same one."""
    return uuid.uuid5(uuid.NAMESPACE_OID, f"schedule {schedule_id} {due_at.isoformat()}").hex


def decide(
    schedule_id: str, schedule: ScheduleEntry, open_missions: Collection[str], now: datetime
) -> Run | Skip | None:
    """Return what is to be done now; None: nothing.

    Of several times that were missed, the last one counts.

    Args:
        schedule_id: Its id.
        schedule: The schedule.
        open_missions: The ids of its missions that have not ended.
        now: The time.
    """
    first = schedule.next_due
    if first is None or first > now:
        return None
    due = schedule.times.last(now, schedule.changed_at) or first
    mission_id = mission_id_of(schedule_id, due)
    if mission_id in open_missions:
        return Run(due, mission_id)  # it was queued by a gateway that could not say so
    if now - due > MAKE_UP:
        return Skip(due, MISSED, f"no gateway could queue a mission within {MAKE_UP // timedelta(minutes=1)} minutes")
    if open_missions and schedule.if_running is IfRunning.SKIP:
        return Skip(due, STILL_RUNNING, "its last mission had not ended")
    return Run(due, mission_id)
