"""The parameters of an action server: asked for once, followed from then on, asked for again after a restart."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import closing

import pytest
from rclpy.parameter import Parameter

from dock_gateway.core.work import Work
from dock_gateway.extensions.recordings import server_parameters
from dock_gateway.extensions.recordings.server_parameters import ServerParameters
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.relays import Relays
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.parameter_port import ParameterPort
from dock_gateway.ros.parameter_reader import ParameterReader
from tests.extensions.recordings.worker import ACTION, NODE
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import PATIENCE

pytestmark = pytest.mark.timeout(2 * PATIENCE)


def worker(domain: int, speed: float) -> ForkedProcess:
    return ForkedProcess("-m", "tests.extensions.recordings.worker", str(speed), env=ros_environment(domain))


@pytest.fixture
async def parameters(bridge: Bridge) -> AsyncIterator[ServerParameters]:
    graph, work = GraphCache(bridge), Work()
    relays = Relays(bridge, graph, work)
    parameters = ServerParameters(bridge, relays)
    yield parameters
    await parameters.close()
    await relays.close()
    await work.close()
    await graph.close()


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The nodes that were asked for their parameters."""
    asked: list[str] = []

    class CountingReader(ParameterReader):
        def __init__(self, bridge: Bridge, node: str) -> None:
            asked.append(node)
            super().__init__(bridge, node)

    monkeypatch.setattr(server_parameters, "ParameterReader", CountingReader)
    return asked


async def read(parameters: ServerParameters, speed: float) -> None:
    """Read the parameters until they are these."""
    while True:
        found = await parameters.read(ACTION)
        if found is not None and (found["node"], found["values"].get("speed")) == (NODE, speed):
            return
        await asyncio.sleep(0.05)


async def test_a_server_is_asked_once_and_its_changes_are_followed(
    domain: int, bridge: Bridge, parameters: ServerParameters, asked: list[str]
) -> None:
    with worker(domain, 0.25):
        await read(parameters, 0.25)
        once = list(asked)
        for _ in range(10):
            await read(parameters, 0.25)
        with closing(ParameterPort(bridge, NODE, PATIENCE)) as port:
            (result,) = await port.set({"speed": Parameter("speed", value=0.5).get_parameter_value()}, at_once=True)
        assert result.successful
        await read(parameters, 0.5)
        assert asked == once


async def test_a_server_that_was_started_again_is_asked_again(
    domain: int, parameters: ServerParameters, asked: list[str]
) -> None:
    with worker(domain, 0.25):
        await read(parameters, 0.25)
    once = len(asked)
    with worker(domain, 0.75):
        while len(asked) == once:  # its events may come before its endpoint
            await read(parameters, 0.75)


async def test_an_action_without_a_server_has_none(parameters: ServerParameters, asked: list[str]) -> None:
    assert await parameters.read("/nothing") is None
    assert asked == []
