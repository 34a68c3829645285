"""A site, a broker and a hub, and a reader at the hub."""

import asyncio
import random
from collections.abc import Coroutine, Sequence
from typing import Any
from unittest.mock import patch

from dock_gateway.sites import broker
from dock_gateway.sites.tunnel.caller import TunnelAddress
from tests.dock_gateway.simulation.chance import Faults
from tests.dock_gateway.simulation.database import Disk
from tests.dock_gateway.simulation.gateway import Gateway
from tests.dock_gateway.simulation.hub import Hub
from tests.dock_gateway.simulation.nats import NatsServer
from tests.dock_gateway.simulation.process import Process
from tests.dock_gateway.simulation.site import Site
from tests.dock_gateway.simulation.world import World


class SitesWorld(World):
    """One run with a hub.

    Args:
        seed: Decides everything.
        disk: The database of the site.
        hub_disk: The database of the hub.
        faults: What goes wrong.
    """

    def __init__(self, seed: int, disk: Disk, hub_disk: Disk, faults: Faults) -> None:
        super().__init__(seed, disk, faults)
        self._seed = seed
        self._hub_disk = hub_disk
        self._hub: Hub | None = None
        self.nats = NatsServer(self._chance)

    async def run(self) -> None:
        random.seed(self._seed)  # of the pauses between attempts
        with patch.object(broker, "NatsClient", self.nats.connect):
            await super().run()

    async def _begin(self) -> None:
        self._hub_disk.empty()
        await super()._begin()
        await self._start_hub()
        for _ in range(600):
            await asyncio.sleep(0.1)
            if self._hub is not None and self._hub.view.cursor is not None:
                return  # what ended before a hub first knows a site is not told there
        raise AssertionError("the hub does not get to know the site")

    def _readable(self) -> Sequence[Process]:
        return [] if self._hub is None else [self._hub]

    def _make_gateway(self, name: str) -> Gateway:
        return Site(self._chance, self.server, self._disk, self._spools[name], name)

    def _trouble(self) -> list[Coroutine[Any, Any, None]]:
        return [*super()._trouble(), self._kill_hub(), self._cut()]

    async def _start_hub(self) -> None:
        self._hub = Hub(self._chance, self._hub_disk, self._spools["hub"], self._address)
        await self._hub.spawn(self._hub.start())

    def _address(self) -> TunnelAddress | None:
        """Return the address of the site's process; one that has just died is still believed to be there."""
        found = [each.address for each in self._gateways if isinstance(each, Site) and each.address is not None]
        return found[-1] if found else None

    async def _kill_hub(self) -> None:
        for _ in range(self._faults.kills):
            await asyncio.sleep(self._random.uniform(0.0, 1.5))
            assert self._hub is not None
            self._hub.kill()
            self.reader.move()
            await asyncio.sleep(self._random.uniform(0.0, 0.5))
            await self._start_hub()

    async def _cut(self) -> None:
        for _ in range(self._faults.cuts):
            await asyncio.sleep(self._random.uniform(0.0, 1.5))
            self.nats.cut(self._random.uniform(0.0, 1.0))
