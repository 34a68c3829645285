"""Topics are subscribed to while they are wanted, a little longer, and again after a failure."""

import asyncio
from collections.abc import AsyncIterator, Callable
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.robots.on_demand import OnDemand
from dock_gateway.ros.bridge import Bridge
from tests.support.waiting import until

LINGER = 0.2


class Wanted:
    """The robots that the test wants."""

    def __init__(self) -> None:
        self.robots: set[str] = set()
        self.changed: Callable[[], None]

    def watched(self, topic: str) -> set[str]:
        assert topic == "scene"
        return set(self.robots)

    def on_watch(self, topic: str, changed: Callable[[], None]) -> None:
        assert topic == "scene"
        self.changed = changed

    def want(self, *robots: str) -> None:
        self.robots = set(robots)
        self.changed()


class Ports:
    """A bridge that runs everything at once, and the ports that are open."""

    def __init__(self) -> None:
        self.open: set[str] = set()
        self.opened: list[str] = []
        self.broken: set[str] = set()

    async def call(self, make: Callable[[], Any], undo: Callable[[Any], None]) -> Any:
        return make()

    def to_ros(self, work: Callable[[], None]) -> None:
        work()

    def make(self, robot: str) -> SimpleNamespace:
        if robot in self.broken:
            raise Unavailable("the ROS thread does not answer", code="ros_unavailable")
        self.open.add(robot)
        self.opened.append(robot)
        return SimpleNamespace(close=lambda: self.open.discard(robot))


@pytest.fixture
async def parts() -> AsyncIterator[tuple[Wanted, Ports]]:
    wanted, ports = Wanted(), Ports()
    topics = OnDemand(cast("Bridge", ports), wanted, "scene", ports.make, linger=LINGER)
    yield wanted, ports
    await topics.close()


async def test_while_they_are_wanted_and_a_little_longer(parts: tuple[Wanted, Ports]) -> None:
    wanted, ports = parts
    wanted.want("/a", "/b")
    await until(lambda: ports.open == {"/a", "/b"})
    wanted.want("/a")
    await asyncio.sleep(LINGER / 4)
    wanted.want("/a", "/b")
    await asyncio.sleep(2 * LINGER)
    assert sorted(ports.opened) == ["/a", "/b"], "it was not closed"
    wanted.want()
    await until(lambda: not ports.open)


async def test_they_are_closed_also_while_others_come_and_go(parts: tuple[Wanted, Ports]) -> None:
    wanted, ports = parts
    wanted.want("/a", "/b")
    await until(lambda: ports.open == {"/a", "/b"})

    def change() -> bool:
        wanted.want("/b", *({"/c"} - wanted.robots))
        return "/a" not in ports.open

    await until(change)
    assert "/b" in ports.open


async def test_one_that_fails_is_tried_again_and_holds_up_no_other(parts: tuple[Wanted, Ports]) -> None:
    wanted, ports = parts
    ports.broken = {"/a", "/c"}
    wanted.want("/a", "/b", "/c")
    await until(lambda: ports.open == {"/b"})
    ports.broken = set()
    await until(lambda: ports.open == {"/a", "/b", "/c"})
