"""One life of a hub: it follows a site, stores what that tells, and publishes what is new."""

import asyncio
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from dock_gateway.core.fanout import Fanout
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from dock_gateway.sites.broker import Broker
from dock_gateway.sites.subjects import HUB
from dock_gateway.sites.tunnel.caller import Caller, TunnelAddress
from dock_gateway.storage import History
from dock_gateway.streams.current_state import CurrentState
from dock_hub.follower import Follower
from dock_hub.mirror import Mirror
from dock_hub.site_client import SiteClient
from dock_hub.site_view import SiteView
from dock_hub.store import HubStore
from tests.dock_gateway.simulation.chance import Chance
from tests.dock_gateway.simulation.database import Disk, SimulatedDatabase, SimulatedSpool
from tests.dock_gateway.simulation.gateway import FOREVER, GoalsOnly
from tests.dock_gateway.simulation.process import Process
from tests.dock_gateway.simulation.site import SITE, options_of

HELLO = 0.5  # seconds until a hub knows of a new process of a site, at most


class Hub(Process):
    """One life of a hub.

    Args:
        chance: The network and the dice.
        disk: Its database.
        spool: Its spool.
        address: Returns where the site is now; None while it is not there.
    """

    def __init__(
        self, chance: Chance, disk: Disk, spool: dict[int, list[bytes]], address: Callable[[], TunnelAddress | None]
    ) -> None:
        super().__init__(chance, "hub")
        self._disk = disk
        self._spool = spool
        self._address = address
        self.view = SiteView(SITE)

    async def start(self) -> None:
        spool: Any = SimulatedSpool(self._spool)
        database = SimulatedDatabase(self._disk, self, self.chance.database_delay, shared=False)
        with patch("dock_gateway.storage.history.open_database", lambda _: database):
            history = History("", spool, max_waiting=1000, limits=FOREVER)
        await history.open()
        self.fanout = Fanout(queue_limit=1000, newest=history.newest)
        settings = SimpleNamespace(heartbeat_interval=3600.0)
        self.parts = Parts(
            {Fanout: self.fanout, History: history, Settings: settings, CurrentState: GoalsOnly(history)}
        )
        broker = Broker(options_of(HUB))
        self.spawn(broker.run())
        caller = Caller(broker)
        await caller.open()
        self.spawn(self._follow(caller, history))
        self.ready = True
        self.chance.say(self.name, "ready")

    async def _follow(self, caller: Caller, history: History) -> None:
        store, view = HubStore(Mirror(history), self.fanout), self.view
        signer: Any = SimpleNamespace(sign=lambda *_, **__: "")
        follower, at = None, None
        while True:
            if at != (address := self._address()):
                at = address
                if follower is not None:
                    await follower.close()
                    follower = None
                if address is not None:
                    client = SiteClient(caller, signer, address, time.time)
                    follower = Follower(client, view, store, history, Mirror(history))
            await asyncio.sleep(self.chance.random.uniform(0.0, HELLO))
