"""The operations on simulators."""

import asyncio
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

from dock_gateway.core.errors import NotFound, ServerTimeout
from dock_gateway.core.scene import Pose
from dock_gateway.extensions.simulator.port import SimulatorPort
from dock_gateway.robots.simulator import Simulator, Simulators
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings

# Maximum seconds to wait for a report that shows what a command has done.
REPORT_WAIT = 2.0


class SimulatorControls:
    """Controls the simulators.

    Args:
        settings: Names.
        bridge: Runs calls on the ROS thread.
        simulators: The simulators.
    """

    def __init__(self, settings: Settings, bridge: Bridge, simulators: Simulators) -> None:
        self._settings = settings
        self._bridge = bridge
        self._simulators = simulators
        self._ports: dict[str, SimulatorPort] = {}

    def get(self, namespace: str) -> Simulator:
        """Return the simulator of a robot.

        Raises:
            NotFound: `simulator_not_found`.
        """
        simulator = self._simulators.find(namespace)
        if simulator is None:
            raise NotFound(f"there is no simulator of {namespace}", code="simulator_not_found")
        return simulator

    async def reset(self, namespace: str) -> dict[str, Any]:
        """Reset the robot's pose and battery to the start, and end every fault; return the simulator.

        Raises:
            NotFound: `simulator_not_found`.
            ServerTimeout: `simulator_timeout`.
        """
        simulator, port = self.get(namespace), self._port(namespace)
        return await self._do(simulator, port.reset, lambda faults: not any(faults.values()))

    async def place(self, namespace: str, pose: Pose) -> dict[str, Any]:
        """Place the robot at a pose in the frame `world`; return the simulator.

        Raises:
            NotFound: `simulator_not_found`.
            ServerTimeout: `simulator_timeout`.
        """
        simulator, port = self.get(namespace), self._port(namespace)
        return await self._do(simulator, lambda: port.place(pose))

    async def switch(self, namespace: str, fault: str, *, active: bool) -> dict[str, Any]:
        """Switch a fault on or off; return the simulator.

        Raises:
            NotFound: `simulator_not_found`.
            ServerTimeout: `simulator_timeout`.
        """
        simulator, port = self.get(namespace), self._port(namespace)
        return await self._do(
            simulator,
            lambda: port.switch(fault, active=active),
            lambda faults: faults.get(fault) is active,
        )

    def _port(self, namespace: str) -> SimulatorPort:
        if namespace not in self._ports:
            self._ports[namespace] = SimulatorPort(self._bridge, partial(self._settings.resolve, namespace=namespace))
        return self._ports[namespace]

    async def _do(
        self,
        simulator: Simulator,
        command: Callable[[], Awaitable[None]],
        expected: Callable[[dict[str, bool]], bool] = lambda _: True,
    ) -> dict[str, Any]:
        """Carry out a command; return the first report that shows what it has done, which comes by a topic.

        Args:
            simulator: The simulator.
            command: The command.
            expected: Whether these faults are those after it.

        Raises:
            ServerTimeout: `simulator_timeout`: it does not answer, or does not report what was done.
        """
        before = simulator.values.get("commands")
        try:
            await command()
        except TimeoutError:
            raise ServerTimeout("the simulator does not answer", code="simulator_timeout") from None
        try:
            async with asyncio.timeout(REPORT_WAIT):
                while simulator.values.get("commands") == before or not expected(simulator.document()["faults"]):
                    simulator.changed.clear()
                    await simulator.changed.wait()
        except TimeoutError:
            detail = "the simulator has not reported yet that it has carried out the command"
            raise ServerTimeout(detail, code="simulator_timeout") from None
        return simulator.document()

    async def leave(self, namespace: str) -> None:
        """Leave the topics and services of a robot that is about to be removed."""
        if (port := self._ports.pop(namespace, None)) is not None:
            port.close()

    async def close(self) -> None:
        """Leave all."""
        for namespace in list(self._ports):
            await self.leave(namespace)
