"""How a stop is carried out: each robot by itself, many who ask at once together, whatever ROS and the disk do."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest

from dock_gateway.core.errors import Conflict, NotFound, Unavailable
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Grant, Role
from dock_gateway.stop.stop_report import StopReport, narrow_stops
from dock_gateway.stop.stopper import TIMING, StopTiming
from tests.support.shapes import check_answer, check_event
from tests.support.stopping import FakeFleet, fake_fleet
from tests.support.virtual import in_virtual_time
from tests.support.waiting import until

NAMES = ("/", "/robot1", "/robot2")


@pytest.fixture
async def fleet(tmp_path: Path, request: pytest.FixtureRequest) -> AsyncIterator[FakeFleet]:
    # A busy machine looks late at what was done before a stop is repeated.
    timing = {"repeat_after": 0.7} | getattr(request, "param", {})
    async with fake_fleet(tmp_path / "stops.json", *NAMES, timing=StopTiming(**timing)) as fleet:
        yield fleet


def timing(**changed: float) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("fleet", [changed], indirect=True, ids=[""])


def now() -> float:
    """The virtual time, which is 0 when a test starts."""
    return asyncio.get_running_loop().time()


def failed(report: StopReport) -> list[tuple[str | None, str | None]]:
    return [(failure["robot"], failure["code"]) for failure in report.failed]


@timing(store_within=10.0)  # the disk of a busy machine
async def test_all_that_a_stop_does(fleet: FakeFleet) -> None:
    fleet.goals["/robot1"].running = ["a"]
    report = await fleet.stopper.stop(by="Ada")
    assert (report.canceling, report.failed, report.unconfirmed, report.problems) == (["a"], [], [], [])
    assert (report.stopped, report.not_stopped) == (list(NAMES), [])
    stopped_at = report.stop["stopped_at"]
    assert report.stop == {
        "latched": True,
        "for_all": True,
        "stopped_at": stopped_at,
        "by": "Ada",
        "robots": list(NAMES),
        "stops": [{"robot": name, "stopped_at": stopped_at, "by": "Ada"} for name in NAMES],
        "persisted": True,
    }
    assert list(fleet.file.read()) == list(NAMES)
    assert fleet.said() == [[True]] * 3
    await until(lambda: fleet.zeros() == [2, 2, 2])


async def test_several_robots_are_stopped_by_one_request(fleet: FakeFleet) -> None:
    fleet.goals["/robot1"].running = ["a"]
    fleet.goals["/robot2"].running = ["b"]
    await fleet.stopper.stop("/robot2", by="Bob")
    report = await fleet.stopper.stop("/robot2", "/robot9", "/robot1", by="Ada")
    assert (sorted(report.canceling), report.unconfirmed) == (["a", "b"], [])
    assert failed(report) == [("/robot9", "robot_not_found")]
    assert (report.stop["latched"], report.stop["by"], report.stop["robots"]) == (True, "Bob", ["/robot1", "/robot2"])
    assert fleet.zeros()[0] == 0
    assert not fleet.interlock.holds("/")
    await fleet.stopper.release("/robot2")
    together = (await fleet.stopper.stop("/robot1", "/robot2", latch=False)).stop
    assert (together["latched"], together["for_all"], together["robots"]) == (True, False, ["/robot1"])


async def test_all_robots_that_are_stopped_one_by_one_are_stopped(fleet: FakeFleet) -> None:
    """A light that is made of `latched` must not be green; when and by whom must not be lost."""
    for name, by in (("/robot2", "Bob"), ("/robot1", "Ada")):
        await fleet.stopper.stop(name, by=by)
        await asyncio.sleep(1.0)
    state = fleet.stopper.stops()
    assert (state["latched"], state["for_all"], state["by"]) == (True, False, "Bob")
    assert [(stop["robot"], stop["by"]) for stop in state["stops"]] == [("/robot1", "Ada"), ("/robot2", "Bob")]
    assert state["stopped_at"] == state["stops"][1]["stopped_at"]
    assert state["robots"] == ["/robot1", "/robot2"]
    assert not fleet.stopper.state("/")["latched"]  # the robot of that name is not stopped
    one = fleet.stopper.stops("/robot1")
    assert (one["latched"], one["for_all"], one["by"], one["robots"]) == (True, True, "Ada", ["/robot1"])
    mine = narrow_stops(state, Grant(Role.VIEWER, robots=("/robot1",)))
    assert (mine["latched"], mine["by"], mine["robots"]) == (True, "Ada", ["/robot1"])
    await fleet.stopper.release("/robot2")
    await fleet.stopper.release("/robot1")
    assert fleet.stopper.stops() == {
        "latched": False,
        "for_all": False,
        "stopped_at": None,
        "by": None,
        "robots": [],
        "stops": [],
        "persisted": True,
    }


async def test_several_robots_of_which_one_cannot_be_reached(fleet: FakeFleet) -> None:
    fleet.robots["/robot1"].wheels.failures = 1
    assert failed(await fleet.stopper.stop("/robot1", "/robot2")) == [("/robot1", "publish_failed")]
    await until(lambda: fleet.zeros()[1:] == [1, 2])
    for name in ("/robot1", "/robot2"):
        fleet.robots[name].wheels.failures = 1
    with pytest.raises(Unavailable) as refused:
        await fleet.stopper.stop("/robot1", "/robot2")
    assert [failure["robot"] for failure in refused.value.problem()["failed"]] == ["/robot1", "/robot2"]


async def test_a_robot_that_cannot_be_reached_keeps_none_of_the_others_from_being_stopped(fleet: FakeFleet) -> None:
    fleet.robots["/"].wheels.failures = 1
    fleet.robots["/"].topic.failures = 1000
    report = await fleet.stopper.stop()
    fleet.robots["/"].topic.failures = 0
    assert failed(report) == [("/", "publish_failed"), ("/", "latch_not_published")]
    assert (report.stopped, report.not_stopped) == (["/robot1", "/robot2"], ["/"])
    assert report.stop["robots"] == list(NAMES)
    assert fleet.zeros() == [0, 1, 1]
    assert fleet.said()[1:] == [[True], [True]]
    await until(lambda: fleet.zeros() == [1, 2, 2])  # zero is published to all of them again
    await until(lambda: fleet.said()[0] == [True])  # and it is told until it could be


async def test_a_stop_that_reaches_no_robot_says_so_and_does_all_else(fleet: FakeFleet) -> None:
    for robot in fleet.robots.values():
        robot.wheels.failures = 1
    fleet.goals["/"].running = ["a"]
    with pytest.raises(Unavailable) as refused:
        await fleet.stopper.stop()
    problem = refused.value.problem()
    assert (problem["code"], problem["canceling"], problem["stop"]["latched"]) == ("ros_unavailable", ["a"], True)
    assert [failure["robot"] for failure in problem["failed"]] == list(NAMES)
    assert "emergency stop" in problem["detail"]
    check_answer("POST", "/stop", 503, "application/problem+json", encode(problem))
    check_event("/ws", encode({"op": "error", "id": "1", "error": problem}))


async def test_stops_that_come_together_are_one_with_the_first_name_and_the_latch_of_any(fleet: FakeFleet) -> None:
    names: list[dict[str, Any]] = [{"latch": False}, {"by": "Ada"}, *({"by": f"Bob {number}"} for number in range(200))]
    reports = await asyncio.gather(*(fleet.stopper.stop("/", **how) for how in names))
    assert {report.stop["by"] for report in reports} == {"Ada"}
    assert all(report.stop["latched"] and not report.failed for report in reports)
    assert fleet.said() == [[True]] * 3
    assert max(goals.cancels for goals in fleet.goals.values()) == 1


async def test_robots_that_take_long_to_tell_are_not_told_for_each_who_joins(
    fleet: FakeFleet, monkeypatch: pytest.MonkeyPatch
) -> None:
    zero = fleet.robots["/robot2"].wheels.publish_zero
    monkeypatch.setattr(fleet.robots["/robot2"].wheels, "publish_zero", lambda: (time.sleep(0.2), zero()))
    await asyncio.gather(*(fleet.stopper.stop() for _ in range(100)))
    assert fleet.zeros() == [1, 1, 1]
    await until(lambda: fleet.zeros() == [2, 2, 2])  # for all who joined


@timing(rest=0)  # however long a busy machine took for the first
async def test_a_stop_that_joins_one_stops_what_has_begun_since(fleet: FakeFleet) -> None:
    await fleet.stopper.stop(latch=False)
    told = fleet.zeros()
    fleet.goals["/robot1"].running = ["late"]
    report = await fleet.stopper.stop(latch=False)
    assert report.canceling == ["late"]
    assert all(now > before for now, before in zip(fleet.zeros(), told, strict=True))


@timing(rest=1e6)
async def test_a_stop_that_joins_one_stops_what_has_appeared_since(fleet: FakeFleet) -> None:
    stopped: list[str] = []
    fleet.stopper.on_stop.append(stopped.append)
    robot, action = fleet.robots.pop("/robot2"), fleet.actions.pop("/robot2")
    first = asyncio.create_task(fleet.stopper.stop(latch=False))
    await until(lambda: fleet.zeros() == [1, 1])
    fleet.robots["/robot2"], fleet.actions["/robot2"] = robot, action
    fleet.goals["/robot2"].running = ["late"]
    report = await fleet.stopper.stop(latch=False)
    assert report.canceling == ["late"]
    assert robot.wheels.zeros == 1
    assert stopped == ["/", "/robot1", "/", "/robot1", "/robot2"]
    first.cancel()


@timing(repeat_after=0.02, rest=0)
async def test_who_goes_on_asking_goes_on_stopping(fleet: FakeFleet) -> None:
    told: list[str] = []
    fleet.stopper.on_stop.append(told.append)
    await fleet.stopper.stop(latch=False)
    for zeros in range(2, 5):
        fleet.goals["/"].running = ["late"]
        report = await fleet.stopper.stop(latch=False)
        assert report.failed == []
        await until(lambda: not fleet.goals["/"].running)
        await until(lambda least=zeros: min(fleet.zeros()) >= least)
        assert len(told) == len(NAMES) * zeros, "a robot that is still being stopped is not left alone"


async def test_a_stop_that_joins_one_and_follows_a_release_holds_and_is_told(fleet: FakeFleet) -> None:
    await fleet.stopper.stop()
    await fleet.stopper.release()
    report = await fleet.stopper.stop(by="Bob")
    assert (report.stop["latched"], report.stop["by"]) == (True, "Bob")
    assert fleet.said() == [[True, False, True]] * 3


async def test_a_stop_below_does_not_join_one_of_another_robot(fleet: FakeFleet) -> None:
    await asyncio.gather(fleet.stopper.stop("/robot1"), fleet.stopper.stop("/robot2", latch=False))
    assert fleet.zeros() == [0, 1, 1]
    assert [fleet.interlock.holds(name) for name in NAMES] == [False, True, False]


@in_virtual_time
async def test_an_action_server_that_does_not_answer_is_named_and_zero_comes_again_once_it_has(tmp_path: Path) -> None:
    async with fake_fleet(tmp_path / "stops.json", *NAMES) as fleet:
        fleet.goals["/robot1"].answers.clear()
        report = await fleet.stopper.stop()
        assert now() == pytest.approx(TIMING.confirm_within)
        assert report.unconfirmed == ["/robot1/dock"]
        assert fleet.said() == [[True]] * 3
        await until(lambda: fleet.zeros() == [2, 2, 2])
        fleet.goals["/robot1"].answers.set()
        await until(lambda: fleet.zeros() == [3, 3, 3])


async def test_who_asked_and_left_has_stopped_the_robot_all_the_same(fleet: FakeFleet) -> None:
    stopped: list[str] = []
    fleet.stopper.on_stop.append(stopped.append)
    asking = asyncio.create_task(fleet.stopper.stop("/robot1", "/robot2"))
    await asyncio.sleep(0)
    asking.cancel()
    await until(lambda: fleet.said()[1:] == [[True], [True]])
    assert stopped == ["/robot1", "/robot2"]


async def test_each_action_server_that_does_not_answer_is_named(fleet: FakeFleet) -> None:
    for name in ("/robot1", "/robot2"):
        fleet.goals[name].answers.clear()
    report = await fleet.stopper.stop("/robot2", "/robot1")
    assert report.unconfirmed == ["/robot1/dock", "/robot2/dock"]


async def test_who_waits_for_action_servers_hears_of_them(fleet: FakeFleet) -> None:
    goals = fleet.goals["/robot1"]
    goals.running = ["a"]
    goals.answers.clear()
    waiting = asyncio.create_task(fleet.stopper.stop(wait=10.0))
    await until(lambda: goals.cancels == 1)
    assert (await fleet.stopper.stop()).unconfirmed == ["/robot1/dock"]
    goals.answers.set()
    assert (await waiting).canceling == ["a"]


@in_virtual_time
async def test_a_disk_that_hangs_does_not_hold_up_a_stop_which_says_so(tmp_path: Path) -> None:
    disk = asyncio.Event()

    async def write(_: object, work: Callable[..., None], *args: object) -> None:
        await disk.wait()
        work(*args)

    async with fake_fleet(tmp_path / "stops.json", *NAMES) as fleet:
        fleet.goals["/robot1"].answers.clear()  # both take their time, which does not add up
        with patch.object(asyncio.get_running_loop(), "run_in_executor", write):
            report = await fleet.stopper.stop()
        assert now() == pytest.approx(TIMING.store_within)
        assert report.unconfirmed == ["/robot1/dock"]
        (problem,) = report.problems
        assert problem.code == "stop_not_persisted"
        assert "not on the disk yet" in problem.detail
        assert (report.stop["latched"], report.stop["persisted"]) == (True, False)
        assert min(fleet.zeros()) == 1
        disk.set()
        await until(lambda: fleet.stopper.state()["persisted"])
        assert list(fleet.file.read()) == list(NAMES)


def test_a_stop_is_answered_within_100_ms() -> None:
    assert TIMING.confirm_within < TIMING.store_within < 0.1


@in_virtual_time
async def test_a_stop_is_stored_as_soon_as_the_disk_takes_it(tmp_path: Path) -> None:
    async with fake_fleet(tmp_path / "stops.json", *NAMES) as fleet:
        fleet.file.path.mkdir()  # is no place for a file
        report = await fleet.stopper.stop(by="Ada")
        (problem,) = report.problems
        assert str(fleet.file.path) in problem.detail
        assert fleet.stopper.state()["persisted"] is False
        fleet.file.path.rmdir()
        await until(lambda: fleet.stopper.state()["persisted"])
        assert fleet.file.read()["/"].by == "Ada"
        assert (await fleet.stopper.stop()).problems == []


async def test_why_an_action_server_did_not_cancel_is_reported_and_what_the_others_cancel(fleet: FakeFleet) -> None:
    fleet.goals["/"].running = ["a"]
    fleet.goals["/robot1"].error = Conflict("it refuses b", code="cancel_rejected", canceling=["c"])
    fleet.goals["/robot2"].error = RuntimeError("a bug")
    report = await fleet.stopper.stop()
    assert report.canceling == ["a", "c"]
    assert report.failed == [
        {"action_name": "/robot1/dock", "robot": None, "code": "cancel_rejected", "detail": "it refuses b"},
        {
            "action_name": "/robot2/dock",
            "robot": None,
            "code": "internal_error",
            "detail": "the gateway's log has the details",
        },
    ]


async def test_why_a_robot_could_not_be_reached_is_reported(fleet: FakeFleet) -> None:
    fleet.robots["/robot1"].wheels.failures = 1
    (failure,) = (await fleet.stopper.stop()).failed
    assert failure == {
        "action_name": None,
        "robot": "/robot1",
        "code": "publish_failed",
        "detail": "zero velocity could not be published to /robot1: RuntimeError('ROS does not take it')",
    }


async def test_goals_that_have_not_been_sent_yet_are_stopped_by_each_request(fleet: FakeFleet) -> None:
    fleet.goals["/robot1"].answers.clear()
    await fleet.stopper.stop(latch=False)
    assert [goals.stops for goals in fleet.goals.values()] == [1, 1, 1]
    await fleet.stopper.stop(latch=False)
    assert [goals.stops for goals in fleet.goals.values()] == [2, 2, 2]


@timing(rest=0)
async def test_a_stop_is_repeated_once_more_for_those_who_joined(fleet: FakeFleet) -> None:
    await fleet.stopper.stop(latch=False)
    await fleet.stopper.stop(latch=False)
    assert fleet.zeros() == [2, 2, 2]
    await until(lambda: fleet.zeros() == [4, 4, 4])


async def test_one_robot_is_asked_about_and_released_by_itself(fleet: FakeFleet) -> None:
    await fleet.stopper.stop("/robot1")
    assert [fleet.stopper.state(name)["latched"] for name in NAMES] == [False, True, False]
    await fleet.stopper.stop("/robot2")
    assert (await fleet.stopper.release("/robot1"))["latched"] is False
    assert [fleet.stopper.state(name)["latched"] for name in NAMES] == [False, False, True]
    with pytest.raises(NotFound):
        await fleet.stopper.release("/robot9")


@in_virtual_time
async def test_if_no_robot_is_known_the_name_may_be_misspelt_and_all_are_stopped(tmp_path: Path) -> None:
    async with fake_fleet(tmp_path / "stops.json", *NAMES) as fleet:
        report = await fleet.stopper.stop("/robot9", "/robot8")
        assert failed(report) == [("/robot9", "robot_not_found"), ("/robot8", "robot_not_found")]
        assert [problem.code for problem in report.problems] == ["robot_not_found"]
        assert (report.stopped, report.not_stopped) == (list(NAMES), [])
        assert fleet.interlock.holds("/")


async def test_who_stops_is_known_when_goals_are_canceled(fleet: FakeFleet, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their error names them."""
    seen: list[str | None] = []
    by = partial(fleet.interlock.requested_by, "/robot1/dock")
    monkeypatch.setattr(fleet.goals["/robot1"], "stop", lambda: seen.append(by()))
    await fleet.stopper.stop(by="Ada")
    assert seen == ["Ada"]


async def test_a_part_that_fails_keeps_nothing_else_from_being_stopped(
    fleet: FakeFleet, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr(fleet.goals["/"], "stop", fail)
    fleet.stopper.on_stop.append(fail)
    fleet.goals["/robot1"].running = ["a"]
    for _ in range(2):
        async with asyncio.timeout(30):
            report = await fleet.stopper.stop()
        assert (report.stopped, report.stop["latched"]) == (list(NAMES), True)
    assert fleet.goals["/robot1"].cancels >= 1


async def test_the_robots_that_a_stop_is_not_for_are_named(fleet: FakeFleet) -> None:
    report = await fleet.stopper.stop("/robot1")
    assert (report.stopped, report.not_stopped) == (["/robot1"], ["/", "/robot2"])


async def test_a_stop_whose_latch_cannot_be_published_says_so(fleet: FakeFleet) -> None:
    fleet.robots["/robot1"].topic.failures = 3
    report = await fleet.stopper.stop("/robot1")
    assert failed(report) == [("/robot1", "latch_not_published")]
    assert report.stopped == ["/robot1"]
    await until(lambda: fleet.said()[1] == [True])
    assert failed(await fleet.stopper.stop("/robot1")) == []


async def test_a_robot_that_leaves_meanwhile_is_answered_for(fleet: FakeFleet, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that has gone from the graph leaves as soon as no stop holds for it."""
    leave = partial(asyncio.get_running_loop().call_soon, fleet.interlock.leave)
    leave("/robot1")
    report = await fleet.stopper.stop("/robot1", latch=False)
    assert (report.stop["latched"], report.stop["robots"]) == (False, [])

    await fleet.stopper.stop("/robot2")
    monkeypatch.setattr(fleet.file, "write", lambda _: time.sleep(0.05))  # the release waits for that
    leave("/robot2")
    state = await fleet.stopper.release("/robot2")
    assert (state["latched"], state["robots"]) == (False, [])


async def test_a_stop_that_is_not_to_be_latched_is_not_told_and_does_not_wait_for_the_disk(fleet: FakeFleet) -> None:
    fleet.file.path.mkdir()  # is no place for a file
    report = await fleet.stopper.stop(latch=False)
    assert (report.stop["latched"], report.problems) == (False, [])
    assert fleet.said() == [[]] * 3
    assert (await fleet.stopper.stop()).problems != []
    assert (await fleet.stopper.stop(latch=False)).problems == []


async def test_who_waits_for_an_action_server_does_not_wait_longer(fleet: FakeFleet) -> None:
    fleet.goals["/robot1"].answers.clear()
    async with asyncio.timeout(10):
        report = await fleet.stopper.stop(wait=0.3)
    assert report.unconfirmed == ["/robot1/dock"]
