"""The gateway in the server process."""

import logging
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.app import create_app
from dock_gateway.assembly import open_gateway
from dock_gateway.cli.server import run
from dock_gateway.doctor.environment import describe_ros
from dock_gateway.extension import extensions
from dock_gateway.gateways.gateways import Gateways
from dock_gateway.gateways.machine import own_address
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from robot_io import ros_variables

log = logging.getLogger(__name__)


def run_gateway(settings: Settings) -> bool:
    """Serve until a signal arrives. Return False if the server could not be started.

    Raises:
        CertificateError: A certificate or key cannot be used.
    """
    return run(settings, _open, create_app, _tell_address)


def _tell_address(parts: Parts, port: int) -> None:
    """Let the other gateways on the database know where this one is."""
    parts[Gateways].listen(own_address(parts[Settings], port))


@asynccontextmanager
async def _open(settings: Settings) -> AsyncIterator[Parts]:
    log.info("%s", describe_ros(os.environ))
    for finding in ros_variables.check(os.environ):
        log.warning("%s", finding.sentence)
    async with open_gateway(settings, extensions()) as parts:
        yield parts
