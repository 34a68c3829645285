"""Connects a site to its hub: says hello, and serves the hub's requests with the gateway's own application."""

import asyncio
import contextlib
import logging
import platform
import time
import uuid
from collections.abc import Mapping
from contextlib import AsyncExitStack
from typing import Any

from starlette.types import ASGIApp

from dock_gateway import __version__
from dock_gateway.core.errors import GatewayError, Unavailable
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.sites.admission import HubAdmission
from dock_gateway.extensions.sites.installation import read_installation
from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.extensions.sites.settings import SiteSettings
from dock_gateway.observability.schema import HubState
from dock_gateway.sites import subjects
from dock_gateway.sites.broker import Broker, BrokerOptions, NoResponder, open_broker
from dock_gateway.sites.messages import Hello, Malformed, Refusal, Welcome, compatible, read_answer
from dock_gateway.sites.seals import KeyAgreement
from dock_gateway.sites.tunnel.caller import TunnelAddress
from dock_gateway.sites.tunnel.server import TunnelServer
from dock_gateway.storage import History

log = logging.getLogger(__name__)

# Seconds between two hellos, and for the answer to one.
INTERVAL, TIMEOUT = 3.0, 3.0
# Seconds without an answer after which the hub counts as not reachable; what it still asks is served.
PATIENCE = 10.0
# Seconds that an exit waits for the hub to hear of it.
FAREWELL = 1.0


class Uplink:
    """The connection of a site to its hub, from `open` until `close`.

    Args:
        settings: The settings of a site.
        history: Stores the id of the installation.
        link: Its state.

    Raises:
        KeyFault: The file with the hub's keys cannot be used.
    """

    def __init__(self, settings: SiteSettings, history: History, link: HubLink) -> None:
        self._options = BrokerOptions(
            urls=settings.nats,
            credentials=settings.nats_credentials,
            ca=settings.nats_ca,
            name=f"dock-gateway {settings.site}",
            inbox=subjects.inbox(settings.site),
        )
        self._history = history
        self._link = link
        self._served: tuple[ASGIApp, Mapping[str, Any]] | None = None
        self._address = TunnelAddress(settings.site, subjects.new_id())
        self._admission = HubAdmission(settings, self._address.instance, link)
        self._keys = KeyAgreement()
        self._agreed, self._key = "", b""  # with which process of the hub, and on what
        self._installation: uuid.UUID | None = None
        self._broker: Broker | None = None
        self._tunnel: TunnelServer | None = None
        self._answered_at = time.monotonic()
        self._awake = asyncio.Event()
        self._stack = AsyncExitStack()
        self._tasks = Tasks("saying hello to the hub")

    async def open(self, app: ASGIApp, state: Mapping[str, Any]) -> None:
        """Connect in the background, for ever.

        Args:
            app: The gateway's application.
            state: What the application's requests have as their state.
        """
        self._served = app, state
        self._broker = broker = await self._stack.enter_async_context(open_broker(self._options))
        self._link.refused = broker.refused
        self._stack.enter_context(broker.on_connect.adding(self._awake.set))
        self._stack.enter_context(broker.on_loss.adding(self._awake.set))
        self._tasks.spawn(self._run(broker))

    async def leave(self) -> None:
        """Tell the hub that this process ends. Streams go on until `close`."""
        await self._tasks.close()
        if self._broker is not None and self._link.state is HubState.CONNECTED:
            with contextlib.suppress(Unavailable, TimeoutError):
                await self._ask(self._broker, FAREWELL, leaving=True)

    async def close(self) -> None:
        """End the streams, and the connection."""
        await self._tasks.close()
        await self._end_tunnel()
        await self._stack.aclose()

    def document(self) -> dict[str, Any]:
        """Return its state, as `/healthz` shows it."""
        return self._link.document()

    async def _run(self, broker: Broker) -> None:
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(INTERVAL):
                    await self._awake.wait()  # the connection to the broker has come, or is lost
            self._awake.clear()
            try:
                answer = read_answer(await self._ask(broker, TIMEOUT))
            except NoResponder:
                self._miss("hub_not_there", "no hub is connected to the NATS server")
            except TimeoutError:
                self._miss("hub_silent", "the hub does not answer")
            except Unavailable as error:
                self._link.lose(error.code, error.detail)
            except Malformed as error:
                self._miss(error.reason, f"the answer of the hub cannot be read: {error.detail}")
            else:
                self._answered_at = time.monotonic()
                await self._follow(broker, answer)

    async def _ask(self, broker: Broker, timeout: float, *, leaving: bool = False) -> bytes:
        if self._installation is None:
            self._installation = await read_installation(self._history)
        hello = Hello(
            installation=self._installation,
            instance=self._address.instance,
            version=__version__,
            at=time.time(),
            leaving=leaving,
            name_of_machine=platform.node(),
            public=self._keys.public,
            agreed=self._agreed,
        )
        return await broker.request(subjects.hello(self._address.site), hello.encode(), timeout)

    def _miss(self, code: str, detail: str) -> None:
        """Note that a hello was not answered. One alone may be lost."""
        if self._link.state is not HubState.CONNECTED or time.monotonic() - self._answered_at >= PATIENCE:
            self._link.lose(code, detail)

    async def _follow(self, broker: Broker, answer: Welcome | Refusal) -> None:
        """Serve the hub while this site is welcome."""
        if isinstance(answer, Welcome) and not compatible(__version__, answer.hub_version):
            detail = (
                f"the hub is {answer.hub_version} and this gateway {__version__}; at most one minor release apart works"
            )
            answer = Refusal(code="version_refused", detail=detail)
        if isinstance(answer, Refusal):
            await self._end_tunnel()
            self._link.refuse(answer.code, answer.detail)
            return
        if self._tunnel is None:
            assert self._served is not None
            app, state = self._served
            self._tunnel = TunnelServer(broker, self._address, app, self._admission, state)
            await self._tunnel.open()
        self._agree(answer)
        self._tunnel.key = self._key or None
        self._link.connected(answer.hub_version)

    def _agree(self, answer: Welcome) -> None:
        """Agree on a key with a process of the hub; until then, what it sends waits with what others send."""
        if answer.public in ("", self._agreed):
            return
        if not answer.proof:
            self._agreed = ""
            self._awake.set()  # the next hello asks for it
            return
        try:
            self._admission.confirm(answer.proof, self._keys.public, answer.public)
            self._key = self._keys.agree(answer.public, self._address.site, self._address.instance)
        except (GatewayError, ValueError) as error:
            log.info("there is no key for the messages of the hub: %s", error)
        else:
            self._agreed = answer.public

    async def _end_tunnel(self) -> None:
        tunnel, self._tunnel = self._tunnel, None
        if tunnel is not None:
            await tunnel.close()
