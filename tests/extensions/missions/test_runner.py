"""Missions that are carried out in virtual time, by one gateway or two, with action servers of the test."""

import asyncio
from dataclasses import replace
from datetime import timedelta
from itertools import pairwise
from typing import Any, cast

import pytest

from dock_gateway.core.battery import PowerSupply
from dock_gateway.core.errors import Conflict, DockOccupied, Unavailable
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.extensions.missions import book, progress
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.places.place import PlaceBody
from dock_gateway.extensions.missions.step_kinds import Waypoint
from dock_gateway.extensions.missions.turns import RobotFacts
from tests.extensions.missions.examples import CALL, DOCK, FIBONACCI, NOON, PUBLISH, queued
from tests.extensions.missions.runners import Site, now
from tests.support.virtual import in_virtual_time


@in_virtual_time
async def test_a_mission_begins_at_once_and_the_next_one_after_it() -> None:
    site = Site()
    await site.add(DOCK, {"wait": {"seconds": 2.5}}, FIBONACCI)
    await site.add(FIBONACCI, mission_id="b")
    first, second = await site.ended("a"), await site.ended("b")
    assert first.started_at is not None
    assert first.finished_at is not None
    assert first.started_at - NOON < timedelta(seconds=0.1)
    assert timedelta(seconds=22.5) <= first.finished_at - NOON < timedelta(seconds=22.7)
    assert second.started_at is not None
    assert timedelta(0) <= second.started_at - first.finished_at < timedelta(seconds=0.1)
    assert [*site.server.goals] == ["mission-a-0-1", "mission-a-2-1", "mission-b-0-1"]
    assert site.store.known == {}


@in_virtual_time
async def test_two_gateways_make_each_change_once() -> None:
    site = Site(gateways=2)
    await site.add(*(5 * [FIBONACCI]))
    mission = await site.ended()
    assert (mission.status, len(site.server.goals)) == (MissionStatus.SUCCEEDED, 5)
    assert [step.attempt for step in mission.steps] == 5 * [1]


@in_virtual_time
async def test_of_two_ends_the_first_counts() -> None:
    site = Site()
    first, second = (MissionBook(Fanout(queue_limit=1), site.store, site.past, lambda *_: True) for _ in range(2))
    mission = progress.start(queued(DOCK), NOON)
    await first.add("x", mission)
    await second.read()
    assert await first.change("x", mission, progress.succeed(mission, NOON))
    assert not await second.change("x", mission, mission.but(status=MissionStatus.CANCELED))
    assert (await second.find("x")).status is site.past.known["x"].status is MissionStatus.SUCCEEDED


@in_virtual_time
async def test_an_end_whose_gateway_was_killed_is_moved_by_another() -> None:
    site = Site()
    mission = progress.start(queued(DOCK), NOON)
    for mission_id in ("a", "b"):
        site.store.known[mission_id] = progress.succeed(mission, NOON)
    assert (await site.ended("b")).status is MissionStatus.SUCCEEDED
    assert (await site.ended()).status is MissionStatus.SUCCEEDED
    assert site.server.goals == {}


@in_virtual_time
async def test_of_the_ended_ones_those_that_ended_last_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(book, "MAX_ENDED", 2)
    site = Site()
    await site.add({"wait": {"seconds": 60}}, mission_id="oldest", robot="/other")
    for mission_id in ("x", "y", "z"):
        later = queued({"wait": {"seconds": 1}}).model_copy(update={"created_at": NOON + timedelta(seconds=1)})
        await site.runners[0].book.add(mission_id, later)
    assert (await site.ended("oldest")).status is MissionStatus.SUCCEEDED
    assert [*site.past.known] == ["z", "oldest"]


@in_virtual_time
async def test_without_the_history_nothing_is_begun() -> None:
    site = Site()
    await site.add({"wait": {"seconds": 1}}, DOCK)
    await asyncio.sleep(0.5)
    site.store.away = True
    await asyncio.sleep(100)
    assert site.server.goals == {}
    site.store.away = False
    assert (await site.ended()).status is MissionStatus.SUCCEEDED


@in_virtual_time
async def test_a_server_that_is_away_is_waited_for() -> None:
    site = Site()
    site.server.there = False
    await site.add(DOCK)
    await asyncio.sleep(1000)
    assert site.runners[0].book.waits["a"] == "server"
    site.server.there = True
    site.server.refuses = [Unavailable("no server"), Unavailable("no server")]
    mission = await site.ended()
    assert (mission.status, mission.steps[0].attempt) == (MissionStatus.SUCCEEDED, 1)


@pytest.mark.parametrize("code", ["stopped", "stop_latched"])
def test_a_goal_that_a_stop_refuses_holds_the_mission(code: str) -> None:
    @in_virtual_time
    async def run() -> None:
        site = Site()
        site.server.refuses = [Conflict("a stop", code=code)]
        await site.add(DOCK)
        await asyncio.sleep(10)
        book = site.runners[0].book
        held = book.all()["a"]
        assert (held.status, held.held_for, held.current.status) == (MissionStatus.HELD, "stop", "waiting")
        await book.amend("a", UNLIMITED, lambda mission: progress.resume(mission, now()))
        assert (await site.ended()).steps[0].attempt == 2

    run()


@in_virtual_time
async def test_a_stop_that_does_not_stay_holds_what_runs_and_nothing_later() -> None:
    site = Site()
    (runner,) = site.runners
    await site.add({"wait": {"seconds": 60}})
    await asyncio.sleep(5)
    runner.on_stop("/")
    await asyncio.sleep(1)
    assert runner.book.all()["a"].held_for == "stop"
    assert not runner.has_work("/")
    runner.on_stop("/")  # it is held already: that must not hold it again later
    await runner.book.amend("a", UNLIMITED, lambda mission: progress.resume(mission, now()))
    runner.wake()
    assert (await site.ended()).status is MissionStatus.SUCCEEDED


@in_virtual_time
async def test_a_stop_that_does_not_stay_holds_what_another_gateway_has_just_begun() -> None:
    site = Site(gateways=2)
    await asyncio.sleep(10.5)
    first, second = site.runners
    await site.add({"wait": {"seconds": 60}})
    await asyncio.sleep(0.1)
    assert site.store.known["a"].status is MissionStatus.RUNNING
    assert second.book.all() == {}
    second.on_stop("/")
    await asyncio.sleep(0.1)
    assert site.store.known["a"].held_for == "stop"
    await first.book.amend("a", UNLIMITED, lambda mission: progress.resume(mission, now()))
    assert (await site.ended()).status is MissionStatus.SUCCEEDED


@in_virtual_time
async def test_after_a_stop_another_gateway_begins_no_mission_that_was_queued_before() -> None:
    site = Site(gateways=2)
    first, second = site.runners
    await site.add({"wait": {"seconds": 5}})
    await site.add(DOCK, mission_id="b")
    await asyncio.sleep(1)
    first.on_stop("/")
    await asyncio.sleep(0.1)
    await second.book.amend("a", UNLIMITED, lambda mission: progress.cancel(mission, now()))
    second.wake()
    await asyncio.sleep(10)
    assert (second.book.all()["b"].held_for, site.server.goals) == ("stop", {})
    await second.book.amend("b", UNLIMITED, lambda mission: progress.resume(mission, now()))
    assert (await site.ended("b")).status is MissionStatus.SUCCEEDED


@in_virtual_time
async def test_a_stop_counts_although_another_gateway_changes_the_mission_first() -> None:
    site = Site()
    (runner,) = site.runners
    await site.add({"wait": {"seconds": 60}})
    await asyncio.sleep(5)
    change = runner.book.change

    async def lose_once(mission_id: str, before: MissionEntry, after: MissionEntry, **more: Any) -> bool:
        runner.book.change = change  # type: ignore[method-assign]
        await change(mission_id, before, before.but())
        return await change(mission_id, before, after, **more)

    runner.book.change = lose_once  # type: ignore[method-assign]
    runner.on_stop("/")
    await asyncio.sleep(2)
    assert runner.book.all()["a"].held_for == "stop"


@in_virtual_time
async def test_a_goal_is_not_sent_for_a_mission_that_another_gateway_has_just_held() -> None:
    site = Site(gateways=2)
    site.server.there = False
    await site.add(DOCK)
    await asyncio.sleep(10)
    first, second = site.runners
    first.on_stop("/")
    await asyncio.sleep(0.05)
    assert first.book.all()["a"].held_for == "stop"
    site.server.there = True
    second.wake()
    await asyncio.sleep(60)
    assert site.server.goals == {}


@in_virtual_time
async def test_a_mission_that_is_canceled_while_another_gateway_sends_its_goal() -> None:
    """The other gateway cancels the goal that it has sent for nothing."""
    site = Site(gateways=2)
    site.server.takes = None
    await site.add(DOCK)
    await asyncio.sleep(0.005)  # the goal is on its way
    other = site.runners[1]
    await other.book.amend("a", UNLIMITED, lambda mission: progress.cancel(mission, now()))
    other.wake()
    assert (await site.ended()).status is MissionStatus.CANCELED
    await asyncio.sleep(10)
    assert site.server.running() == []


@in_virtual_time
async def test_a_lost_goal_is_given_up_and_nothing_moves_by_itself() -> None:
    site = Site()
    site.server.takes = None
    await site.add(DOCK | {"timeout_s": 30.0, "tries": 3})
    await asyncio.sleep(5)
    (lost,) = site.server.goals.values()
    lost.status = GoalStatus.LOST
    await asyncio.sleep(1000)
    book = site.runners[0].book
    assert (book.all()["a"].held_for, len(site.server.goals)) == ("lost", 1)
    await book.amend("a", UNLIMITED, lambda mission: progress.cancel(mission, now()))
    assert (await site.ended()).status is MissionStatus.CANCELED


@in_virtual_time
async def test_messages_are_sent_once_by_one_of_two_gateways() -> None:
    site = Site(gateways=2)
    await site.add(CALL, PUBLISH, {"notify": {"text": "Done"}})
    mission = await site.ended()
    assert (mission.status, site.server.messages) == (MissionStatus.SUCCEEDED, 2)
    alerts = [alert for runner in site.runners for alert in runner.book.notices.alerts(["/"])]
    assert {alert.detail for alert in alerts} == {"Done"}


FREE = RobotFacts(groups=("pickers",), free=True, charge=0.5)


@in_virtual_time
async def test_missions_of_a_group_are_taken_at_once_and_each_once() -> None:
    site = Site(gateways=2)
    site.free = {"/": replace(FREE, charge=0.9), "/a": FREE, "/b": FREE}
    began = asyncio.get_running_loop().time()
    for number in range(6):
        await site.add({"wait": {"seconds": 10}}, mission_id=f"{number}", robot=None, group="pickers")
    site.runners[1].wake()
    missions = [await site.ended(f"{number}") for number in range(6)]
    assert {mission.robot for mission in missions} == {"/", "/a", "/b"}
    assert missions[0].robot == "/"
    starts = [mission.started_at or NOON for mission in missions]
    assert starts == sorted(starts)
    assert (starts[2] - NOON).total_seconds() - began < 0.1
    assert {mission.revision for mission in missions} == {missions[0].revision}  # nothing was done twice
    for robot in site.free:
        own = sorted(
            (mission.started_at, mission.finished_at) for mission in missions if mission.robot == robot and mission
        )
        assert all(end <= start for (_, end), (start, _) in pairwise(cast("Any", own)))


@in_virtual_time
async def test_a_mission_of_a_group_says_what_it_waits_for() -> None:
    site = Site()
    book = site.runners[0].book
    await site.add({"wait": {"seconds": 1}}, robot=None, group="pickers")
    await asyncio.sleep(2)
    assert book.waits["a"] == "group"
    site.free = {"/": replace(FREE, free=False)}
    await asyncio.sleep(2)
    assert book.waits["a"] == "robot"
    assert not site.runners[0].has_work("/")
    site.free = {"/": FREE}
    assert (await site.ended()).robot == "/"


@in_virtual_time
async def test_a_released_stop_starts_no_robot_of_a_group_also_after_a_restart() -> None:
    site = Site()
    (runner,) = site.runners
    await site.add({"wait": {"seconds": 1}}, robot=None, group="pickers")
    await asyncio.sleep(2)
    runner.on_stop("/")
    site.free = {"/": replace(FREE, stopped_at=site.last_stops[0].at("/"))}
    await asyncio.sleep(2)
    await runner.close()
    other = site.open()
    await asyncio.sleep(2)
    stopped_at = site.last_stops[-1].at("/")
    assert stopped_at is not None
    site.free = {"/": replace(FREE, stopped_at=stopped_at)}
    await asyncio.sleep(10)
    assert other.book.waits["a"] == "continue"
    await other.book.amend("a", UNLIMITED, lambda mission: mission.but(allowed_at=now()))
    other.wake()
    assert (await site.ended()).robot == "/"


@in_virtual_time
async def test_a_message_that_fails_is_tried_again_and_one_that_a_stop_refuses_is_not() -> None:
    site = Site()
    site.server.fails = [Unavailable("away"), RuntimeError("a fault")]
    await site.add(CALL | {"tries": 3})
    mission = await site.ended()
    assert (mission.status, mission.steps[0].attempt, site.server.messages) == (MissionStatus.SUCCEEDED, 3, 3)
    site.server.fails = [Conflict("a stop", code="stop_latched")]
    await site.add(CALL, mission_id="b")
    await asyncio.sleep(10)
    assert (site.runners[0].book.all()["b"].held_for, site.server.messages) == ("stop", 4)


@in_virtual_time
async def test_a_latched_stop_keeps_a_message_from_being_sent() -> None:
    site = Site()
    await site.add({"wait": {"seconds": 5}}, CALL)
    site.runners[0].book.change, change = cast("Any", None), site.runners[0].book.change

    async def latch_late(mission_id: str, before: MissionEntry, after: MissionEntry, **more: Any) -> bool:
        changed = await change(mission_id, before, after, **more)
        site.held |= after.step == 1 and after.current.has_message
        return changed

    site.runners[0].book.change = latch_late  # type: ignore[method-assign]
    await asyncio.sleep(20)
    assert (site.runners[0].book.all()["a"].held_for, site.server.messages) == ("stop", 0)


@in_virtual_time
async def test_a_message_whose_gateway_was_killed_is_not_sent_again() -> None:
    site = Site()
    await site.add(CALL, DOCK)
    await asyncio.sleep(0.5)
    assert site.server.messages == 1
    await site.runners[0].close()
    other = site.open()
    await asyncio.sleep(30)
    assert other.book.waits["a"] == "answer"
    await asyncio.sleep(60)
    assert (other.book.all()["a"].held_for, site.server.messages, site.server.goals) == ("lost", 1, {})
    await other.book.amend("a", UNLIMITED, lambda mission: progress.skip(mission, now()))
    assert (await site.ended()).status is MissionStatus.SUCCEEDED


@in_virtual_time
async def test_a_place_is_where_it_is_when_the_step_begins() -> None:
    site = Site()
    await site.places.replace("shelf", PlaceBody(x=1, y=2).entry())
    await site.add({"wait": {"seconds": 5}}, {"navigate": {"place": "shelf"}})
    await site.places.replace("shelf", PlaceBody(x=3, y=4).entry())
    await asyncio.sleep(10)
    await site.places.replace("shelf", PlaceBody(x=5, y=6).entry())  # its goal is on its way
    mission = await site.ended()
    assert mission.status is MissionStatus.SUCCEEDED
    assert mission.steps[1].drives_to == Waypoint(x=3, y=4)
    assert site.server.read["pose"]["pose"]["position"] == {"x": 3, "y": 4}


@in_virtual_time
async def test_a_place_that_was_removed_fails_its_step() -> None:
    site = Site()
    await site.places.replace("shelf", PlaceBody(x=1, y=2).entry())
    drive = {"navigate": {"place": "shelf"}}
    await site.add({"wait": {"seconds": 5}}, drive | {"on_failure": "next"}, drive)
    await site.places.remove("shelf")
    mission = await site.ended()
    assert (mission.status, [step.status for step in mission.steps[1:]]) == (MissionStatus.FAILED, 2 * ["failed"])
    assert mission.error is not None
    assert (mission.error.code, site.server.goals) == ("place_not_found", {})


@in_virtual_time
async def test_a_step_whose_dock_is_occupied_waits_for_it() -> None:
    site = Site()
    site.server.refuses = [DockOccupied("/robot2 stands on the dock") for _ in range(50)]
    await site.add(DOCK)
    await asyncio.sleep(20)
    assert site.runners[0].book.waits == {"a": "dock"}
    mission = await site.ended()
    assert (mission.status, mission.steps[0].attempt) == (MissionStatus.SUCCEEDED, 1)


@in_virtual_time
async def test_a_step_that_waits_for_its_dock_fails_in_time() -> None:
    site = Site()
    site.server.refuses = [DockOccupied("/robot2 stands on the dock") for _ in range(1000)]
    await site.add({**DOCK, "timeout_s": 60})
    mission = await site.ended()
    error = mission.steps[0].error
    assert (mission.status, error and error.code) == (MissionStatus.FAILED, "step_timeout")


@in_virtual_time
async def test_a_step_that_waits_for_its_dock_also_waits_for_the_goal_of_somebody_else() -> None:
    site = Site()
    site.server.refuses = [DockOccupied("/robot2 stands on the dock") for _ in range(1000)]
    await site.add(DOCK)
    await asyncio.sleep(10)
    other = site.server.goals["of a person"] = Goal("other", "/work", "pkg/action/T", NOON)
    other.status = GoalStatus.EXECUTING
    site.server.refuses = []
    await asyncio.sleep(30)
    assert (site.runners[0].book.waits["a"], [*site.server.goals]) == ("other_goal", ["of a person"])
    site.server.end(other)
    assert (await site.ended()).status is MissionStatus.SUCCEEDED


def occupied(place: float = 1.0) -> DockOccupied:
    return DockOccupied("/robot2 stands on it", wait_at={"frame": "map", "x": place, "y": 2.0, "yaw": 0.0})


@in_virtual_time
async def test_a_robot_waits_for_its_dock_where_it_is_said_to() -> None:
    site = Site(gateways=2)
    site.server.refuses = [occupied()]
    await site.add(DOCK)
    await asyncio.sleep(5)
    book = site.runners[0].book
    shown = book.describe("a", book.all()["a"])
    assert (shown["wait_at"], book.waits["a"]) == ({"x": 1.0, "y": 2.0, "yaw": 0.0, "frame": "map"}, "goal")
    assert site.server.read["pose"]["pose"]["position"] == {"x": 1.0, "y": 2.0}
    site.server.refuses = [occupied() for _ in range(20)]
    await asyncio.sleep(15)
    assert (book.all()["a"].wait_at, book.waits["a"]) == (Waypoint(x=1.0, y=2.0), "dock")
    mission = await site.ended()
    assert (mission.status, mission.steps[0].attempt, mission.wait_at) == (MissionStatus.SUCCEEDED, 1, None)
    assert [*site.server.goals] == ["mission-a-drive-1-1", "mission-a-0-1"]


@in_virtual_time
async def test_a_robot_that_cannot_drive_to_where_it_waits_waits_where_it_is() -> None:
    site = Site()
    site.server.takes = None
    site.server.refuses = [occupied()]
    await site.add(DOCK)
    await asyncio.sleep(300)
    drive, dock = site.server.goals.values()
    assert (drive.status, dock.status) == (GoalStatus.CANCELED, GoalStatus.EXECUTING)
    site.server.end(dock)
    assert (await site.ended()).status is MissionStatus.SUCCEEDED


@pytest.mark.parametrize(
    ("refuses", "goals"),
    [([], ["mission-a-0-1"]), ([occupied(2.0)], ["mission-a-drive-2-1", "mission-a-0-1"])],
    ids=["the dock is free meanwhile", "another robot waits at that place meanwhile"],
)
@in_virtual_time
async def test_a_stop_ends_the_drive_to_where_a_robot_waits(refuses: list[DockOccupied], goals: list[str]) -> None:
    site = Site()
    site.server.refuses = [occupied()]
    await site.add(DOCK)
    await asyncio.sleep(3)
    site.held = True
    site.server.end(next(iter(site.server.goals.values())), GoalStatus.CANCELED)
    await asyncio.sleep(30)
    book = site.runners[0].book
    assert (book.all()["a"].held_for, len(site.server.goals)) == ("stop", 1)
    site.held = False
    await asyncio.sleep(30)
    assert len(site.server.goals) == 1
    site.server.refuses = [*refuses]
    await book.amend("a", UNLIMITED, lambda mission: progress.resume(mission, now()))
    mission = await site.ended()
    assert mission.status is MissionStatus.SUCCEEDED
    assert [*site.server.goals] == ["mission-a-drive-1-1", *goals]


LIMITS = {"below": 0.25, "charge_to": 0.8}


@in_virtual_time
async def test_a_robot_charges_and_its_mission_goes_on() -> None:
    site = Site(gateways=2)
    site.robots.say(0.2, PowerSupply.DISCHARGING)
    await site.add(FIBONACCI, battery=LIMITS)
    await asyncio.sleep(15)
    site.robots.say(0.3, PowerSupply.CHARGING)
    await asyncio.sleep(100)
    (book, _) = (runner.book for runner in site.runners)
    recharge = book.describe("a", book.all()["a"])["recharge"]
    assert (recharge["stage"], book.waits["a"]) == ("charging", "battery")
    site.robots.say(0.8, PowerSupply.CHARGING)
    mission = await site.ended()
    assert (mission.status, mission.steps[0].attempt) == (MissionStatus.SUCCEEDED, 1)
    assert [*site.server.goals] == ["mission-a-recharge-1-1", "mission-a-recharge-2-1", "mission-a-0-1"]


@in_virtual_time
async def test_a_break_survives_its_gateway_with_each_goal_sent_once() -> None:
    site = Site()
    site.robots.say(0.2, PowerSupply.DISCHARGING)
    await site.add(FIBONACCI, battery=LIMITS)
    for seconds in (0.005, 5.0, 15.0):  # while the goal is on its way, while it runs, and on the dock
        await asyncio.sleep(seconds)
        await site.runners[-1].close()
        site.runners.append(site.open())
    site.robots.say(0.9, PowerSupply.CHARGING)
    assert (await site.ended()).status is MissionStatus.SUCCEEDED
    assert [*site.server.goals] == ["mission-a-recharge-1-1", "mission-a-recharge-2-1", "mission-a-0-1"]


@in_virtual_time
async def test_a_battery_that_is_stale_is_not_low() -> None:
    site = Site()
    site.robots.say(0.1, PowerSupply.DISCHARGING)
    site.robots.battery.stale_since = 1.0
    await site.add(FIBONACCI, battery=LIMITS)
    assert (await site.ended()).recharges == 0


@in_virtual_time
async def test_a_rule_asks_a_mission_that_says_nothing_to_return() -> None:
    site = Site(gateways=2)
    runner = site.runners[0]
    site.robots.say(0.15, PowerSupply.DISCHARGING)
    await site.add({"wait": {"seconds": 500}}, FIBONACCI)
    await site.add(DOCK, mission_id="b")
    await asyncio.sleep(5)
    assert site.server.goals == {}
    for _ in range(3):
        runner.ask_to_charge("/", 0.2)
        runner.ask_to_charge("/robot1", 0.2)
        await asyncio.sleep(1)
    asked = runner.book.all()["a"].asked_battery
    assert asked is not None
    assert (asked.below, asked.charge_to, runner.book.all()["b"].asked_battery) == (0.2, 0.8, None)
    assert [*site.server.goals] == ["mission-a-recharge-1-1"]
    own = runner.book.all()["b"].but(status=MissionStatus.RUNNING, battery=asked)
    site.store.known["b"] = own
    await runner.book.read()
    runner.ask_to_charge("/", 0.1)
    await asyncio.sleep(1)
    assert runner.book.all()["b"].asked_battery is None
