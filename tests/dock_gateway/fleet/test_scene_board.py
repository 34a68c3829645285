"""Where all robots are: who is listened to, and what is published when."""

from typing import Any

import orjson
import pytest

from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.fleet.scene_board import REPEAT, SHOWN_FOR, SceneBoard

ROBOTS = ["/robot1", "/robot2"]


def scene(x: float) -> dict[str, Any]:
    pose = {"x": x, "y": 0.0, "theta": 0.0}
    return {"frame": "world", "robot": pose, "dock": None, "docked": None, "staging": None, "footprint": None}


class Fixture:
    """A board whose looks and clock are the test's."""

    def __init__(self) -> None:
        self.now = 100.0
        self.changes: list[set[str]] = []
        self.robots = list(ROBOTS)
        self.fanout = Fanout(queue_limit=10)
        self.board = SceneBoard(self.fanout, lambda: self.robots)
        self.board.on_watch("poses", lambda: self.changes.append(self.board.watched("poses")))

    def subscribe(self) -> Subscriber:
        reader = self.fanout.subscribe(EventFilter(frozenset({"goals", "scenes"})))
        self.look()
        return reader

    def look(self, later: float = 0.2) -> None:
        self.now += later
        self.board.scan(self.now)

    def hear(self, robot: str, x: float) -> None:
        self.board.hear(robot, scene(x), 0)

    async def read(self, reader: Subscriber) -> list[dict[str, float]]:
        events, _ = await reader.take(0.01)
        return [
            {robot: each["robot"]["x"] for robot, each in orjson.loads(event.data)["scenes"].items()}
            for event in events
        ]


@pytest.fixture
async def fixture() -> Fixture:
    fixture = Fixture()
    await fixture.board.close()  # the test looks
    return fixture


async def test_robots_are_listened_to_while_there_is_a_reader(fixture: Fixture) -> None:
    fixture.look()
    reader = fixture.subscribe()
    fixture.robots.append("/robot3")
    fixture.look()
    fixture.fanout.unsubscribe(reader)
    fixture.look()
    assert fixture.changes == [set(ROBOTS), {*ROBOTS, "/robot3"}, set()]


async def test_all_scenes_are_published_when_one_has_moved_and_now_and_then(fixture: Fixture) -> None:
    reader = fixture.subscribe()
    assert await fixture.read(reader) == []
    fixture.hear("/robot2", 2.0)
    fixture.hear("/robot1", 1.0)
    fixture.look()
    assert await fixture.read(reader) == [{"/robot1": 1.0, "/robot2": 2.0}]
    fixture.hear("/robot1", 1.001)
    fixture.look()
    assert await fixture.read(reader) == [], "too little to be seen"
    fixture.hear("/robot1", 1.1)
    fixture.look()
    assert await fixture.read(reader) == [{"/robot1": 1.1, "/robot2": 2.0}]
    fixture.look(REPEAT)
    assert len(await fixture.read(reader)) == 1, "for those who come later"


async def test_every_reader_is_sent_the_same_bytes_and_a_slow_one_the_newest(fixture: Fixture) -> None:
    one, other = fixture.subscribe(), fixture.subscribe()
    for x in (1.0, 2.0, 3.0):
        fixture.hear("/robot1", x)
        fixture.look()
    (first,), _ = await one.take(0.01)
    (second,), dropped = await other.take(0.01)
    assert first is second
    assert orjson.loads(first.data)["scenes"]["/robot1"]["robot"]["x"] == 3.0
    assert dropped == 0


async def test_a_robot_without_a_pose_or_one_that_has_left_is_not_shown(fixture: Fixture) -> None:
    reader = fixture.subscribe()
    fixture.hear("/robot1", 1.0)
    fixture.hear("/robot2", 2.0)
    fixture.look()
    fixture.robots.remove("/robot2")
    fixture.look()
    fixture.look(SHOWN_FOR)
    assert await fixture.read(reader) == [{}], "the newest of three"


async def test_one_who_waits_is_told_that_there_is_none(fixture: Fixture) -> None:
    reader = fixture.subscribe()
    fixture.look(REPEAT)
    assert await fixture.read(reader) == [{}]


async def test_what_was_heard_for_readers_of_before_is_forgotten(fixture: Fixture) -> None:
    reader = fixture.subscribe()
    fixture.hear("/robot1", 1.0)
    fixture.look()
    fixture.fanout.unsubscribe(reader)
    fixture.look()
    fixture.hear("/robot1", 1.0)  # its port is still open
    later = fixture.subscribe()
    assert await fixture.read(later) == []
