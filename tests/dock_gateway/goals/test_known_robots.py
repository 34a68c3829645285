"""A typing error in a robot's name is refused in reports, and a robot that was there is not."""

import asyncio
from typing import Any

import pytest

from dock_gateway.core.errors import NotFound
from dock_gateway.core.event import Event
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.settings import Settings
from tests.support.history import HistoryInMemory, make_goal
from tests.support.robot_actions import FakeRobots, make_known_robots, make_robot_actions

TABLE: Any = {"robots": {"/fleet/named": {"dock_action": "/shared/dock_named"}}}


def is_known(known: KnownRobots, robot: str | None, grant: Grant = UNLIMITED) -> bool:
    try:
        asyncio.run(known.require(robot, grant))
    except NotFound:
        return False
    return True


@pytest.mark.parametrize(
    ("robot", "known"),
    [
        (None, True),
        ("/", True),
        ("/fleet/robot1", True),
        ("/fleet", True),
        ("/fleet/robot", False),
        ("/fleet/robot1/arm", False),
        ("/fleet/named", True),
        ("/robto1", False),
    ],
)
def test_robots_on_the_graph_and_in_the_settings(robot: str | None, known: bool) -> None:
    assert is_known(make_known_robots(HistoryInMemory(), "/fleet/robot1", settings=Settings(**TABLE)), robot) is known


def test_robots_that_have_left_are_found_by_their_goals_and_batteries() -> None:
    history = HistoryInMemory()
    known = make_known_robots(history, "/")
    assert not is_known(known, "/gone")
    history.record(make_goal(1, action="/gone/dock"))
    history.record_event(Event(b"{}", "battery", id="1" * 20, robot="/flat"))
    for _ in ("in memory", "stored"):
        assert [is_known(known, robot) for robot in ("/gone", "/flat", "/other")] == [True, True, False]
        asyncio.run(history.writer.flush())


def test_a_robot_with_a_label_is_known() -> None:
    history, actions, robots = HistoryInMemory(), make_robot_actions(None, "/"), FakeRobots("/")
    labels = Labels(history.documents("label", RobotLabel), robots.namespaces)
    asyncio.run(labels.replace("/new", RobotLabel("Rosie", ())))
    assert is_known(KnownRobots(Settings(), robots, labels, actions, history), "/new")


def test_a_robot_that_one_may_not_see_is_not_looked_up() -> None:
    known = make_known_robots(HistoryInMemory(), "/", "/robot1")
    limited = Grant(Role.VIEWER, robots=("/robot1",))
    assert is_known(known, "/robot2", limited)
    assert is_known(known, "/", limited)
    assert is_known(known, "/robot1", limited)
    assert not is_known(known, "/robot1/arm", limited)
