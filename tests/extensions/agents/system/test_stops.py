"""The tool that stops, however a call of it is written."""

from collections.abc import Iterator

import httpx2
import pytest

from tests.extensions.agents.door import SETTINGS, http_of, stop_call
from tests.support.two_robots import DEEP, ROBOTS, TwoRobots, two_robots

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def world(shared_domain: int) -> Iterator[TwoRobots]:
    with two_robots(shared_domain, **SETTINGS) as world:
        yield world


@pytest.fixture(scope="module")
def agent(world: TwoRobots) -> Iterator[httpx2.Client]:
    with http_of(world.gateway) as http:
        yield http


@pytest.mark.parametrize("arguments", [["/robot2"], "/robot2", 7, None])
def test_arguments_that_are_no_object_stop_too(world: TwoRobots, agent: httpx2.Client, arguments: object) -> None:
    agent.post("/mcp", content=stop_call(arguments, []))
    assert world.held() == (["/robot2"] if "/robot2" in str(arguments) else ROBOTS)


@pytest.mark.parametrize(
    ("path", "tool"), [("/mcp", "stop\\u005frobots"), ("/mcp?anything=1", "stop_robots"), ("/mcp", "stop_robots")]
)
def test_it_is_known_however_it_is_written(world: TwoRobots, agent: httpx2.Client, path: str, tool: str) -> None:
    call = f'{{"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {{"name": "{tool}", "arguments": {{}}}}}}'
    agent.post(path, content=call)
    assert world.held() == ROBOTS


def test_arguments_that_are_nested_too_deeply_stop_all(world: TwoRobots, agent: httpx2.Client) -> None:
    call = b'{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"stop_robots","arguments":' + DEEP + b"}}"
    agent.post("/mcp", content=call)
    assert world.held() == ROBOTS
