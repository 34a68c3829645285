"""A robot whose commands end while it moves for a docking goal is stopped, and no other."""

import asyncio
from collections.abc import AsyncIterator
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.fleet.findings import FindingKind
from dock_gateway.fleet.wheels_watch import WheelsWatch
from dock_gateway.robots.wheels import Wheels

TIMEOUT = 0.15
SERVER, TELEOP = b"server", b"teleop"
NAMES = {SERVER: "/docking_server", TELEOP: "/teleop"}


class Port:
    def __init__(self) -> None:
        self.zeros = 0
        self.fails = False

    def publish_zero(self) -> None:
        if self.fails:
            raise RuntimeError("is changing its type")
        self.zeros += 1


class Site:
    """One robot with a docking action, and one action that is none."""

    def __init__(self) -> None:
        self.port = Port()
        self.wheels = Wheels(self.port, period=60.0)
        robot = SimpleNamespace(namespace="/", velocity=self.wheels)
        self.actions: Any = SimpleNamespace(
            on_sent=[], on_change=[], on_end=[], on_lost=[], verb_of={"/dock": "dock"}.get, halt=None
        )

        class Robots(dict):  # type: ignore[type-arg]
            def owner(self, _name: str) -> Any:
                return robot

            def get(self, name: str) -> Any:
                return self[name]

        async def name(_robot: str, publisher: bytes) -> str | None:
            return NAMES.get(publisher)

        self.watch = WheelsWatch(self.actions, Robots({"/": robot}), name, TIMEOUT)  # type: ignore[arg-type]
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
            self.wheels.hear(motion, publisher)
            await asyncio.sleep(0.02)


@pytest.fixture
async def site() -> AsyncIterator[Site]:
    site = Site()
    yield site
    await site.watch.close()


async def test_it_is_stopped_once_the_commands_end(site: Site) -> None:
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


async def test_a_false_alarm_ends_when_the_commands_go_on(site: Site) -> None:
    site.goal()
    await site.command(0.1)
    await asyncio.sleep(3 * TIMEOUT)
    assert site.watch.findings
    await site.command(0.1)
    assert site.watch.findings == []


async def test_a_robot_that_was_told_to_stand_needs_no_commands(site: Site) -> None:
    site.goal()
    await site.command(0.1)
    await site.command(0.02, motion=False)
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 0


async def test_another_one_who_drives_is_left_alone(site: Site) -> None:
    site.goal()
    await site.command(0.1)
    await site.command(0.5, TELEOP)
    assert site.port.zeros == 0


async def test_a_robot_that_was_never_heard_is_stopped_without_an_alert(site: Site) -> None:
    site.goal()
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 1
    assert site.watch.findings == []


async def test_a_server_that_dies_as_its_goal_ends(site: Site) -> None:
    goal = site.goal()
    await site.command(0.1)
    site.end(goal)
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 1


async def test_who_drives_after_the_goal_is_not_watched(site: Site) -> None:
    goal = site.goal()
    await site.command(0.02, motion=False)
    site.end(goal)
    await site.command(0.1, TELEOP)
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 0


async def test_without_a_docking_goal_nothing_is_watched(site: Site) -> None:
    site.goal("/fibonacci")
    site.wheels.listen()
    await asyncio.sleep(3 * TIMEOUT)
    assert site.port.zeros == 0
    assert site.watch.halt(Goal("1", "/fibonacci", "type", utc_now(), "gateway")) == ""


async def test_it_tries_again_when_zero_cannot_be_published(site: Site) -> None:
    site.port.fails = True
    site.goal()
    await site.command(0.1)
    await asyncio.sleep(3 * TIMEOUT)
    site.port.fails = False
    await asyncio.sleep(TIMEOUT)
    assert site.port.zeros == 1


async def test_a_goal_that_is_lost_stops_its_robot_and_says_so(site: Site) -> None:
    goal = site.goal()
    await site.command(0.06)
    assert site.actions.halt(goal) == "zero velocity was not sent, as /docking_server drives the robot"
    await asyncio.sleep(TIMEOUT)
    assert site.actions.halt(goal) == "zero velocity was sent"
    site.port.fails = True
    assert site.actions.halt(goal) == "zero velocity could not be sent: is changing its type"
    goal.lose(GoalError("action_server_lost", ""), utc_now())
    for heard in site.actions.on_lost:
        heard(goal)
    assert site.watch.watched("commands") == set()
