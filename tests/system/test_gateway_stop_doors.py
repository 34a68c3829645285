"""A stop stops at every door, whatever its request says, and every door judges it the same way.

A real gateway that is configured for one of two robots, and a real client of each door.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any, NamedTuple

import httpx2
import orjson
import pytest
from geometry_msgs.msg import Twist
from hypothesis import example, given, settings
from hypothesis import strategies as st
from websockets.sync.client import ClientConnection
from websockets.sync.client import connect as open_websocket

from dock_gateway.stop.order import MAX_ROBOTS
from tests.support.clients import connect
from tests.support.gateway import RunningGateway, running_gateway
from tests.support.observer import Observer, Recording, ros_observer
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import PATIENCE, wait_until
from tests.system.test_gateway_foxglove import Client as Viewer
from tests.system.test_gateway_foxglove import client_of as viewer_of

pytestmark = pytest.mark.ros

ROBOTS = ["/robot1", "/robot2"]
Json = dict[str, Any]


class World(NamedTuple):
    """A gateway with two robots, a connection to each door, and what the robots are told."""

    gateway: RunningGateway
    socket: ClientConnection
    rosbridge: ClientConnection
    viewer: Viewer
    agent: httpx2.Client
    commanded: dict[str, Recording]


@pytest.fixture(scope="module")
def world(shared_domain: int) -> Iterator[World]:
    with ExitStack() as stack:
        command = ("-m", "tests.support.robots", "--robots", "2")
        stack.enter_context(ForkedProcess(*command, env=ros_environment(shared_domain)))
        observer: Observer = stack.enter_context(ros_observer(shared_domain))
        commanded = {name: observer.record(Twist, f"{name}/cmd_vel") for name in ROBOTS}
        gateway = stack.enter_context(running_gateway(shared_domain, namespace="/robot1", mcp="true"))
        wait_until(lambda: len(gateway.http.get("/robots").json()["robots"]) == 2, "the robots")
        wait_until(lambda: observer.node.count_publishers("/robot2/cmd_vel"), "the gateway on the topic")
        url = gateway.url.replace("http", "ws")
        headers = {"Accept": "application/json, text/event-stream", "Content-Type": "application/json"}
        yield World(
            gateway,
            stack.enter_context(connect(f"{url}/ws")),
            stack.enter_context(open_websocket(f"{url}/rosbridge", max_size=None)),
            stack.enter_context(viewer_of(gateway)),
            stack.enter_context(httpx2.Client(base_url=gateway.url, headers=headers, timeout=PATIENCE)),
            commanded,
        )


def rest(world: World, fields: Any) -> Json:
    answer = world.gateway.http.post(
        "/stop", content=orjson.dumps(fields), headers={"Content-Type": "application/json"}
    )
    assert answer.status_code == 200, answer.text
    report: Json = answer.json()
    return report


def ws(world: World, fields: Any) -> Json:
    world.socket.send(orjson.dumps({**fields, "op": "stop"}).decode())
    ack: Json = orjson.loads(world.socket.recv(PATIENCE))
    assert ack["op"] == "ack", ack
    return ack


def service_call(fields: Any) -> bytes:
    return orjson.dumps({"op": "call_service", "service": "/dock_gateway/stop", "args": fields})


def response(world: World) -> Json:
    while (message := orjson.loads(world.rosbridge.recv(PATIENCE)))["op"] != "service_response":
        pass
    assert message["result"], message
    report: Json = message["values"]
    return report


def rosbridge(world: World, fields: Any) -> Json:
    world.rosbridge.send(service_call(fields).decode())
    return response(world)


def fragments(world: World, fields: Any) -> Json:
    text = service_call(fields).decode()
    pieces = [text[at : at + 40] for at in range(0, len(text), 40)]
    for number, piece in enumerate(pieces):
        fragment = {"op": "fragment", "id": "f", "data": piece, "num": number, "total": len(pieces)}
        world.rosbridge.send(orjson.dumps(fragment).decode())
    return response(world)


def foxglove(world: World, fields: Any) -> Json:
    answer = orjson.loads(world.viewer.call("/dock_gateway/stop", orjson.dumps(fields), "json"))
    report: Json = orjson.loads(answer["report"])
    return report


def mcp(world: World, arguments: Any) -> Json:
    call = {
        "jsonrpc": "2.0",
        "id": 1,
        "method": "tools/call",
        "params": {"name": "stop_robots", "arguments": arguments},
    }
    answer = world.agent.post("/mcp", content=orjson.dumps(call))
    assert answer.status_code == 200, answer.text
    data = next(line for line in answer.text.splitlines() if "jsonrpc" in line)
    result = orjson.loads(data.removeprefix("data: "))["result"]
    assert not result.get("isError"), result
    report: Json = result["structuredContent"]
    return report


DOORS: list[Callable[[World, Any], Json]] = [rest, ws, rosbridge, fragments, foxglove, mcp]

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
    for door in DOORS:
        before = {robot: len(commanded.messages) for robot, commanded in world.commanded.items()}
        report = door(world, fields)
        wrong = [error["path"] for error in (report["warning"] or {}).get("errors", [])]
        judged[door.__name__] = (report["stopped"], report["stop"]["robots"], report["stop"]["by"], wrong)
        assert report["stopped"] == meant(fields), (door.__name__, fields)
        assert sorted(report["stopped"] + report["not_stopped"]) == ROBOTS
        for robot in report["stopped"]:
            world.commanded[robot].wait_for(lambda twist: twist == Twist(), since=before[robot])
        assert world.gateway.http.delete("/stop").json()["robots"] == []
    assert len({repr(judgement) for judgement in judged.values()}) == 1, judged


@pytest.mark.parametrize("arguments", [["/robot2"], "/robot2", 7, None])
def test_arguments_of_a_tool_that_are_no_object_stop_too(world: World, arguments: object) -> None:
    call = {
        "jsonrpc": "2.0",
        "id": [],
        "method": "tools/call",
        "params": {"name": "stop_robots", "arguments": arguments},
    }
    world.agent.post("/mcp", content=orjson.dumps(call))
    held = world.gateway.http.get("/stop").json()["robots"]
    assert held == (["/robot2"] if "/robot2" in str(arguments) else ROBOTS)
    world.gateway.http.delete("/stop")


@pytest.mark.parametrize(
    ("path", "tool"), [("/mcp", "stop\\u005frobots"), ("/mcp?anything=1", "stop_robots"), ("/mcp", "stop_robots")]
)
def test_a_tool_is_known_however_it_is_written(world: World, path: str, tool: str) -> None:
    call = f'{{"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {{"name": "{tool}", "arguments": {{}}}}}}'
    world.agent.post(path, content=call)
    assert world.gateway.http.get("/stop").json()["robots"] == ROBOTS
    world.gateway.http.delete("/stop")


@pytest.mark.parametrize(
    ("args", "robots"),
    [
        (["/robot2", False, "Ada"], ["/robot2"]),
        (["/robot1", "/robot2"], ROBOTS),
        (["/robot2", "/robot2", "/robot2", "/robot2"], ["/robot2"]),
    ],
)
def test_the_arguments_of_a_service_in_order(world: World, args: list[object], robots: list[str]) -> None:
    world.rosbridge.send(service_call(args).decode())
    assert response(world)["stopped"] == robots
    world.gateway.http.delete("/stop")


DEEP = b'{"robot":' * 2000 + b"1" + b"}" * 2000


def test_a_message_that_is_nested_too_deeply_stops_all(world: World) -> None:
    world.socket.send((b'{"op":"stop","by":' + DEEP + b"}").decode())
    assert orjson.loads(world.socket.recv(PATIENCE))["stopped"] == ROBOTS
    world.rosbridge.send((b'{"op":"call_service","service":"/dock_gateway/stop","args":' + DEEP + b"}").decode())
    assert response(world)["stopped"] == ROBOTS
    world.gateway.http.delete("/stop")
    call = b'{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"stop_robots","arguments":' + DEEP + b"}}"
    world.agent.post("/mcp", content=call)
    assert world.gateway.http.get("/stop").json()["robots"] == ROBOTS
    world.gateway.http.delete("/stop")


@pytest.mark.parametrize("service", ["dock_gateway/stop", "//dock_gateway/Stop/", "/dock_gateway/stop#7"])
def test_the_service_of_rosbridge_is_understood_however_it_is_called(world: World, service: str) -> None:
    odd = {"id": {"a": 1}, "type": 7, "timeout": "soon", "fragment_size": -1, "compression": []}
    world.rosbridge.send(orjson.dumps({"op": "call_service", "service": service, "args": ["/robot2"], **odd}).decode())
    assert response(world)["stopped"] == ["/robot2"]
    world.gateway.http.delete("/stop")


def test_calls_of_foxglove_that_are_cut_off_stop(world: World) -> None:
    service = world.viewer.service("/dock_gateway/stop")
    for data in (b"\x02" + service.to_bytes(4, "little"), b"\x02" + service.to_bytes(4, "little") + b"\xff" * 8):
        world.viewer.connection.send(data)
        while world.viewer.next()["op"] not in ("response", "serviceCallFailure"):
            pass
        assert world.gateway.http.get("/stop").json()["robots"] == ROBOTS
        world.gateway.http.delete("/stop")


def test_one_robot_is_released_of_a_stop_of_all(world: World) -> None:
    assert rest(world, {})["stop"]["robots"] == ROBOTS
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
    assert "zero velocity published to /robot1, /robot2" in command(world, "stop", *option)
    command(world, "release")
    assert world.gateway.http.get("/stop").json()["robots"] == []


def test_the_command_line_names_who_is_not_stopped(world: World) -> None:
    output = command(world, "stop", "/robot2")
    assert "published to /robot2" in output
    assert "not stopped: /robot1" in output
    command(world, "release")
