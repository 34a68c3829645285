"""The sites of this hub: which are welcome, the latest report of each, and how each is reached."""

import asyncio
import logging
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from typing import Any

from dock_gateway import __version__
from dock_gateway.core.errors import NotFound, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.tasks import Tasks
from dock_gateway.sites import subjects
from dock_gateway.sites.broker import Broker, NoResponder
from dock_gateway.sites.identity import AGREEMENT, Signer
from dock_gateway.sites.messages import Hello, Malformed, Refusal, Welcome, read
from dock_gateway.sites.names import site_grant
from dock_gateway.sites.seals import KeyAgreement
from dock_gateway.sites.subscription import SiteMessage
from dock_gateway.sites.tunnel.caller import Caller, TunnelAddress
from dock_gateway.sites.tunnel.failures import SiteUnreachable
from dock_gateway.storage import History
from dock_hub.directory import Directory, Site, SiteState
from dock_hub.follower import Follower
from dock_hub.site_client import READER, SiteClient
from dock_hub.site_view import SiteView
from dock_hub.store import HubStore

log = logging.getLogger(__name__)

# Seconds between two checks for silent sites.
CHECK_INTERVAL = 0.5
# Seconds that the process of a site may take to show that it is there.
PROBE_TIMEOUT = 1.0
# Hellos that are being answered, and those of one site in a second. More are dropped unread: each comes again.
MAX_HELLOS, MAX_HELLOS_OF_SITE = 1000, 10


@dataclass(frozen=True)
class SiteEntry:
    """A site, as stored.

    Attributes:
        installation: The installation that has the name.
        first_seen_at: When it came first.
    """

    installation: str
    first_seen_at: datetime


class Sites:
    """All sites.

    Args:
        broker: Carries hellos.
        caller: Sends requests to sites.
        signer: Signs who makes them.
        history: Stores which sites there are, and their goals.
        store: Takes what they report.

    Attributes:
        on_connect: Called with the name of a site that is welcome from now on.
        pending_stop: Returns the stop that a site has not confirmed, as `GET /sites` shows it.
    """

    def __init__(self, broker: Broker, caller: Caller, signer: Signer, history: History, store: HubStore) -> None:
        self._broker = broker
        self._caller = caller
        self._signer = signer
        self._keys = KeyAgreement()
        self._agreed: dict[str, tuple[TunnelAddress, str]] = {}  # by site: its process, and the public key of that
        self._history = history
        self._entries = history.documents("site", SiteEntry)
        self._store = store
        self._directory = Directory(__version__, {})
        self._stored: set[str] = set()
        self._views: dict[str, SiteView] = {}
        self._followers: dict[str, tuple[str, Follower]] = {}
        self._states: dict[str, SiteState] = {}
        self._quiet_since: dict[str, float] = {}
        self._refusals: dict[str, tuple[str, str]] = {}
        self._tasks = Tasks("checking sites")
        self._hellos = Tasks("answering hellos")
        self._second, self._heard = 0, Counter[str]()  # hellos of each site in this second
        self._following = asyncio.Lock()
        self.on_connect = Listeners[[str]]("a site is welcome")
        self.pending_stop: Callable[[str], dict[str, Any] | None] = lambda _: None

    async def open(self) -> None:
        """Read which sites are known, and answer hellos from now on."""
        self._tasks.spawn(self._check())
        await self._read_known()
        await self._broker.subscribe(subjects.HELLOS, self._on_hello)

    async def _read_known(self) -> None:
        """Read the sites. No one is welcome before: another installation could take a name."""
        while True:
            try:
                known = await self._entries.read()
            except Unavailable as error:
                log.warning("%s; no site is welcome until it does", error.detail)
                await asyncio.sleep(CHECK_INTERVAL)
            else:
                break
        self._directory = Directory(__version__, {name: entry.installation for name, entry in known.items()})
        self._stored = set(known)
        now, wall = time.monotonic(), time.time()
        for name, site in self._directory.sites.items():
            site.since, self._quiet_since[name], self._states[name] = wall, now, SiteState.UNREACHABLE

    async def close(self) -> None:
        """Follow no site any longer."""
        await self._hellos.close()
        await self._tasks.close()
        for _, follower in self._followers.values():
            await follower.close()

    # ------------------------------------------------------------------ hellos

    async def _on_hello(self, received: SiteMessage) -> None:
        name = subjects.read_hello(received.subject)
        if name is None:
            self._broker.refuse("foreign_subject", received.subject, "a site cannot have that name")
            return
        if self._says_too_much(name):
            self._broker.refuse("too_many_hellos", received.subject, "a site says hello too often")
            return
        try:
            hello = read(Hello, received.data)
        except Malformed as error:
            if not self._directory.count_malformed(name, error.reason, error.detail):
                self._broker.refuse(error.reason, received.subject, error.detail)
            await received.reply(Refusal(code=error.reason, detail=error.detail).encode())
            return
        if len(self._hellos) < MAX_HELLOS:
            self._hellos.spawn(self._answer(name, hello, received))

    def _says_too_much(self, name: str) -> bool:
        if (second := int(time.monotonic())) != self._second:
            self._second = second
            self._heard.clear()
        self._heard[name] += 1
        return self._heard[name] > MAX_HELLOS_OF_SITE

    async def _answer(self, name: str, hello: Hello, received: SiteMessage) -> None:
        answer = self._judge(name, hello)
        if isinstance(answer, Refusal) and answer.code == "site_connected_elsewhere" and await self._is_gone(name):
            answer = self._judge(name, hello)
        if isinstance(answer, Welcome) and not await self._is_stored(name, hello):
            answer = Refusal(code="hub_unavailable", detail="the hub's database does not answer")
        if isinstance(answer, Refusal) and self._refusals.get(name) != (said := (hello.instance, answer.code)):
            self._refusals[name] = said  # once, not with each hello
            log.warning("refused the site %s on %s: %s", name, hello.name_of_machine or "?", answer.detail)
        if isinstance(answer, Welcome) and hello.public and not hello.leaving:
            answer = self._agree(name, hello, answer)
        await received.reply(answer.encode())
        if isinstance(answer, Welcome):
            await self._follow(name)

    def _agree(self, name: str, hello: Hello, welcome: Welcome) -> Welcome:
        """Agree on a key for the requests to a process of a site; return the welcome that contains it."""
        address = TunnelAddress(name, hello.instance)
        if self._agreed.get(name) != (address, hello.public):
            try:
                key = self._keys.agree(hello.public, name, hello.instance)
            except ValueError as error:
                log.info("there is no key for requests to the site %s: %s", name, error)
                return welcome
            self._forget_key(name)
            self._agreed[name], self._caller.keys[address] = (address, hello.public), key
        public, proof = self._keys.public, ""
        if hello.agreed != public:
            said = name, hello.instance, None, READER, AGREEMENT, public, self._clock_of(name)
            proof = self._signer.sign(*said, content=hello.public)
        return welcome.model_copy(update={"public": public, "proof": proof})

    def _forget_key(self, name: str) -> None:
        address, _ = self._agreed.pop(name, (None, ""))
        if address is not None:
            del self._caller.keys[address]

    def _judge(self, name: str, hello: Hello) -> Welcome | Refusal:
        return self._directory.judge(name, hello, time.monotonic(), time.time())

    async def _is_gone(self, name: str) -> bool:
        """Return whether the welcome process is certainly gone: its subject has no subscriber."""
        instance = self._directory.welcome_instance(name, time.monotonic())
        if instance is None:
            return True
        try:
            await self._broker.request(subjects.open_stream(name, instance), b"", PROBE_TIMEOUT)
        except NoResponder:
            self._directory.lose(name, instance, time.time())
            return True
        except (Unavailable, TimeoutError):
            return False
        return False

    async def _is_stored(self, name: str, hello: Hello) -> bool:
        """Store whose name it is, before the first one of that name is welcome."""
        if name in self._stored:
            return True
        try:
            await self._entries.write(name, SiteEntry(str(hello.installation), utc_now()))
        except Unavailable:
            self._directory.forget(name)
            return False
        self._stored.add(name)
        return True

    async def _follow(self, name: str) -> None:
        """Follow the process of a site that is welcome, instead of an earlier one."""
        self._quiet_since[name] = time.monotonic()
        async with self._following:
            instance = self._directory.welcome_instance(name, time.monotonic())
            if instance is None or instance != self._followers.get(name, ("", None))[0]:
                await self._leave(name)
            if instance is not None and name not in self._followers:
                self._start_following(name, instance)

    def _start_following(self, name: str, instance: str) -> None:
        log.info("the site %s is connected", name)
        client = self._client_of(name, instance)
        follower = Follower(client, self.view(name), self._store, self._history, self._store.mirror)
        self._followers[name] = instance, follower
        self.on_connect(name)

    async def _leave(self, name: str) -> None:
        _, follower = self._followers.pop(name, (None, None))
        if follower is not None:
            log.info("the site %s is no longer connected", name)
            await follower.close()

    async def _check(self) -> None:
        """Leave sites that are silent, and forget those that never were welcome."""
        while True:
            await asyncio.sleep(CHECK_INTERVAL)
            now = time.monotonic()
            for name, site in list(self._directory.sites.items()):
                state = site.state(now)
                if state is not self._states.get(name):
                    self._states[name], site.since = state, time.time()
                    self.view(name).touch()
                if state is not SiteState.CONNECTED:
                    await self._leave(name)
                if state is SiteState.UNREACHABLE and site.installation is None:
                    self._directory.forget(name)
                    self._forget_view(name)

    # ------------------------------------------------------------------ what is known

    def names(self, grant: Grant = UNLIMITED) -> list[str]:
        """Return the names of all sites with a robot that a grant covers, sorted."""
        return sorted(name for name in self._directory.sites if site_grant(grant, name) is not None)

    def find(self, name: str, grant: Grant = UNLIMITED) -> Site:
        """Return a site.

        Raises:
            NotFound: There is none of that name, or the grant covers none of its robots (`site_not_found`).
        """
        site = self._directory.sites.get(name)
        if site is None or site_grant(grant, name) is None:
            raise NotFound(f"there is no site {name[:60]}", code="site_not_found")
        return site

    def view(self, name: str) -> SiteView:
        """Return the latest report of a site."""
        return self._views.setdefault(name, SiteView(name))

    def views(self) -> list[SiteView]:
        """Return the latest reports of all sites."""
        return [self.view(name) for name in self._directory.sites]

    def namespaces(self) -> list[str]:
        """Return the namespaces of the robots of all sites, sorted."""
        return sorted(name for view in self.views() for name in view.robots)

    def state(self, name: str) -> SiteState:
        """Return the state of a site that is known."""
        return self._directory.sites[name].state(time.monotonic())

    def count(self) -> dict[str, int]:
        """Return the number of sites in each state."""
        states = [self.state(name) for name in self._directory.sites]
        return {state.value: states.count(state) for state in SiteState}

    def silent_for(self, name: str) -> float:
        """Return the seconds since the last hello of a site, or since the hub's start if there was none."""
        return time.monotonic() - self._quiet_since.get(name, time.monotonic())

    def refused(self) -> dict[str, int]:
        """Return the number of messages of sites that were refused, by code."""
        counts = sum((site.refused for site in self._directory.sites.values()), self._broker.refused.copy())
        return dict(sum((view.malformed for view in self._views.values()), counts))

    def document(self, name: str, grant: Grant = UNLIMITED) -> dict[str, Any]:
        """Return a site as `GET /sites` shows it.

        Raises:
            NotFound: `site_not_found`.
        """
        site, view, now = self.find(name, grant), self.view(name), time.monotonic()
        stopped = [*filter(grant.covers_robot, view.stopped())]
        return {
            "name": name,
            "state": site.state(now),
            "changed_at": datetime.fromtimestamp(site.since, UTC),
            "version": site.version,
            "instance": site.instance,
            "machine": site.machine,
            "lag_ms": None if view.reported_at is None else round((now - view.reported_at) * 1000),
            "round_trip_ms": None if view.round_trip is None else round(view.round_trip * 1000, 1),
            "clock_offset_s": None if site.version is None else round(site.clock_offset, 3),
            "cursor": view.cursor,
            "behind": view.behind,
            "robots": len(view.robots),
            "goals_running": view.goals_running(),
            "alerts": len(view.alerts),
            "stop": {"latched": bool(stopped), "robots": stopped, "pending": self.pending_stop(name)},
            "refused": dict(site.refused + view.malformed),
            "detail": site.detail or view.trouble,
        }

    # ------------------------------------------------------------------ requests

    def client(self, name: str, grant: Grant = UNLIMITED) -> SiteClient:
        """Return the API of a site.

        Raises:
            NotFound: `site_not_found`.
            SiteUnreachable: It is not connected (`site_unreachable`).
        """
        self.find(name, grant)
        instance = self._directory.welcome_instance(name, time.monotonic())
        if instance is None:
            raise SiteUnreachable(name, "it was not heard of for 10 s, or has left")
        return self._client_of(name, instance)

    def _client_of(self, name: str, instance: str) -> SiteClient:
        return SiteClient(self._caller, self._signer, TunnelAddress(name, instance), partial(self._clock_of, name))

    def _clock_of(self, name: str) -> float:
        site = self._directory.sites.get(name)
        return time.time() + (0.0 if site is None else site.clock_offset)

    async def forget(self, name: str) -> None:
        """Forget a site, and that its name belongs to an installation. Its goals stay.

        Raises:
            NotFound: `site_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """
        self.find(name)
        await self._entries.write(name, None)
        self._directory.forget(name)
        self._stored.discard(name)
        await self._leave(name)
        await self._store.mirror.forget(name)
        self._forget_view(name)

    def _forget_view(self, name: str) -> None:
        self._views.pop(name, None)
        self._refusals.pop(name, None)
        self._states.pop(name, None)
        self._quiet_since.pop(name, None)
        self._forget_key(name)

    def read_again(self) -> None:
        """Follow all sites from the beginning: the hub's database has lost what it had."""
        self._stored.clear()
        for name in list(self._followers):
            self._tasks.spawn(self._leave(name))
