"""Runs simulated sites behind the real connection to a hub."""

import argparse
import asyncio
import json
import signal
import uuid
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import uvicorn
import uvloop

from dock_gateway.extensions.sites.installation import KEY, Installation
from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.extensions.sites.settings import SiteSettings
from dock_gateway.extensions.sites.uplink import Uplink
from tests.support.site_api import SiteApi
from tests.support.site_simulation import Journal, SimulatedSite


class Installations:
    """The part of a history that a connection to a hub needs: the id of the installation."""

    def __init__(self, installation: str) -> None:
        self._installation = Installation(uuid.UUID(installation))

    def documents(self, _kind: str, _model: object) -> "Installations":
        return self

    async def read(self) -> dict[str, Installation]:
        return {KEY: self._installation}

    async def write(self, _key: str, _entry: object, check: Callable[[Mapping[str, Any]], None]) -> None:
        check({KEY: self._installation})


def run(arguments: argparse.Namespace) -> None:
    """Run until SIGTERM."""
    uvloop.run(_run(arguments))


async def _run(arguments: argparse.Namespace) -> None:
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    brokers = json.loads(arguments.brokers.read_bytes())
    async with AsyncExitStack() as stack, asyncio.TaskGroup() as group:
        tasks = []
        for index, name in enumerate(arguments.sites):
            journal = Journal(_journal(arguments.journals, name))
            site = SimulatedSite(name, arguments.robots, journal, change_period=arguments.change_period)
            app = SiteApi(site).app
            tasks.append(group.create_task(site.run()))
            settings = SiteSettings(nats=brokers[name], site=name, hub_public_keys=arguments.keys, hub_role="admin")
            uplink = Uplink(settings, Installations(site.installation), HubLink(name))  # type: ignore[arg-type]
            await uplink.open(app, {})
            stack.push_async_callback(uplink.close)
            stack.push_async_callback(uplink.leave)
            if index == 0 and arguments.port is not None:
                config = uvicorn.Config(app, port=arguments.port, log_level="warning")
                tasks.append(group.create_task(uvicorn.Server(config).serve()))
        print("serving", flush=True)
        await ended.wait()
        for task in tasks:
            task.cancel()


def _journal(folder: Path | None, name: str) -> Path | None:
    return None if folder is None else folder / f"{name}.jsonl"
