"""Which simulators can be controlled, and until when their topics are joined. system/ has a real one."""

from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.errors import NotFound, ServerTimeout
from dock_gateway.extensions.simulator import controls as module
from dock_gateway.extensions.simulator.controls import SimulatorControls
from dock_gateway.robots.simulator import Simulator
from dock_gateway.settings import Settings


class Port:
    """The port of one simulator, which does not answer."""

    closed: list[str]

    def __init__(self, _: object, resolve: Any) -> None:
        self.name = resolve("simulator")

    async def reset(self) -> None:
        raise TimeoutError

    def close(self) -> None:
        self.closed.append(self.name)


@pytest.fixture
def controls(monkeypatch: pytest.MonkeyPatch) -> SimulatorControls:
    Port.closed = []
    monkeypatch.setattr(module, "SimulatorPort", Port)
    known = {name: Simulator({}, 0.0) for name in ("/robot1", "/robot2")}
    simulators: Any = SimpleNamespace(find=known.get)
    bridge: Any = None
    return SimulatorControls(Settings(), bridge, simulators)


async def test_a_robot_without_a_simulator(controls: SimulatorControls) -> None:
    with pytest.raises(NotFound) as refused:
        await controls.reset("/robot3")
    assert refused.value.code == "simulator_not_found"


async def test_the_topics_of_a_robot_that_is_removed_are_left(controls: SimulatorControls) -> None:
    for robot in ("/robot1", "/robot2"):
        with pytest.raises(ServerTimeout):
            await controls.reset(robot)
    await controls.leave("/robot1")
    await controls.leave("/robot1")
    assert Port.closed == ["/robot1/simulator"]
    await controls.close()
    assert Port.closed == ["/robot1/simulator", "/robot2/simulator"]
