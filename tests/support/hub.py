"""A small hub: it welcomes a site, and asks it as a hub does."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from typing import Any

from dock_gateway import __version__
from dock_gateway.core.grant import Grant, Role
from dock_gateway.sites import subjects
from dock_gateway.sites.broker import Broker, BrokerOptions, open_broker
from dock_gateway.sites.identity import Signer
from dock_gateway.sites.messages import Hello, Refusal, Welcome, read
from dock_gateway.sites.subscription import SiteMessage
from dock_gateway.sites.tunnel.answer import TunnelAnswer
from dock_gateway.sites.tunnel.caller import Caller, TunnelAddress
from dock_gateway.sites.tunnel.conversation import Conversation
from dock_gateway.sites.tunnel.failures import SiteUnreachable
from tests.support.waiting import PATIENCE, until

OPERATOR = Grant(Role.OPERATOR)


class SmallHub:
    """A hub for one site.

    Args:
        broker: The connection to the broker.
        signer: Its key.
        site: The site.

    Attributes:
        late: Seconds that its clock is behind that of this machine.
        hellos: What the site has said.
        refusal: What it is answered; None: welcome.
    """

    def __init__(self, broker: Broker, signer: Signer, site: str) -> None:
        self.broker = broker
        self.site = site
        self.late = 0.0
        self.hellos: list[Hello] = []
        self.refusal: Refusal | None = None
        self.caller = Caller(broker)
        self.signer = signer
        self._heard_at = 0.0

    async def open(self) -> None:
        await self.caller.open()
        await self.broker.subscribe(subjects.HELLOS, self._answer)

    def clock(self) -> float:
        return time.time() - self.late

    async def _answer(self, received: SiteMessage) -> None:
        hello, site = read(Hello, received.data), subjects.read_hello(received.subject)
        if site != self.site:
            return
        self._heard_at = time.time()
        await received.reply((self.refusal or Welcome(hub_version=__version__, at=self.clock())).encode())
        self.hellos.append(hello)

    async def wait_for_site(self) -> None:
        """Wait until the site has said hello, and serves it."""
        before = len(self.hellos)
        await until(lambda: len(self.hellos) > before)
        while True:
            with suppress(SiteUnreachable):  # it has not read the welcome yet
                await self.request("GET", "/session")
                return
            await asyncio.sleep(0.02)

    @property
    def address(self) -> TunnelAddress:
        return TunnelAddress(self.site, self.hellos[-1].instance)

    def sign(
        self,
        method: str,
        path: str,
        name: str | None = "alice",
        grant: Grant = OPERATOR,
        *,
        query: str = "",
        body: bytes = b"",
        corrected: bool = True,
    ) -> str:
        offset = self.hellos[-1].at - (self._heard_at - self.late)  # of the site's clock, as the hello has shown it
        now = self.clock() + (offset if corrected else 0.0)
        content = self.caller.content_of(query, body)
        return self.signer.sign(self.site, self.address.instance, name, grant, method, path, now, content=content)

    async def request(
        self, method: str, path: str, *, token: str | None = None, deadline: float = PATIENCE, **said: Any
    ) -> TunnelAnswer:
        """Ask the site; `said` goes to `sign`."""
        query = path.partition("?")[2]
        path = path.partition("?")[0]
        token = token or self.sign(method, path, query=query, **said)
        return await self.caller.request(self.address, method, path, token=token, query=query, deadline=deadline)

    def websocket(self, path: str, query: str = "", **said: Any) -> AbstractAsyncContextManager[Conversation]:
        token = self.sign("GET", path, query=query, **said)
        return self.caller.websocket(self.address, path, token=token, query=query)


@asynccontextmanager
async def small_hub(url: str, signer: Signer, site: str = "berlin") -> AsyncIterator[SmallHub]:
    """A hub on a broker."""
    options = BrokerOptions((url,), None, None, "hub", subjects.inbox(subjects.HUB))
    async with open_broker(options) as broker:
        hub = SmallHub(broker, signer, site)
        await until(lambda: broker.connected)
        await hub.open()
        try:
            yield hub
        finally:
            await hub.caller.close()
