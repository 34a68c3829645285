"""What is new on the graph is taken up one by one."""

import asyncio
import logging
from typing import Any

import pytest

from dock_gateway.core.discovery import Discovery
from dock_gateway.core.errors import Unavailable


class Graph:
    """What can be taken up; `failing` says what comes of it."""

    def __init__(self, limit: int = 100, **seconds: float) -> None:
        self.discovery = Discovery("thing", limit, "max_things", **seconds)
        self.known: dict[str, Any] = {}
        self.failing: dict[str, Exception] = {}
        self.tried: list[str] = []

    async def take_up(self, name: str) -> None:
        self.tried.append(name)
        await asyncio.sleep(0)
        if error := self.failing.get(name):
            raise error
        self.known[name] = name

    async def look(self, *names: str) -> bool:
        self.tried = []
        self.discovery.keep(names)
        new = [name for name in names if name not in self.known]
        return await self.discovery.take_up(new, self.known, self.take_up)


async def test_one_that_fails_keeps_no_other_out(caplog: pytest.LogCaptureFixture) -> None:
    graph = Graph()
    graph.failing = {"/a": RuntimeError("built for another Python"), "/b": ImportError("not installed")}
    with caplog.at_level(logging.WARNING):
        assert not await graph.look("/a", "/b", "/c")
        assert not await graph.look("/a", "/b", "/c")
    assert set(graph.known) == {"/c"}
    assert graph.tried == [], "they are left alone for a while"
    assert {name: failure.why for name, failure in graph.discovery.failed.items()} == {
        "/a": "built for another Python",
        "/b": "not installed",
    }
    assert len(caplog.records) == 2


async def test_one_that_failed_is_tried_again(caplog: pytest.LogCaptureFixture) -> None:
    graph = Graph(retry_after=0.0)
    graph.failing = {"/a": ImportError("not installed")}
    for _ in range(3):
        await graph.look("/a")
        assert graph.tried == ["/a"]
    assert len(caplog.records) == 1, "the same is said once"
    graph.failing = {}
    await graph.look("/a")
    assert "/a" in graph.known
    assert graph.discovery.failed == {}


async def test_one_that_has_gone_is_forgotten() -> None:
    graph = Graph()
    graph.failing = {"/a": ImportError("not installed")}
    await graph.look("/a")
    await graph.look()
    assert graph.discovery.failed == {}


async def test_many_are_taken_up_in_turns() -> None:
    graph, names = Graph(turn=0.0), [f"/{number}" for number in range(5)]
    looks = 1
    while await graph.look(*names):
        looks += 1
        assert looks < 20
    assert list(graph.known) == names
    assert looks > 2


async def test_there_is_a_limit() -> None:
    graph = Graph(limit=2)
    await graph.look("/a", "/b", "/c")
    assert set(graph.known) == {"/a", "/b"}
    assert "max_things" in graph.discovery.failed["/c"].why


async def test_without_the_ros_thread_nothing_is_blamed() -> None:
    graph = Graph()
    graph.failing = {"/a": Unavailable("down", code="ros_unavailable")}
    with pytest.raises(Unavailable):
        await graph.look("/a", "/b")
    assert graph.discovery.failed == {}
    assert graph.known == {}


async def test_one_that_failed_for_an_unknown_reason_is_tried_again_soon() -> None:
    graph = Graph(retry_soon=0.0)
    graph.failing = {"/a": RuntimeError("the type is taken"), "/b": TypeError("no such field")}
    await graph.look("/a", "/b")
    await graph.look("/a", "/b")
    assert graph.tried == ["/a"]
