"""What the odometer adds to the gateway."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.http.parts import Parts
from dock_gateway_odometer.odometers import SERVICE_DUE, Odometers
from dock_gateway_odometer.routes import router
from dock_gateway_odometer.settings import OdometerSettings


@asynccontextmanager
async def open_odometers(parts: Parts) -> AsyncIterator[Odometers]:
    """Count until the gateway closes."""
    async with closing(Odometers(parts)) as odometers:
        await odometers.open()
        with parts[AlertBoard].sources.adding(odometers.alerts):
            yield odometers


extension = Extension(
    "odometer",
    open_odometers,
    settings=OdometerSettings,
    routes=lambda _: (router,),
    alerts=(SERVICE_DUE,),
    card=Path(__file__).with_name("card.js"),
)
