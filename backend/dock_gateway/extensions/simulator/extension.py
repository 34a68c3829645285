"""Manual control of simulated robots."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.extensions.simulator.controls import SimulatorControls
from dock_gateway.extensions.simulator.error_codes import CODES
from dock_gateway.extensions.simulator.routes import router
from dock_gateway.http.parts import Parts
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.simulator import Simulators
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings


@asynccontextmanager
async def open_simulator(parts: Parts) -> AsyncIterator[SimulatorControls]:
    """Control simulators on request."""
    async with closing(SimulatorControls(parts[Settings], parts[Bridge], parts[Simulators])) as controls:
        with parts[RobotRegistry].before_removal.adding(controls.leave):
            yield controls


extension = Extension("simulator", open_simulator, routes=lambda _: (router,), errors=CODES)
