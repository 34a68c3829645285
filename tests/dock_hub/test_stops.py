"""Stops of sites: none is forgotten, none is repeated after a release, and no answer claims what was not confirmed."""

import asyncio
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant, Role
from dock_hub.stop_outcomes import StopOutcome
from dock_hub.stop_requests import WHOLE, StopEntry, StopOptions, outermost
from dock_hub.stops import Stops
from tests.dock_hub.stopped_sites import BERLIN, OSLO, TIMES, Answer, FakeSite, FakeSites, Store
from tests.support.waiting import until

FOREVER = 60.0


class Scene:
    """A hub with sites."""

    def __init__(self, *names: str) -> None:
        self.reach = FakeSites(*(names or (BERLIN, OSLO)))
        self.store = Store()
        self.stops = Stops(self.reach, self.store, TIMES)

    @property
    def berlin(self) -> FakeSite:
        return self.reach.sites[BERLIN]

    async def open(self) -> None:
        self.stops = Stops(self.reach, self.store, TIMES)
        self.stops.open()
        if not self.store.down:
            await until(lambda: self.stops.ready)

    async def stop(self, *names: str, robots: tuple[str, ...] = (WHOLE,), latch: bool = True) -> dict[str, StopOutcome]:
        targets = dict.fromkeys(names or (BERLIN, OSLO), robots)
        return await self.stops.stop(targets, StopOptions(latch), by="ada", user="ada")

    async def release(self, name: str = BERLIN, robot: str = WHOLE) -> str:
        """Release a stop; return the code of the error, or `released`."""
        try:
            await self.stops.release(name, robot, "ada", Grant(Role.SUPERVISOR))
        except GatewayError as error:
            return error.code
        return "released"


@asynccontextmanager
async def running(*names: str) -> AsyncIterator[Scene]:
    scene = Scene(*names)
    await scene.open()
    try:
        yield scene
    finally:
        await scene.stops.close()


async def test_every_site_is_stopped_at_once_with_all_its_robots() -> None:
    async with running() as scene:
        outcomes = await scene.stop()
        assert all(outcome.stopped and outcome.code is None for outcome in outcomes.values())
        report = outcomes[OSLO].report
        assert report.stop.robots == report.stopped == ["/oslo/robot1", "/oslo/robot2"]
        assert report.unconfirmed == ["/oslo/robot1/dock"]
        assert scene.berlin.asked == [("POST", ("/",))]
        await until(lambda: not scene.stops.pending(BERLIN))
        assert await scene.release() == "released"
        assert not scene.berlin.latched
        assert scene.berlin.who == [("ada", Grant(Role.VIEWER)), ("ada", Grant(Role.SUPERVISOR))]


async def test_a_site_that_is_away_is_stopped_when_it_is_back_also_by_another_process_of_the_hub() -> None:
    async with running() as scene:
        scene.berlin.reachable = False
        outcomes = await scene.stop()
        assert outcomes[OSLO].stopped
        assert (outcomes[BERLIN].stopped, outcomes[BERLIN].repeated) == (False, True)
        assert (outcomes[BERLIN].code, outcomes[BERLIN].warning) == ("site_unreachable", None)
        assert (scene.stops.pending(BERLIN) or {})["by"] == "ada"
        await scene.stops.close()
        await scene.open()
        scene.berlin.reachable = True
        await until(lambda: scene.berlin.latched)
        await until(lambda: not scene.stops.pending(BERLIN))
        await until(lambda: BERLIN not in scene.store.known)


async def test_a_release_drops_what_a_site_has_not_confirmed() -> None:
    async with running() as scene:
        scene.berlin.reachable = False
        await scene.stop(BERLIN)
        assert await scene.release() == "site_unreachable"
        scene.berlin.reachable = True
        assert (scene.stops.pending(BERLIN), await scene.store.read()) == (None, {})
        assert scene.berlin.asked == []


async def test_a_part_of_what_is_not_confirmed_is_not_released_alone() -> None:
    async with running() as scene:
        scene.berlin.reachable = False
        await scene.stop(BERLIN)
        assert await scene.release(robot="/robot1") == "stop_latched"
        await scene.release()
        await scene.stop(BERLIN, robots=("/robot1", "/robot2", "/robot2/arm"))
        await scene.release(robot="/robot1")
        assert (scene.stops.pending(BERLIN) or {})["robots"] == ["/berlin/robot2"]


async def test_an_answer_that_was_lost_is_no_confirmation() -> None:
    async with running() as scene:
        scene.berlin.loses_answers = True
        outcome = (await scene.stop())[BERLIN]
        assert (outcome.stopped, outcome.code, outcome.repeated) == (False, "site_timeout", True)
        scene.berlin.loses_answers = False
        await until(lambda: not scene.stops.pending(BERLIN))


@pytest.mark.parametrize(
    "failed", [[{"robot": "/robot1", "code": "ros_unavailable", "detail": "no zero velocity"}], None, {}]
)
async def test_a_report_that_does_not_say_so_is_no_confirmation(failed: Any) -> None:
    async with running() as scene:
        scene.berlin.failed = failed
        outcome = (await scene.stop())[BERLIN]
        assert (outcome.stopped, outcome.repeated) == (False, True)


async def test_what_a_site_refuses_is_said_and_not_repeated() -> None:
    async with running() as scene:
        scene.berlin.refusal = Answer(404, b'{"code": "robot_not_found", "detail": "there is no robot /x"}')
        outcome = (await scene.stop(BERLIN, robots=("/x",)))[BERLIN]
        assert (outcome.stopped, outcome.code, outcome.repeated) == (False, "robot_not_found", False)
        assert scene.stops.pending(BERLIN) is None


async def test_a_stop_that_is_not_to_be_latched_is_not_repeated() -> None:
    async with running() as scene:
        scene.berlin.reachable = False
        assert not (await scene.stop(latch=False))[BERLIN].repeated
        assert scene.stops.pending(BERLIN) is None


async def test_without_its_database_the_hub_stops_and_says_what_a_restart_would_forget() -> None:
    async with running() as scene:
        scene.store.down, scene.berlin.reachable = True, False
        outcomes = await scene.stop()
        assert outcomes[OSLO].stopped
        warning = outcomes[BERLIN].warning
        assert warning is not None
        assert "if the hub restarts" in warning.detail
        assert await scene.release() == "history_unavailable"
        assert scene.stops.pending(BERLIN) is not None
        scene.store.down = False
        await until(lambda: BERLIN in scene.store.known)


async def test_nothing_is_released_before_what_the_last_process_left_is_read() -> None:
    scene = Scene()
    scene.store.down = True
    await scene.open()
    assert await scene.release() == "history_unavailable"
    await scene.stops.close()


async def test_a_stop_before_that_forgets_none_of_the_last_process() -> None:
    scene = Scene()
    scene.berlin.robots = ["/"]
    entry = StopEntry(("/robot2",), "ada", "ada", utc_now())
    await scene.store.write(BERLIN, entry)
    scene.store.hold = asyncio.Event()
    scene.stops.open()
    assert (await scene.stop(BERLIN, robots=("/robot1",)))[BERLIN].stopped
    scene.store.hold.set()
    await until(lambda: ("POST", ("/robot2",)) in scene.berlin.asked)
    await scene.stops.close()


async def test_a_stop_that_meets_a_release_is_sent_again() -> None:
    async with running() as scene:
        await scene.stop(BERLIN)
        gate = scene.berlin.gate = asyncio.Event()
        releasing = asyncio.create_task(scene.release())
        await until(lambda: scene.berlin.held == 1)
        scene.berlin.gate = None  # so the stop overtakes it
        stopping = asyncio.create_task(scene.stop(BERLIN))
        await until(lambda: scene.berlin.stops == 2)
        gate.set()
        assert await releasing == "released"
        await stopping
        await until(lambda: [method for method, _ in scene.berlin.asked] == ["POST", "POST", "DELETE", "POST"])
        assert scene.berlin.latched


async def test_a_release_does_not_undo_a_later_stop() -> None:
    async with running() as scene:
        scene.berlin.delay = 0.01
        first = asyncio.create_task(scene.stop(BERLIN))
        await asyncio.sleep(0)
        releasing = asyncio.create_task(scene.release())
        await asyncio.sleep(0)
        second = asyncio.create_task(scene.stop(BERLIN))
        assert await releasing == "stopped_again"
        await asyncio.gather(first, second)
        assert scene.berlin.latched


def test_outermost() -> None:
    assert outermost(["/a/b", "/a", "/ab", "/c/d"]) == ("/a", "/ab", "/c/d")
    assert outermost(["/a", "/"]) == ("/",)


# ---------------------------------------------------------------------- any order of anything

SITE = st.sampled_from([BERLIN, OSLO])
STEP = st.one_of(
    st.tuples(st.just("stop"), st.sampled_from([(BERLIN,), (OSLO,), (BERLIN, OSLO)]), st.booleans()),
    st.tuples(st.just("release"), SITE, st.booleans()),
    st.tuples(st.just("reachable"), SITE, st.booleans()),
    st.tuples(st.just("loses_answers"), SITE, st.booleans()),
    st.tuples(st.just("delay"), SITE, st.sampled_from([0.0, 0.003, 0.03])),
    st.tuples(st.just("down"), st.none(), st.booleans()),
    st.tuples(st.just("restart"), st.none(), st.none()),
)


@dataclass(eq=False)
class Request:
    """A stop or a release of one site that a test has made.

    Attributes:
        began: When, as the number of the step.
        stops: How often the site had been stopped then.
        process: The process of the hub that it was made to.
    """

    site: str
    began: int
    stops: int
    process: int
    outcome: StopOutcome | str | None = None
    latched_then: bool | None = None


class Run:
    """A hub and sites, to which everything happens in any order."""

    def __init__(self) -> None:
        self.scene = Scene()
        self.stops: list[Request] = []
        self.releases: list[Request] = []
        self.tasks: list[asyncio.Task[None]] = []
        self.process = 0

    async def run(self, steps: Iterable[tuple[str, Any, Any]]) -> None:
        await self.scene.open()
        for number, (what, where, how) in enumerate(steps):
            if what in ("stop", "release"):
                act = self._stop(where, number) if what == "stop" else self._release(where, number)
                self.tasks.append(task := asyncio.create_task(act))
                await (asyncio.wait({task}) if how else asyncio.sleep(0))
            elif what == "down":
                self.scene.store.down = how
            elif what == "restart":
                await self._restart()
            else:
                setattr(self.scene.reach.sites[where], what, how)
        self.scene.store.down = False
        for site in self.scene.reach.sites.values():
            site.reachable, site.loses_answers, site.delay = True, False, 0.0
        if self.tasks:
            await asyncio.wait(self.tasks)
        await until(lambda: not any(map(self.scene.stops.pending, self.scene.reach.sites)))
        await asyncio.sleep(3 * TIMES.repeat_after)
        await self.scene.stops.close()

    async def _restart(self) -> None:
        for task in self.tasks:
            task.cancel()
        await self.scene.stops.close()
        self.process += 1
        await self.scene.open()

    async def _stop(self, names: tuple[str, ...], number: int) -> None:
        sites = self.scene.reach.sites
        requests = [Request(name, number, sites[name].stops, self.process) for name in names]
        self.stops += requests
        outcomes = await self.scene.stop(*names)
        for request in requests:
            request.outcome = outcome = outcomes[request.site]
            assert not outcome.stopped or sites[request.site].stops > request.stops, "it was never stopped"

    async def _release(self, name: str, number: int) -> None:
        self.releases.append(request := Request(name, number, self.scene.reach.sites[name].stops, self.process))
        request.outcome = outcome = await self.scene.release(name)
        if outcome == "history_unavailable":
            self.releases.remove(request)  # nothing has changed

    def check(self) -> None:
        for name, site in self.scene.reach.sites.items():
            last_stop = max((each.began for each in self.stops if each.site == name), default=-1)
            last_release = max((each.began for each in self.releases if each.site == name), default=-1)
            for stop in self.stops:
                if stop.site == name and stop.began > last_release and self._is_kept(stop):
                    assert site.latched, "a stop was forgotten"
                    assert site.stops > stop.stops, "a stop was not carried out"
            for release in self.releases:
                if release.site == name and release.outcome == "released" and release.began > last_stop:
                    assert not site.latched, "a stop was repeated after a release"

    def _is_kept(self, stop: Request) -> bool:
        """Return whether a stop must be carried out: it was answered as such, or the hub has not been restarted."""
        if stop.process == self.process:
            return True
        outcome = stop.outcome
        return isinstance(outcome, StopOutcome) and (outcome.stopped or (outcome.repeated and not outcome.warning))


@settings(max_examples=40, deadline=None)
@given(st.lists(STEP, max_size=12))
def test_whatever_happens(steps: list[tuple[str, Any, Any]]) -> None:
    run = Run()
    asyncio.run(asyncio.wait_for(run.run(steps), FOREVER))
    run.check()
