"""Which topic is read, and what is said where there is none."""

import logging
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.errors import NotFound
from dock_gateway.core.graph import Topic
from dock_gateway.graph.topic_reader import TopicReader, find_topic

GRID, TEXT = "nav_msgs/msg/OccupancyGrid", "std_msgs/msg/String"


class Endpoint:
    """A publisher."""

    def __init__(self, kind: str) -> None:
        self.type = kind


class Graph:
    """Topics and the types that they are published with; none for one that is only subscribed to."""

    def __init__(self, **topics: str | None) -> None:
        self.topics = topics

    async def topic(self, name: str) -> Topic:
        if (key := name.strip("/").replace("/", "_")) not in self.topics:
            raise NotFound(name)
        kind = self.topics[key]
        return Topic(name, [Endpoint(kind)] if kind else [], [])  # type: ignore[list-item]


class Relays:
    """Notes who joins and leaves."""

    def __init__(self) -> None:
        self.joined: list[str] = []

    async def join(self, topic: str, type_name: str, outlet: object) -> None:
        assert type_name == GRID
        assert outlet is not None
        self.joined.append(topic)

    async def leave(self, topic: str, _: object) -> None:
        self.joined.remove(topic)


@pytest.mark.parametrize(
    ("topics", "found"),
    [
        ({}, "/robot1/map"),
        ({"map": GRID}, "/map"),
        ({"robot1_map": GRID, "map": GRID}, "/robot1/map"),
        ({"robot1_map": TEXT, "map": GRID}, "/map"),
        ({"robot1_map": None, "map": TEXT}, "/map"),
    ],
)
async def test_a_robot_has_its_own_map_or_that_of_all(topics: dict[str, str | None], found: str) -> None:
    assert await find_topic(cast("Any", Graph(**topics)), ["/robot1/map", "/map"], GRID) == found


@pytest.mark.parametrize(
    ("topics", "found"),
    [({"tf_static": GRID}, "/tf"), ({"robot1_tf_static": GRID, "tf": GRID}, "/robot1/tf"), ({}, "/robot1/tf")],
)
async def test_frames_are_there_if_only_fixed_ones_are_published(topics: dict[str, str | None], found: str) -> None:
    names, suffixes = ["/robot1/tf", "/tf"], ("", "_static")
    assert await find_topic(cast("Any", Graph(**topics)), names, GRID, suffixes=suffixes) == found


async def test_a_topic_of_another_type_is_not_joined_and_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    graph, relays = Graph(), Relays()
    reader = TopicReader(cast("Any", relays), cast("Any", graph), "/map", GRID, cast("Any", object()))
    await reader.check()
    assert reader.hint == f"Nothing is published on /map ({GRID})."
    graph.topics["map"] = TEXT
    with caplog.at_level(logging.WARNING):
        await reader.check()
        await reader.check()
    assert [record.getMessage() for record in caplog.records] == [reader.hint]
    assert reader.hint == f"/map is of the type {TEXT}, not {GRID}."
    assert not relays.joined
    graph.topics["map"] = GRID
    await reader.check()
    await reader.check()
    assert (relays.joined, reader.hint) == (["/map"], None)
    await reader.close()
    await reader.close()
    assert not relays.joined


async def test_a_message_that_is_too_large_is_not_read() -> None:
    read: list[Any] = []

    class Outlet:
        async def offer(self, message: Any) -> None:
            read.append(message)

    reader = TopicReader(cast("Any", Relays()), cast("Any", Graph()), "/plan", GRID, Outlet(), most=1_000)
    small, large = (SimpleNamespace(kind=Endpoint(GRID), size=size) for size in (1_000, 1_001))
    for each in (small, large):
        each.kind.name = GRID
        await reader.offer(cast("Any", each))
    assert (read, reader.hint) == ([small], "A message on /plan has more than 0.001 MB, and is not read.")
    await reader.offer(cast("Any", small))
    assert reader.hint is None
