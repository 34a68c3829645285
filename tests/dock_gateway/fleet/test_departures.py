"""Robots that have gone are forgotten, unless something waits for them. All else is fakes."""

from types import SimpleNamespace
from typing import Any
from unittest.mock import AsyncMock

import pytest

from dock_gateway.fleet.departures import WITHOUT_PAST, Departures
from dock_gateway.ros.graph import Scan

AFTER = 600.0
SCAN = Scan()


class Parts:
    """A registry of robots with `/` and `/robot1`, of actions, and an interlock."""

    default_namespace = "/"

    def __init__(self) -> None:
        self.picks: Any = SimpleNamespace(docking_names=lambda name: [f"{name}/dock"], forget=lambda _: None)
        self.parts_there: set[str] = set()
        self.goals = ["/robot1/dock"]
        self.robots = {name: self.robot(name) for name in ("/", "/robot1")}
        self.there: set[str] = set()
        self.leave = AsyncMock()
        self.looks = 0
        self.held = False
        self.running_on: list[str] = []
        self.lost_on: list[str] = []

    @staticmethod
    def robot(name: str) -> Any:
        publisher = SimpleNamespace(active=False)
        return SimpleNamespace(namespace=name, battery=SimpleNamespace(age=None), publisher=publisher)

    def all(self) -> list[Any]:
        return list(self.robots.values())

    def owner(self, name: str) -> Any:
        return self.robots.get(name.rpartition("/")[0] or "/")

    async def is_there(self, namespace: str, _: Scan) -> bool:
        self.looks += 1
        return namespace in self.there

    async def parts(self, _: str, __: Scan) -> frozenset[str]:
        return frozenset(self.parts_there)

    def last(self, *names: str) -> str | None:
        return next((name for name in names if name in self.goals), None)

    def forget(self, namespace: str) -> None:
        del self.robots[namespace]

    def running(self) -> list[Any]:
        return [SimpleNamespace(action_name=name) for name in self.running_on]

    def lost(self) -> list[Any]:
        return [SimpleNamespace(action_name=name) for name in self.lost_on]

    def holds(self, _: str) -> bool:
        return self.held


@pytest.fixture
def parts() -> Parts:
    return Parts()


def departures_of(parts: Any, forget_after: float = AFTER) -> Departures:
    return Departures(parts, parts, parts.picks, parts, parts, forget_after=forget_after)


async def test_a_robot_that_is_away_for_long_is_forgotten_and_the_configured_one_never(parts: Parts) -> None:
    departures = departures_of(parts)
    parts.there = {"/robot1"}
    await departures.check(SCAN, 1000.0)
    parts.there = set()
    await departures.check(SCAN, 1000.0 + AFTER)
    assert set(parts.robots) == {"/", "/robot1"}
    await departures.check(SCAN, 1020.0 + AFTER)
    assert set(parts.robots) == {"/"}
    await departures.check(SCAN, 1e6)
    assert set(parts.robots) == {"/"}


async def test_one_that_was_away_for_a_moment_starts_anew(parts: Parts) -> None:
    departures = departures_of(parts)
    for seconds in (0.0, AFTER - 1):
        parts.there = {"/robot1"} if seconds else set()
        await departures.check(SCAN, seconds)
    parts.there = set()
    await departures.check(SCAN, 2 * AFTER - 2)
    assert "/robot1" in parts.robots
    await departures.check(SCAN, 2 * AFTER + 10)
    assert "/robot1" not in parts.robots


@pytest.mark.parametrize("reason", ["running", "lost", "stop", "publisher"])
async def test_what_waits_for_a_robot_keeps_it(parts: Parts, reason: str) -> None:
    departures = departures_of(parts)
    parts.running_on = ["/robot1/dock"] * (reason == "running")
    parts.lost_on = ["/robot1/dock"] * (reason == "lost")
    parts.held = reason == "stop"
    parts.robots["/robot1"].publisher.active = reason == "publisher"
    for seconds in (0.0, AFTER + 10, 2 * AFTER):
        await departures.check(SCAN, seconds)
    assert "/robot1" in parts.robots
    parts.running_on, parts.lost_on, parts.held = ["/dock"], ["/elsewhere/dock"], False
    parts.robots["/robot1"].publisher.active = False
    await departures.check(SCAN, 2 * AFTER + 10)
    assert "/robot1" not in parts.robots


async def test_a_battery_that_is_heard_counts(parts: Parts) -> None:
    departures = departures_of(parts)
    battery = parts.robots["/robot1"].battery
    battery.age = 0.1
    await departures.check(SCAN, 10.0)
    await departures.check(SCAN, 10.0 + AFTER + 20)
    battery.age = AFTER - 10
    await departures.check(SCAN, 10.0 + 2 * AFTER)
    assert "/robot1" in parts.robots
    battery.age = AFTER + 10
    await departures.check(SCAN, 30.0 + 2 * AFTER)
    assert "/robot1" not in parts.robots


async def test_it_is_not_looked_for_too_often_and_not_at_all_at_0(parts: Parts) -> None:
    departures = departures_of(parts)
    for seconds in range(20):
        await departures.check(SCAN, float(seconds))
    assert parts.looks == 2
    never = departures_of(parts, 0.0)
    await never.check(SCAN, 0.0)
    await never.check(SCAN, 1e9)
    assert parts.looks == 2
    assert "/robot1" in parts.robots


async def test_one_robot_that_cannot_be_looked_at_keeps_no_other_from_being_forgotten(parts: Parts) -> None:
    class Broken:
        def __getattr__(self, name: str) -> Any:
            if name == "namespace":
                return "/broken"
            raise RuntimeError

    parts.robots = {"/broken": Broken(), **parts.robots}
    departures = departures_of(parts)
    await departures.check(SCAN, 1000.0)
    await departures.check(SCAN, 1020.0 + AFTER)
    assert set(parts.robots) == {"/", "/broken"}


@pytest.mark.parametrize("part", ["server", "battery", "base"])
async def test_what_never_had_a_battery_a_base_or_a_goal_goes_with_its_server(parts: Parts, part: str) -> None:
    departures = departures_of(parts)
    parts.goals, parts.there, parts.parts_there = [], {"/robot1"}, {part}  # other nodes are there as long as one looks
    await departures.check(SCAN, 1000.0)
    parts.parts_there = set()
    await departures.check(SCAN, 1000.0 + WITHOUT_PAST)
    assert "/robot1" in parts.robots, "its server may be restarting"
    await departures.check(SCAN, 1001.0 + 2 * WITHOUT_PAST)
    assert ("/robot1" in parts.robots) is (part == "base")
    parts.there = set()
    await departures.check(SCAN, 1020.0 + 2 * WITHOUT_PAST + AFTER)
    assert "/robot1" not in parts.robots
