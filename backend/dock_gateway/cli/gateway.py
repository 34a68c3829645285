"""The gateway in the server process."""

import logging
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.app import create_app
from dock_gateway.assembly import open_gateway
from dock_gateway.cli.hangup import Reread
from dock_gateway.cli.server import run
from dock_gateway.doctor.environment import describe_ros
from dock_gateway.extension import extensions
from dock_gateway.gateways.gateways import Gateways
from dock_gateway.gateways.machine import own_address
from dock_gateway.graph.parameters import Parameters
from dock_gateway.graph.publishing import Publishing
from dock_gateway.graph.service_calls import ServiceCalls
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from robot_io import ros_variables

log = logging.getLogger(__name__)


def run_gateway(settings: Settings, reread: Reread) -> bool:
    """Serve until a signal arrives. Return False if the server could not be started.

    Args:
        settings: The settings.
        reread: Reads them again, after SIGHUP.

    Raises:
        CertificateError: A certificate or key cannot be used.
    """
    return run(settings, _open, create_app, _tell_address, reread=reread, on_reread=_take)


def _tell_address(parts: Parts, port: int) -> None:
    """Let the other gateways on the database know where this one is."""
    parts[Gateways].listen(own_address(parts[Settings], port))


def _take(parts: Parts, settings: Settings) -> None:
    """Take the allow lists, as they are now."""
    parts[Publishing].listed.replace(settings.allow_publish)
    parts[ServiceCalls].listed.replace(settings.allow_services)
    parts[Parameters].listed.replace(settings.allow_parameters)


@asynccontextmanager
async def _open(settings: Settings) -> AsyncIterator[Parts]:
    log.info("%s", describe_ros(os.environ))
    for finding in ros_variables.check(os.environ):
        log.warning("%s", finding.sentence)
    async with open_gateway(settings, extensions()) as parts:
        yield parts
