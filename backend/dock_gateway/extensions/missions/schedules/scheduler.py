"""Queues the missions of schedules when they are due, each once, also with several gateways on one history."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from datetime import datetime, timedelta
from typing import Any

from dock_gateway.core.errors import Conflict, GatewayError, NotFound, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.missions.mission import HoldReason, MissionStatus
from dock_gateway.extensions.missions.missions import Missions
from dock_gateway.extensions.missions.schedules.rule import Run, Skip, decide
from dock_gateway.extensions.missions.schedules.schedule import ScheduleEntry, ScheduleOutcome
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.stop.last_stops import LastStops
from dock_gateway.storage.shared_entries import SYNC_INTERVAL, SharedBook

log = logging.getLogger(__name__)

# Seconds between two looks at the schedules.
INTERVAL = 1.0
# How long a robot that is not there is waited for: after a start, robots are found within seconds.
ROBOT_WITHIN = timedelta(minutes=1)


class Scheduler:
    """Queues missions.

    Args:
        book: The schedules.
        missions: The missions.
        robots: The robots.
        last_stops: When they were last stopped.
        share: The robots that this gateway serves.
        clock: Returns the time.
    """

    def __init__(
        self,
        book: SharedBook[ScheduleEntry],
        missions: Missions,
        *,
        robots: RobotRegistry,
        last_stops: LastStops,
        share: Share,
        clock: Callable[[], datetime] = utc_now,
    ) -> None:
        self._book = book
        self._missions = missions
        self._robots = robots
        self._last_stops = last_stops
        self._share = share
        self._clock = clock
        self._waits: dict[str, datetime] = {}  # since when a robot is waited for, by the mission's id
        self._busy: set[str] = set()  # schedules
        self._synced = float("-inf")  # on the clock of the loop
        self._tasks = Tasks("queuing missions of schedules")

    def start(self) -> None:
        """Queue missions from now on."""
        self._tasks.repeat(self._look, INTERVAL, "looking at schedules")

    async def close(self) -> None:
        """Queue no more."""
        await self._tasks.close()

    async def _look(self) -> None:
        loop = asyncio.get_running_loop()
        if loop.time() - self._synced >= SYNC_INTERVAL and await self._book.sync():
            self._synced = loop.time()
        now = self._clock()
        for schedule_id, schedule in self._book.all().items():
            ours = schedule.robot is None or self._share.covers_robot(schedule.robot)
            due = schedule.next_due if ours else None
            if due is not None and due <= now and schedule_id not in self._busy:
                self._busy.add(schedule_id)
                self._tasks.spawn(self._follow(schedule_id))

    async def _follow(self, schedule_id: str) -> None:
        """Do what a schedule says now, as it is stored now.

        Raises:
            Unavailable: The history does not answer; it is asked again.
        """
        try:
            schedule = (await self._book.read()).get(schedule_id)
            if schedule is None:
                return
            missions = await self._missions.book.read()
            own = {key for key, mission in missions.items() if mission.schedule == schedule_id}
            match decide(schedule_id, schedule, own, self._clock()):
                case Run() as run:
                    outcome = await self._queue(schedule_id, schedule, run)
                case Skip(due_at, code, detail):
                    outcome = ScheduleOutcome(due_at=due_at, decided_at=self._clock(), code=code, detail=detail)
                case None:
                    return
            if outcome is not None:
                await self._store(schedule_id, schedule, outcome)
        finally:
            self._busy.discard(schedule_id)

    async def _queue(self, schedule_id: str, schedule: ScheduleEntry, run: Run) -> ScheduleOutcome | None:
        """Queue a mission; return what came of it, or None if it is to be tried again.

        Raises:
            Unavailable: The history does not answer, or ROS.
        """
        code = detail = None
        try:
            if not await self._is_queued(run.mission_id):
                if schedule.robot is not None:
                    self._robots.get(schedule.robot)
                mission = await self._missions.make(schedule.mission, schedule.robot, UNLIMITED, None, schedule.group)
                allowed = await self._allowed(schedule)
                queued = mission.model_copy(update={"schedule": schedule_id, **allowed})
                await self._missions.queue(run.mission_id, queued)
        except Unavailable:
            raise
        except GatewayError as error:
            code, detail = error.code, error.detail
        now = self._clock()
        since = self._waits.setdefault(run.mission_id, now)
        if code == "robot_not_found" and timedelta(0) <= now - since < ROBOT_WITHIN:
            return None
        del self._waits[run.mission_id]
        mission_id = run.mission_id if code is None else None
        return ScheduleOutcome(due_at=run.due_at, decided_at=now, mission_id=mission_id, code=code, detail=detail)

    async def _allowed(self, schedule: ScheduleEntry) -> dict[str, Any]:
        """Return the fields of a mission that say whom a person has let begin it: who has stored the schedule.

        The mission is held if its robot was stopped since, and still waits for a person.

        Raises:
            Unavailable: The history does not answer.
        """
        if schedule.robot is None:
            return {"allowed_at": schedule.changed_at}
        await self._last_stops.read()
        stopped_at = self._last_stops.at(schedule.robot)
        if stopped_at is None or stopped_at < schedule.changed_at:
            return {}
        return {"status": MissionStatus.HELD, "held_for": HoldReason.STOP}

    async def _is_queued(self, mission_id: str) -> bool:
        """Return whether there is a mission: a gateway that has queued it was killed before it could say so."""
        try:
            await self._missions.book.find(mission_id)
        except NotFound:
            return False
        return True

    async def _store(self, schedule_id: str, schedule: ScheduleEntry, outcome: ScheduleOutcome) -> None:
        """Store what came of a time, unless another gateway was first, or somebody has changed the schedule.

        Raises:
            Unavailable: The history does not answer.
        """

        def check(stored: Mapping[str, ScheduleEntry]) -> None:
            found = stored.get(schedule_id)
            if found is None or found.changed_at != schedule.changed_at or not _is_news(found, outcome):
                raise Conflict("it was changed meanwhile")

        try:
            await self._book.store(schedule_id, schedule.decided(outcome), check)
        except Conflict:
            await self._book.read()
        else:
            said = outcome.mission_id or outcome.detail
            log.info("schedule %s at %s: %s", schedule_id, outcome.due_at.isoformat(), said)


def _is_news(stored: ScheduleEntry, outcome: ScheduleOutcome) -> bool:
    """Return whether nothing is stored of a time yet, or only that another gateway could not queue its mission."""
    if stored.after != outcome.due_at or stored.last is None:
        return stored.after < outcome.due_at
    return stored.last.mission_id is None and outcome.mission_id is not None
