"""A robot whose commands end while it moves for a docking goal is stopped, and no other."""

import asyncio
import time
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.fleet.findings import FindingKind
from dock_gateway.fleet.wheels_watch import WheelsWatch
from dock_gateway.robots.wheels import Wheels
from tests.support.virtual import VirtualLoop, in_virtual_time

TIMEOUT = 0.15
SERVER, TELEOP = b"server", b"teleop"
NAMES = {SERVER: "/docking_server", TELEOP: "/teleop"}


class Port:
    subscribers = 1

    def __init__(self) -> None:
        self.zeros = 0
        self.fails = False

    def publish_zero(self) -> None:
        if self.fails:
            raise RuntimeError("is changing its type")
        self.zeros += 1


class Site:
    """One robot with a docking action, and one action that is none."""

    def __init__(self, timeout: float = TIMEOUT) -> None:
        self.port = Port()
        self.wheels = Wheels(self.port, period=60.0, clock=lambda: time.monotonic())  # noqa: PLW0108 - virtual in some tests
        robot = SimpleNamespace(namespace="/", wheels=self.wheels)
        self.actions: Any = SimpleNamespace(
            on_sent=[], on_change=[], on_end=[], on_lost=[], before_lost=[], verb_of={"/dock": "dock"}.get
        )

        class Robots(dict):  # type: ignore[type-arg]
            def owner(self, _name: str) -> Any:
                return robot

            def get(self, name: str) -> Any:
                return self[name]

        async def name(_robot: str, publisher: bytes) -> str | None:
            return NAMES.get(publisher)

        self.watch = WheelsWatch(self.actions, Robots({"/": robot}), name, timeout)  # type: ignore[arg-type]
        self.watch.on_watch("commands", self._subscribe)

    def _subscribe(self) -> None:
        if self.watch.watched("commands") and self.wheels.last is None:
            self.wheels.listen()

    def goal(self, action: str = "/dock") -> Goal:
        goal = Goal("1", action, "type", utc_now(), "gateway")
        goal.status = GoalStatus.EXECUTING
        for heard in self.actions.on_sent:
            heard(goal)
        return goal

    def end(self, goal: Goal) -> None:
        for heard in self.actions.on_end:
            heard(goal)

    async def command(self, seconds: float, publisher: bytes = SERVER, *, motion: bool = True) -> None:
        for _ in range(round(seconds / 0.02)):
            self.wheels.hear(motion, publisher, time.monotonic())
            await asyncio.sleep(0.02)


@in_virtual_time
async def test_it_is_stopped_once_the_commands_end() -> None:
    site = Site()
    goal = site.goal()
    await site.command(0.4)
    assert site.port.zeros == 0
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 1
    (finding,) = site.watch.findings
    assert (finding.kind, finding.robot) == (FindingKind.COMMANDS_LOST, "/")
    assert "/docking_server moved / and then sent no command for 0.15 s" in finding.detail
    site.end(goal)
    assert site.watch.findings == []


@in_virtual_time
async def test_a_false_alarm_ends_when_the_commands_go_on() -> None:
    site = Site()
    site.goal()
    await site.command(0.1)
    await asyncio.sleep(3 * TIMEOUT)
    assert site.watch.findings
    await site.command(0.1)
    assert site.watch.findings == []


@in_virtual_time
async def test_a_robot_that_was_told_to_stand_needs_no_commands() -> None:
    site = Site()
    site.goal()
    await site.command(0.1)
    await site.command(0.02, motion=False)
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 0


@in_virtual_time
async def test_another_one_who_drives_is_left_alone() -> None:
    site = Site()
    site.goal()
    await site.command(0.1)
    await site.command(0.5, TELEOP)
    assert site.port.zeros == 0


@in_virtual_time
async def test_a_robot_that_was_never_heard_is_stopped_without_an_alert() -> None:
    site = Site()
    site.goal()
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 1
    assert site.watch.findings == []


@in_virtual_time
async def test_a_server_that_dies_as_its_goal_ends() -> None:
    site = Site()
    goal = site.goal()
    await site.command(0.1)
    site.end(goal)
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 1


@in_virtual_time
async def test_who_drives_after_the_goal_is_not_watched() -> None:
    site = Site()
    goal = site.goal()
    await site.command(0.02, motion=False)
    site.end(goal)
    await site.command(0.1, TELEOP)
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 0


@in_virtual_time
async def test_without_a_docking_goal_nothing_is_watched() -> None:
    site = Site()
    site.goal("/fibonacci")
    site.wheels.listen()
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 0
    assert site.watch.halt(Goal("1", "/fibonacci", "type", utc_now(), "gateway")) == ""


@in_virtual_time
async def test_it_tries_again_when_zero_cannot_be_published() -> None:
    site = Site()
    site.port.fails = True
    site.goal()
    await site.command(0.1)
    await asyncio.sleep(3 * TIMEOUT)
    site.port.fails = False
    await asyncio.sleep(TIMEOUT)
    assert site.port.zeros == 1


@in_virtual_time
async def test_a_goal_that_is_lost_stops_its_robot_and_says_so() -> None:
    site = Site()
    goal = site.goal()
    await site.command(0.06)
    assert site.actions.before_lost == [site.watch.halt]
    assert site.watch.halt(goal) == "zero velocity was not sent, as /docking_server drives the robot"
    await asyncio.sleep(TIMEOUT)
    assert site.watch.halt(goal) == "zero velocity was sent"
    site.port.fails = True
    assert site.watch.halt(goal) == "zero velocity could not be sent: is changing its type"
    goal.lose(GoalError("action_server_lost", ""), utc_now())
    for heard in site.actions.on_lost:
        heard(goal)
    assert site.watch.watched("commands") == set()


def stall() -> None:
    """The gateway has no turn for a while."""
    loop = asyncio.get_running_loop()
    assert isinstance(loop, VirtualLoop)
    loop.stall(3 * TIMEOUT)


async def looks() -> None:
    """Let the watch check once."""
    for _ in range(3):
        await asyncio.sleep(0)


@in_virtual_time
async def test_what_arrived_while_the_gateway_stalled_is_heard_before_it_judges() -> None:
    site = Site()
    site.goal()
    await site.command(0.04)
    site.wheels.catch_up = lambda: site.wheels.hear(True, SERVER, time.monotonic())
    for _ in range(3):
        stall()
        await looks()
    assert site.port.zeros == 0


@in_virtual_time
async def test_what_arrives_just_after_the_gateway_stalled_is_in_time() -> None:
    site = Site()
    site.goal()
    for _ in range(3):
        site.wheels.hear(True, SERVER, time.monotonic())
        stall()
        await looks()
    assert site.port.zeros == 0


@in_virtual_time
async def test_commands_that_wait_to_be_heard_are_as_old_as_they_are() -> None:
    site = Site()
    site.goal()
    arrived_at = time.monotonic()
    stall()
    site.wheels.hear(True, SERVER, arrived_at)  # by now its server may be dead
    await asyncio.sleep(TIMEOUT / 2)
    site.wheels.hear(True, SERVER, arrived_at + 0.01)
    await asyncio.sleep(TIMEOUT)
    assert site.port.zeros == 1


@pytest.mark.parametrize("period", [0.05, 0.1, 0.2, 0.34, 0.5, 1.0])
async def test_a_slow_server_is_not_stopped_and_a_dead_one_is(period: float) -> None:
    """No task runs here: it looks when the test says so, on the test's clock."""
    site, random = Site(0.3), Random(f"period {period}")
    site.goal()
    now = began = time.monotonic()
    arrivals = [began + (number + random.uniform(-0.1, 0.1)) * period for number in range(1, 41)]
    known, zeros = arrivals[5], 0
    while now < arrivals[-1] + 3.0 and site.port.zeros == zeros:
        now += 0.05 * random.uniform(1.0, 1.2)
        while arrivals and arrivals[0] <= now:
            site.wheels.hear(True, SERVER, last := arrivals.pop(0))
        site.watch.scan(now)
        if now <= known:
            zeros = site.port.zeros  # it is not known yet how often it commands
        if not arrivals:
            break
    assert site.port.zeros == zeros
    while site.port.zeros == zeros:
        now += 0.06
        site.watch.scan(now)
    assert now - last <= max(0.5, 1.7 * period + 0.12)
    await site.watch.close()
