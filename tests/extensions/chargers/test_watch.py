"""What is seen of the robots, and what that means for the docks that they have. In virtual time, without ROS."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.goal import GoalError, GoalStatus
from dock_gateway.extensions.chargers import policy
from dock_gateway.extensions.chargers.dock import DockBody, DockPose, DockRecord, Hold
from dock_gateway.extensions.chargers.extension import can_drive
from dock_gateway.extensions.chargers.watch import AWAY_FOR
from tests.extensions.chargers.examples import NOON, Site, docking, now
from tests.support.virtual import in_virtual_time

ASK = policy.Ask("/robot1", ["a"])
PLACED = DockBody(waiting_places=[DockPose(x=1.0, y=2.0)]).entry()
STANDING = DockRecord(hold=Hold(robot="/robot1", standing=True, since_at=NOON))


async def reserved(status: GoalStatus = GoalStatus.EXECUTING, code: str | None = None) -> Site:
    """A site whose robot has the dock `a` for a goal."""
    site = Site()
    goal = site.goals["goal"] = docking(status=status)
    goal.error = None if code is None else GoalError(code, "as the test says")
    site.records.known["a"] = policy.reserve(policy.FREE, "/robot1", "goal", now())
    return site


@pytest.mark.parametrize(
    ("status", "code", "state", "failures"),
    [
        (GoalStatus.PENDING, None, "reserved", 0),
        (GoalStatus.EXECUTING, None, "reserved", 0),
        (GoalStatus.CANCELING, None, "reserved", 0),
        (GoalStatus.SUCCEEDED, None, "standing", 0),
        (GoalStatus.ABORTED, "failed_to_charge", "standing", 0),
        (GoalStatus.ABORTED, "failed_to_stage", "free", 1),
        (GoalStatus.ABORTED, "stopped", "free", 0),
        (GoalStatus.CANCELED, None, "free", 0),
        (GoalStatus.REJECTED, "stopped", "free", 0),
    ],
)
@in_virtual_time
async def test_what_becomes_of_a_reservation(status: GoalStatus, code: str | None, state: str, failures: int) -> None:
    site = await reserved(status, code)
    record = await site.look(2)
    found = "free" if record.hold is None else "standing" if record.hold.standing else "reserved"
    assert (found, record.failures) == (state, failures)


@in_virtual_time
async def test_a_goal_that_was_never_stored() -> None:
    site = await reserved()
    site.goals.clear()
    assert (await site.look(50)).hold is not None
    assert (await site.look(11)).hold is None


@in_virtual_time
async def test_a_lost_goal_keeps_the_dock_until_something_is_learned_of_the_robot() -> None:
    site = await reserved(GoalStatus.LOST)
    site.robot.lost = [site.goals["goal"]]
    assert (await site.look(100)).hold is not None
    assert [*site.watch.trouble.silent] == ["a"]
    site.robot.lost = []
    site.robot.battery.stale_since = 1.0
    assert (await site.look(100)).hold is not None, "nothing is heard of it"
    site.robot.battery.stale_since = None
    assert (await site.look(2)).hold is None
    assert site.watch.trouble.silent == {}


@in_virtual_time
async def test_a_robot_has_left_when_it_was_seen_off_its_dock_for_a_while() -> None:
    site = Site()
    site.records.known["a"] = STANDING
    for docked in (True, None):
        site.sees(docked=docked)
        assert (await site.look(60)).hold is not None
    site.sees(docked=False)
    assert (await site.look(AWAY_FOR - 2)).hold is not None
    site.sees(docked=True)
    await site.look(1)
    site.sees(docked=False)
    assert (await site.look(AWAY_FOR - 2)).hold is not None, "the time begins again"
    assert (await site.look(4)).hold is None


@in_virtual_time
async def test_a_robot_that_dies_on_its_dock_keeps_it() -> None:
    site = Site()
    site.records.known["a"] = STANDING
    site.sees(docked=False)
    site.robot.battery.stale_since = 1.0
    assert (await site.look(1000)).hold is not None
    site.there = False
    assert (await site.look(1000)).hold is not None
    assert [*site.watch.trouble.silent] == ["a"]


@in_virtual_time
async def test_a_robot_stands_at_one_dock() -> None:
    site = await reserved(GoalStatus.ABORTED, "failed_to_stage")
    site.records.known["b"] = STANDING
    site.sees(docked=True)
    assert (await site.look(2)).hold is None, "it is docked, but at the other one"
    site.records.known["a"] = policy.reserve(policy.FREE, "/robot1", "goal", now())
    site.goals["goal"].status = GoalStatus.SUCCEEDED
    hold = (await site.look(2)).hold
    assert hold is not None
    assert hold.standing
    assert site.records.known["b"].hold is None


@in_virtual_time
async def test_a_robot_that_stands_there_at_the_start_is_noted_unless_a_person_has_said_otherwise() -> None:
    site = Site()
    site.sees(docked=True)
    site.robot.last_goal = docking(status=GoalStatus.SUCCEEDED)
    await asyncio.sleep(10)
    site.records.known["a"] = DockRecord(cleared_at=now())
    assert (await site.look(5)).hold is None
    site.robot.last_goal = docking(status=GoalStatus.SUCCEEDED)
    await asyncio.sleep(10)
    site.robot.last_goal.updated_at = now()
    hold = (await site.look(5)).hold
    assert hold is not None
    assert (hold.robot, hold.standing) == ("/robot1", True)


@in_virtual_time
async def test_a_goal_that_did_not_ask_is_noted_and_is_trouble_if_another_robot_has_the_dock() -> None:
    site = Site()
    site.robot.goals = [docking()]
    site.goals["goal"] = site.robot.goals[0]
    hold = (await site.look(2)).hold
    assert hold is not None
    assert (hold.robot, hold.standing, hold.goal_ids) == ("/robot1", False, ("goal",))
    site.robot.goals.append(docking(goal_id="second"))
    site.goals["second"] = site.robot.goals[1]
    hold = (await site.look(2)).hold
    assert hold is not None
    assert hold.goal_ids == ("goal", "second")
    others = DockRecord(hold=Hold(robot="/robot2", standing=True, since_at=NOON))
    site.records.known["a"] = others
    assert await site.look(3) == others
    assert {name: robot for name, (robot, _) in site.watch.trouble.contested.items()} == {"a": "/robot1"}
    site.robot.goals = []
    await site.look(1)
    assert site.watch.trouble.contested == {}


@in_virtual_time
async def test_a_robot_that_arrives_at_its_dock_is_not_at_that_of_the_goal_before() -> None:
    site = Site()
    site.robot.last_goal = docking(status=GoalStatus.SUCCEEDED)
    site.robot.goals = [docking("b", "next")]
    site.records.known["a"] = DockRecord(hold=Hold(robot="/robot2", standing=True, since_at=NOON))
    site.sees(docked=True)
    await site.look(2)
    assert site.watch.trouble.contested == {}


@in_virtual_time
async def test_it_looks_by_itself_and_at_once_when_a_goal_has_ended() -> None:
    site = await reserved()
    looks: list[None] = []
    site.watch.on_look.append(lambda: looks.append(None))
    site.watch.start()
    await asyncio.sleep(0.5)
    site.goals["goal"].status = GoalStatus.CANCELED
    site.watch.wake()
    await asyncio.sleep(0.1)
    assert site.records.known["a"].hold is None
    site.records.away = True
    await asyncio.sleep(10)
    site.records.away = False
    before = len(looks)
    await asyncio.sleep(10)
    assert len(looks) > before
    await site.watch.close()


@in_virtual_time
async def test_a_robot_whose_mission_has_ended_is_not_driving_to_where_it_waits() -> None:
    site = Site()
    site.docks.waits.put("/robot1", driving := policy.waits_for(ASK, {"a": PLACED}, {}, now()))
    await site.look(40)
    assert policy.is_waiting(driving, now())  # it is driving: it need not ask
    assert site.docks.waits.get("/robot1") == driving
    site.at_work = False
    await site.look(9)
    assert site.docks.waits.get("/robot1") == driving  # a gateway that has just started does not know the mission yet
    await site.look(2)
    left = site.docks.waits.all()["/robot1"]
    assert (policy.is_waiting(left, now()), left.wait_at) == (False, None)
    again = policy.waits_for(ASK, {"a": PLACED}, {"/robot1": left}, now())
    assert again.arrives_by is not None, "it has to drive there again"


@pytest.mark.parametrize(
    ("fields", "drives"),
    [
        ({}, True),
        ({"at_work": False}, False),  # a rule has sent it
        ({"on_dock": True}, False),
        ({"goals": ["goal"]}, True),  # that which asks
        ({"goals": ["goal", "other"]}, False),
        ({"there": False}, False),
    ],
)
@in_virtual_time
async def test_which_robots_drive_to_where_they_wait(fields: dict[str, Any], drives: bool) -> None:
    goals = [docking(goal_id=each) for each in fields.get("goals", ())]
    state = SimpleNamespace(name="/robot1", on_dock=fields.get("on_dock", False), goals=goals)
    owner = SimpleNamespace(namespace="/robot1") if fields.get("there", True) else None
    robots = SimpleNamespace(owner=lambda _: owner, is_at_work=lambda _: fields.get("at_work", True))
    fleet = SimpleNamespace(state=lambda _: state)
    assert can_drive(docking(), cast("Any", robots), cast("Any", fleet)) is drives
