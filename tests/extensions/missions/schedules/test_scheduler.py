"""Missions that schedules queue, in virtual time, by one gateway or two."""

import asyncio
from datetime import datetime, timedelta
from types import SimpleNamespace
from typing import Any, cast

import pytest
from pydantic import ValidationError

from dock_gateway.core.errors import GatewayError, NotFound, Unavailable, limit_reached
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.grant import Grant
from dock_gateway.core.share import EVERYTHING
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.mission import HoldReason, MissionEntry, MissionStatus
from dock_gateway.extensions.missions.schedules.schedule import ScheduleEntry
from dock_gateway.extensions.missions.schedules.scheduler import Scheduler
from dock_gateway.extensions.missions.schedules.schedules import BY_THEMSELVES, Schedules
from dock_gateway.extensions.missions.schema import MissionContent
from dock_gateway.extensions.missions.turns import RobotFacts, find_turns
from dock_gateway.stop.last_stops import LastStop, LastStops
from dock_gateway.storage.shared_entries import SharedBook
from tests.extensions.missions.examples import NOON
from tests.extensions.missions.schedules.examples import body
from tests.support.entries import EntriesInMemory, SharedStore
from tests.support.virtual import in_virtual_time

HOUR = 3600.0


class Missions:
    """The missions of a gateway, which nobody carries out."""

    def __init__(self, site: "Site") -> None:
        self.book = MissionBook(Fanout(queue_limit=1), site.missions, site.past, lambda *_: True)
        self.refuses: list[GatewayError] = []

    async def make(
        self, content: MissionContent, robot: str | None, _: Grant, by: str | None, group: str | None = None
    ) -> MissionEntry:
        await asyncio.sleep(0.01)
        if self.refuses:
            raise self.refuses.pop(0)
        return content.entry(robot, by=by, group=group)

    async def queue(self, mission_id: str, mission: MissionEntry) -> None:
        await self.book.add(mission_id, mission)


class Site:
    """Gateways that share a history, with the robot `/`."""

    def __init__(self, gateways: int = 1) -> None:
        self.schedules = SharedStore[ScheduleEntry]()
        self.last_stops = LastStops(SharedStore[LastStop]())
        self.missions, self.past = EntriesInMemory[MissionEntry](), EntriesInMemory[MissionEntry]()
        self.there = True
        self.off = timedelta(0)  # of the clock
        self.gateways = [self.open() for _ in range(gateways)]

    def now(self) -> datetime:
        return NOON + timedelta(seconds=asyncio.get_running_loop().time()) + self.off

    def get(self, robot: str | None) -> Any:
        if not self.there:
            raise NotFound(f"there is no robot {robot}", code="robot_not_found")
        return SimpleNamespace(namespace=robot)

    def find(self, _: None) -> str:
        return "/"

    def open(self) -> tuple[Schedules, Missions, Scheduler]:
        missions = Missions(self)
        book = SharedBook(self.schedules, "schedule", 10, BY_THEMSELVES)
        made = cast("Any", missions)
        scheduler = Scheduler(
            book, made, robots=cast("Any", self), last_stops=self.last_stops, share=EVERYTHING, clock=self.now
        )
        scheduler.start()
        return Schedules(book, made, cast("Any", self), self.now), missions, scheduler

    async def put(self, schedule_id: str = "a", **fields: Any) -> None:
        await self.gateways[0][0].replace(schedule_id, body(**fields), cast("Any", None))

    async def shown(self, schedule_id: str = "a") -> dict[str, Any]:
        return await self.gateways[0][0].document(schedule_id)

    async def last(self) -> dict[str, Any]:
        found = (await self.shown())["last"]
        assert isinstance(found, dict)
        return found

    async def end_all(self) -> None:
        book = self.gateways[0][1].book
        for mission_id, mission in [*(await book.read()).items()]:
            assert await book.change(mission_id, mission, mission.but(status=MissionStatus.SUCCEEDED))


@in_virtual_time
async def test_each_time_queues_one_mission_with_two_gateways() -> None:
    site = Site(gateways=2)
    await site.put(if_running="queue", mission={"name": "Round", "priority": 7, "steps": [{"dock": {}}]})
    await site.put("b")
    await asyncio.sleep(3 * HOUR + 5)
    own = [mission for mission in site.missions.known.values() if mission.schedule == "a"]
    assert [(mission.name, mission.priority, mission.robot) for mission in own] == 3 * [("Round", 7, "/")]
    assert len(site.missions.known) == 4  # that of "b" has not ended
    shown = await site.shown()
    assert shown["last"]["mission_id"] in site.missions.known
    assert shown["next_at"] == shown["last"]["due_at"] + timedelta(hours=1)
    assert (await site.shown("b"))["last"]["code"] == "still_running"
    await site.end_all()
    await asyncio.sleep(HOUR)
    assert {mission.schedule for mission in site.missions.known.values()} == {"a", "b"}


@in_virtual_time
async def test_a_mission_whose_gateway_was_killed_is_not_queued_again() -> None:
    site = Site()
    await site.put()
    ((_, missions, scheduler),) = site.gateways
    queue = missions.queue

    async def queue_and_die(mission_id: str, mission: MissionEntry) -> None:
        await queue(mission_id, mission)
        site.schedules.away = True
        await asyncio.sleep(1e6)

    missions.queue = queue_and_die  # type: ignore[method-assign]
    await asyncio.sleep(HOUR + 10)
    await scheduler.close()
    site.schedules.away = False
    assert len(site.missions.known) == 1
    site.gateways = [site.open()]
    await asyncio.sleep(60)
    assert [(await site.last())["mission_id"]] == [*site.missions.known]


@in_virtual_time
async def test_what_was_missed_is_made_up_or_said() -> None:
    site = Site()
    await site.put(daily={"times": ["13:30"], "time_zone": "Europe/Berlin"})
    for away, code in ((1.0 * HOUR, None), (24.7 * HOUR, "schedule_missed")):
        site.schedules.away = True
        await asyncio.sleep(away)
        site.schedules.away = False
        await asyncio.sleep(10)
        assert (await site.last())["code"] == code
        await site.end_all()
    (alert,) = site.gateways[0][0].alerts()
    assert (alert.robot, alert.kind.value) == ("/", "schedule_failed")
    assert "no gateway could queue a mission within 60 minutes" in alert.detail
    await site.put(daily={"times": ["13:30"], "time_zone": "Europe/Berlin"})
    assert [*site.gateways[0][0].alerts()] == []


@in_virtual_time
async def test_what_cannot_be_queued_is_said_and_the_next_time_is_tried() -> None:
    site = Site()
    await site.put()
    site.gateways[0][1].refuses = [limit_reached(500, "missions")]
    await asyncio.sleep(HOUR + 5)
    last = await site.last()
    assert (last["mission_id"], last["code"]) == (None, "limit_reached")
    assert [alert.detail.partition(": ")[0] for alert in site.gateways[0][0].alerts()] == ["a"]
    site.gateways[0][1].refuses = [Unavailable("ROS is away")]  # it is tried again
    await asyncio.sleep(HOUR)
    assert (await site.last())["mission_id"] in site.missions.known
    assert [*site.gateways[0][0].alerts()] == []


@in_virtual_time
async def test_a_robot_is_waited_for_a_minute() -> None:
    site = Site()
    await site.put()
    site.there = False
    await asyncio.sleep(HOUR + 30)
    assert (await site.shown())["last"] is None
    site.there = True
    await asyncio.sleep(5)
    assert (await site.last())["mission_id"] is not None
    await site.end_all()
    site.there = False
    await asyncio.sleep(HOUR + 70)
    assert (await site.last())["code"] == "robot_not_found"


@in_virtual_time
async def test_a_clock_that_is_set_back_repeats_nothing() -> None:
    site = Site()
    await site.put(if_running="queue")
    await asyncio.sleep(HOUR + 5)
    site.off -= timedelta(hours=3)
    await asyncio.sleep(3 * HOUR)
    assert len(site.missions.known) == 1
    await asyncio.sleep(HOUR)
    assert len(site.missions.known) == 2
    site.off += timedelta(days=30)
    await asyncio.sleep(10)
    assert len(site.missions.known) == 3


@in_virtual_time
async def test_one_that_is_off_or_removed_queues_nothing() -> None:
    site = Site()
    await site.put()
    await site.put(enabled=False)
    assert (await site.shown())["next_at"] is None
    await site.put("b")
    await site.gateways[0][0].remove("b")
    await asyncio.sleep(5 * HOUR)
    assert site.missions.known == {}


@in_virtual_time
async def test_a_released_stop_starts_no_mission_of_a_schedule() -> None:
    site = Site()
    await site.put(if_running="queue")
    await asyncio.sleep(60)
    site.last_stops.note("/", site.now())
    await asyncio.sleep(HOUR)
    (held,) = site.missions.known.values()
    assert (held.status, held.held_for) == (MissionStatus.HELD, HoldReason.STOP)
    await site.last_stops.allow("/", site.now())
    await asyncio.sleep(HOUR)
    assert [each.status for each in site.missions.known.values()] == [MissionStatus.HELD, MissionStatus.QUEUED]
    site.last_stops.note("/", site.now())
    await asyncio.sleep(60)
    await site.put(if_running="queue")  # stored anew since: that is somebody's word, too
    await asyncio.sleep(HOUR)
    assert [*site.missions.known.values()][-1].status is MissionStatus.QUEUED


@in_virtual_time
async def test_missions_for_a_group_are_queued_once_and_begin_on_no_robot_that_was_stopped_since() -> None:
    site = Site(gateways=2)
    await site.put(group="pickers")
    stored_at = site.now()
    site.there = False  # whose robots are there does not count
    await asyncio.sleep(60)
    site.last_stops.note("/robot1", site.now())
    await asyncio.sleep(HOUR)
    (mission,) = site.missions.known.values()
    assert (mission.robot, mission.group, mission.status) == (None, "pickers", MissionStatus.QUEUED)
    stopped = RobotFacts(("pickers",), free=True, charge=0.9, stopped_at=site.last_stops.at("/robot1"))
    assert mission.allowed_since == stored_at
    assert find_turns(site.missions.known, {"/robot1": stopped}).on == {}
    other = RobotFacts(("pickers",), free=True, charge=0.5)
    turns = find_turns(site.missions.known, {"/robot1": stopped, "/robot2": other})
    assert [*turns.on] == ["/robot2"]


@in_virtual_time
async def test_a_schedule_for_a_group_that_fails_is_an_alert_of_no_robot() -> None:
    site = Site()
    await site.put(group="pickers")
    site.gateways[0][1].refuses = [limit_reached(500, "missions")]
    await asyncio.sleep(HOUR + 10)
    (alert,) = site.gateways[0][0].alerts()
    assert (alert.robot, "there are 500 missions" in alert.detail) == (None, True)


def test_a_schedule_is_for_a_robot_or_a_group() -> None:
    with pytest.raises(ValidationError, match="a robot or a group"):
        body(robot="/robot1", group="pickers")
