"""The schedules, as people see and change them."""

import logging
from collections.abc import Callable, Iterator
from datetime import datetime
from typing import Any

from dock_gateway.core.errors import FieldError, InvalidField, fields_of_a_message
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.missions.missions import Missions
from dock_gateway.extensions.missions.schedules.rule import STILL_RUNNING
from dock_gateway.extensions.missions.schedules.schedule import ScheduleBody, ScheduleEntry
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import AlertKind
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.storage.shared_entries import SharedBook

log = logging.getLogger(__name__)

MAX_SCHEDULES = 200
FAILED = AlertKind("schedule_failed", critical=False)
# The fields that change without a person.
BY_THEMSELVES = frozenset({"after", "last"})


class Schedules:
    """The schedules of all gateways that share the history.

    Args:
        book: Stores them.
        missions: Checks what they queue.
        robots: The robots.
        clock: Returns the time.
    """

    def __init__(
        self,
        book: SharedBook[ScheduleEntry],
        missions: Missions,
        robots: RobotRegistry,
        clock: Callable[[], datetime] = utc_now,
    ) -> None:
        self.book = book
        self._missions = missions
        self._robots = robots
        self._clock = clock

    async def documents(self, grant: Grant = UNLIMITED) -> list[dict[str, Any]]:
        """Return the schedules as `GET /schedules` shows them, by id: those all of whose mission is covered.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        found = sorted((await self.book.read()).items())
        return [self._document(key, schedule) for key, schedule in found if await self._covers(schedule, grant)]

    async def document(self, schedule_id: str, grant: Grant = UNLIMITED) -> dict[str, Any]:
        """Return a schedule as `GET /schedules/{schedule_id}` shows it.

        Raises:
            NotFound: There is none, or the grant does not cover it (`schedule_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        schedule = await self.book.find(schedule_id)
        if not await self._covers(schedule, grant):
            raise self.book.missing(schedule_id)
        return self._document(schedule_id, schedule)

    async def replace(
        self, schedule_id: str, body: ScheduleBody, grant: Grant, condition: Condition = UNCONDITIONAL
    ) -> tuple[dict[str, Any], bool]:
        """Store a schedule, new or changed; return it, and whether it is new. What was due before does not count.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            Conflict: `limit_reached`.
            InvalidField, NotAllowed: Its mission could not be queued now, or its time is over; with the path.
            NotFound: `template_not_found`, or `robot_not_found` unless it was the schedule's already.
            Unavailable: The history does not answer (`history_unavailable`); the schedule is what it was.
        """
        known = (await self.book.read()).get(schedule_id)
        robot = None if body.group is not None else body.robot or self._robots.find(None)
        if robot is not None and (known is None or known.robot != robot):
            self._robots.get(robot)
        with fields_of_a_message("mission"):
            await self._missions.make(body.mission, robot, grant, None, body.group)
        schedule = body.entry(robot, self._clock(), None if known is None else known.last)
        if schedule.enabled and schedule.next_due is None:
            raise InvalidField([FieldError("once.due_at", "a time to come", "it is over")])
        new = await self.book.replace(schedule_id, schedule, condition=condition)
        state = "on" if schedule.enabled else "off"
        log.info("schedule %s for %s: %s, by %s", schedule_id, robot or body.group, state, schedule.changed_by)
        return self._document(schedule_id, schedule), new

    async def remove(self, schedule_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a schedule.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: `schedule_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the schedule is still there.
        """
        await self.book.remove(schedule_id, condition)
        log.info("schedule %s removed", schedule_id)

    def alerts(self) -> Iterator[Alert]:
        """Return an alert for each robot with schedules that could not queue a mission the last time.

        Those for groups are an alert of no robot.
        """
        failed: dict[str | None, list[tuple[datetime, str]]] = {}
        for schedule_id, schedule in sorted(self.book.all().items()):
            last = schedule.last
            if last is None or last.code in (None, STILL_RUNNING) or not schedule.enabled:
                continue
            if last.decided_at >= schedule.changed_at:
                said = f"{schedule.name or schedule_id}: no mission at {last.due_at:%Y-%m-%d %H:%M} UTC: {last.detail}"
                failed.setdefault(schedule.robot, []).append((last.decided_at, said))
        for robot, each in failed.items():
            yield Alert(FAILED, robot, min(each)[0], "Schedule failed", "; ".join(said for _, said in each))

    async def _covers(self, schedule: ScheduleEntry, grant: Grant) -> bool:
        if not grant.limited:
            return True
        return await self._missions.covers(schedule.mission, schedule.robot, grant, schedule.group)

    def _document(self, schedule_id: str, schedule: ScheduleEntry) -> dict[str, Any]:
        return {
            "id": schedule_id,
            "etag": self.book.etag(schedule),
            **schedule.model_dump(exclude={"after"}),
            "next_at": schedule.next_due,
        }
