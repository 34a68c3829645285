"""The service that stops, however a call of it is written."""

from collections.abc import Iterator

import pytest

from tests.extensions.rosbridge.door import Client, client_of, stop_call, stop_report
from tests.support.two_robots import DEEP, ROBOTS, TwoRobots, two_robots

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def world(shared_domain: int) -> Iterator[TwoRobots]:
    with two_robots(shared_domain) as world:
        yield world


@pytest.fixture
def client(world: TwoRobots) -> Iterator[Client]:
    with client_of(world.gateway) as client:
        yield client
    world.gateway.http.delete("/stop").raise_for_status()


@pytest.mark.parametrize(
    ("args", "robots"),
    [
        (["/robot2", False, "Ada"], ["/robot2"]),
        (["/robot1", "/robot2"], ROBOTS),
        (["/robot2", "/robot2", "/robot2", "/robot2"], ["/robot2"]),
    ],
)
def test_arguments_in_order(client: Client, args: list[object], robots: list[str]) -> None:
    client.connection.send(stop_call(args).decode())
    assert stop_report(client)["stopped"] == robots


def test_arguments_that_are_nested_too_deeply_stop_all(client: Client) -> None:
    client.connection.send((b'{"op":"call_service","service":"/dock_gateway/stop","args":' + DEEP + b"}").decode())
    assert stop_report(client)["stopped"] == ROBOTS


@pytest.mark.parametrize("service", ["dock_gateway/stop", "//dock_gateway/Stop/", "/dock_gateway/stop#7"])
def test_it_is_understood_however_it_is_called(client: Client, service: str) -> None:
    odd = {"id": {"a": 1}, "type": 7, "timeout": "soon", "fragment_size": -1, "compression": []}
    client.send("call_service", service=service, args=["/robot2"], **odd)
    assert stop_report(client)["stopped"] == ["/robot2"]
