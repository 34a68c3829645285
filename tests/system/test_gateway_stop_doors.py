"""A stop stops at every door, whatever its request says, and every door judges it the same way.

A real gateway that is configured for one of two robots, and a real client of each door.
"""

import os
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any, NamedTuple

import orjson
import pytest
from geometry_msgs.msg import Twist
from hypothesis import example, given, settings
from hypothesis import strategies as st
from websockets.sync.client import ClientConnection

from dock_gateway.stop.order import MAX_ROBOTS
from tests.support.clients import connect
from tests.support.doors import QUIET, Stop, doors
from tests.support.gateway import RunningGateway
from tests.support.observer import Recording
from tests.support.processes import ForkedProcess
from tests.support.two_robots import DEEP, ROBOTS, two_robots
from tests.support.waiting import PATIENCE

pytestmark = pytest.mark.ros

Json = dict[str, Any]


class World(NamedTuple):
    """A gateway with two robots, a connection to each door, and what the robots are told."""

    gateway: RunningGateway
    socket: ClientConnection
    doors: dict[str, Stop]
    commanded: dict[str, Recording]

    def rest(self, fields: Any) -> Json:
        headers = {"Content-Type": "application/json"}
        answer = self.gateway.http.post("/stop", content=orjson.dumps(fields), headers=headers)
        assert answer.status_code == 200, answer.text
        report: Json = answer.json()
        return report

    def ws(self, fields: Any) -> Json:
        self.socket.send(orjson.dumps({**fields, "op": "stop"}).decode())
        ack: Json = orjson.loads(self.socket.recv(PATIENCE))
        assert ack["op"] == "ack", ack
        return ack


@pytest.fixture(scope="module")
def world(shared_domain: int) -> Iterator[World]:
    further = {name: value for door in doors() for name, value in door.settings.items()}
    with ExitStack() as stack:
        gateway, commanded = stack.enter_context(two_robots(shared_domain, **further))
        socket = stack.enter_context(connect(f"{gateway.url.replace('http', 'ws')}/ws", **QUIET))
        world = World(gateway, socket, {}, commanded)
        world.doors.update({"rest": world.rest, "ws": world.ws})
        world.doors.update({door.name: stack.enter_context(door.stop(gateway)) for door in doors()})
        yield world


anything = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=6,
)
name = st.sampled_from([*ROBOTS, "robot1", " /robot2/ "])
robot = name | st.lists(name | st.none(), max_size=3) | st.just("/robot9") | anything
requests = st.fixed_dictionaries(
    {}, optional={"robot": robot, "latch": st.booleans() | anything, "by": anything, "reason": anything}
)


def meant(fields: Json) -> list[str]:
    """The robots that a request means, as docs/stop.md says."""
    robot = fields.get("robot")
    named = [each for each in (robot if isinstance(robot, list) else [robot]) if each is not None]
    clear = [f"/{each.strip().strip('/')}" for each in named if isinstance(each, str)]
    known = sorted(set(clear) & set(ROBOTS))
    understood = all(isinstance(each, str) and f"/{each.strip().strip('/')}" in (*ROBOTS, "/robot9") for each in named)
    return known if known and understood and len(named) <= MAX_ROBOTS else ROBOTS


@settings(max_examples=12, deadline=None)
@given(fields=requests)
@example({})
@example({"robot": ["/robot1"]})
@example({"robot": "/robot2", "reason": "person in the way"})
@example({"robot": {"name": "/robot1"}})
@example({"robot": "/robot9"})
@example({"robot": [["/robot1"]], "latch": [], "by": {}})
@example({"robot": ["/robot1"] * (MAX_ROBOTS + 1)})
def test_every_door_understands_the_same(world: World, fields: Json) -> None:
    judged = {}
    for name, stop in world.doors.items():
        before = {robot: len(commanded.messages) for robot, commanded in world.commanded.items()}
        report = stop(fields)
        wrong = [error["path"] for error in (report["warning"] or {}).get("errors", [])]
        judged[name] = (report["stopped"], report["stop"]["robots"], report["stop"]["by"], wrong)
        assert report["stopped"] == meant(fields), (name, fields)
        assert sorted(report["stopped"] + report["not_stopped"]) == ROBOTS
        for robot in report["stopped"]:
            world.commanded[robot].wait_for(lambda twist: twist == Twist(), since=before[robot])
        assert world.gateway.http.delete("/stop").json()["robots"] == []
    assert len({repr(judgement) for judgement in judged.values()}) == 1, judged


def test_a_message_that_is_nested_too_deeply_stops_all(world: World) -> None:
    world.socket.send((b'{"op":"stop","by":' + DEEP + b"}").decode())
    assert orjson.loads(world.socket.recv(PATIENCE))["stopped"] == ROBOTS
    world.gateway.http.delete("/stop")


def test_one_robot_is_released_of_a_stop_of_all(world: World) -> None:
    assert world.rest({})["stop"]["robots"] == ROBOTS
    assert world.gateway.http.delete("/stop?robot=/robot2").json()["latched"] is False
    state = world.gateway.http.get("/stop").json()
    assert (state["latched"], state["robots"]) == (True, ["/robot1"])
    assert world.gateway.http.delete("/stop?robot=/robot1").json()["latched"] is False
    assert world.gateway.http.get("/stop").json()["latched"] is False


def command(world: World, *arguments: str) -> str:
    """What a command prints."""
    with ForkedProcess(
        "dock-gateway", arguments[0], "--url", world.gateway.url, *arguments[1:], env=dict(os.environ)
    ) as ended:
        assert ended.wait() == 0, ended.output
        return ended.output


@pytest.mark.parametrize("option", [(), ("--reason", "a person"), ("--by",), ("--robot",)])
def test_the_command_line_stops_all_and_names_them(world: World, option: tuple[str, ...]) -> None:
    assert "stopped /robot1, /robot2: zero velocity" in command(world, "stop", *option)
    command(world, "release")
    assert world.gateway.http.get("/stop").json()["robots"] == []


def test_the_command_line_names_who_is_not_stopped(world: World) -> None:
    output = command(world, "stop", "/robot2")
    assert "stopped /robot2: zero velocity" in output
    assert "not stopped: /robot1" in output
    command(world, "release")
