"""The claims of the gateways on one database: each says which robots it serves, and no two say the same ones."""

import asyncio
import logging
import secrets
import time
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from dock_gateway import __version__
from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.share import Claim, Share, compete
from dock_gateway.core.tasks import Tasks
from dock_gateway.gateways.machine import boot_id, host_name
from dock_gateway.storage import Entries

log = logging.getLogger(__name__)

# Seconds between two times that a claim is stored.
BEAT = 2.0
# Seconds after which a claim that is not stored again is no longer valid.
EXPIRY = 10.0
# Seconds at shutdown for giving it up.
CLOSE_WITHIN = 0.5


class Gateways:
    """This gateway's claim, and those of the others.

    Whether another gateway still runs is seen from its counter, not from its clock: it has to change. While the
    database is away, everything goes on as before.

    Args:
        store: Stores the claims.
        share: The robots that this gateway serves.
        address: Where this gateway will listen; empty if that is not known yet.
        shared: Whether other gateways may use the same database. If not, nothing is stored.
        beat: See `BEAT`.
        expiry: See `EXPIRY`.

    Attributes:
        id: A random id of this process.
        robots: Returns the namespaces of the robots that were found.
        conflict: Which other gateway has claimed robots of this one, in a sentence; None if no one has.
    """

    def __init__(
        self,
        store: Entries[Claim],
        share: Share,
        address: str = "",
        *,
        shared: bool,
        beat: float = BEAT,
        expiry: float = EXPIRY,
    ) -> None:
        self.id = secrets.token_hex(8)
        self.robots: Callable[[], Collection[str]] = tuple
        self.conflict: str | None = None
        self._store = store
        self._shared = shared
        self._beat = beat
        self._expiry = expiry
        now = utc_now()
        self._own = Claim(
            host_name(), boot_id(), address, share.patterns, (), __version__, now, now, 0, claimed=not shared
        )
        self._known: Mapping[str, Claim] = {}
        self._seen: dict[str, tuple[int, float]] = {}  # the counter of each, and since when, on the monotonic clock
        self._beating: set[str] = set()  # those whose counter has changed
        self._tasks = Tasks("claiming robots")
        share.others = self.others

    def listen(self, address: str) -> None:
        """Set where this gateway listens, and let the others know."""
        news = address != self._own.address
        self._own = replace(self._own, address=address)
        if self._shared and news:
            self._tasks.spawn(self.renew())

    async def open(self) -> None:
        """Claim the robots, and keep the claim.

        Another claim of the same robots is waited for until it is clear whether its gateway still runs.

        Raises:
            Conflict: `robots_claimed`: it does.
        """
        if not self._shared:
            return
        try:
            while not await self._claim():
                rival = self._known[str(self._rival(self._known))]
                log.warning("%s serves %s: looking whether it still runs", rival.where, rival.what)
                await asyncio.sleep(self._beat / 2)
        except Unavailable:
            log.warning("the database does not answer: which gateways serve which robots is not known yet")
        self._tasks.spawn(self._run())

    async def _claim(self) -> bool:
        """Claim the robots; return False if it is not known yet whether another gateway that has them still runs.

        Raises:
            Conflict: `robots_claimed`: it does.
            Unavailable: The database does not answer (`history_unavailable`).
        """
        await self._read()
        if (rival := self._rival(self._known)) is not None:
            if rival not in self._beating:
                return False
            raise _claimed(self._own, self._known[rival])

        def check(claims: Mapping[str, Claim]) -> None:
            running = {key: claim for key, claim in claims.items() if not self._is_over(key, claim)}
            if (first := self._rival(running)) is not None:
                raise _claimed(self._own, claims[first])

        await self._put(claimed=True, check=check)
        return True

    async def _put(self, *, claimed: bool, check: Callable[[Mapping[str, Claim]], None] | None = None) -> None:
        own, robots = self._own, tuple(sorted(self.robots()))
        self._own = replace(own, beat=own.beat + 1, seen_at=utc_now(), serves=robots, claimed=claimed)
        await self._store.write(self.id, self._own, check)

    async def _read(self) -> None:
        """Read the claims, and forget those of gateways that have ended.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        try:
            claims = await self._store.read()
        except Unavailable:
            self._seen.clear()  # what was not read may have changed
            raise
        now = time.monotonic()
        for key, claim in claims.items():
            beat, _ = self._seen.get(key, (claim.beat, now))
            if beat != claim.beat:
                self._beating.add(key)
            if beat != claim.beat or key not in self._seen:
                self._seen[key] = claim.beat, now
        self._known = {key: claim for key, claim in claims.items() if key != self.id and not self._is_over(key, claim)}
        for key in claims.keys() - self._known.keys() - {self.id}:
            await self._forget(key, claims[key])

    def _is_over(self, key: str, claim: Claim) -> bool:
        if self._own.replaces(claim):
            return True
        beat, since = self._seen.get(key, (claim.beat, time.monotonic()))
        return beat == claim.beat and time.monotonic() - since >= self._expiry

    async def _forget(self, key: str, over: Claim) -> None:
        def check(claims: Mapping[str, Claim]) -> None:
            if claims.get(key) != over:
                raise Conflict("it is back")

        with suppress(Conflict):
            await self._store.write(key, None, check)
            log.info("%s has ended without a word: its claim is removed", over.where)

    def _rival(self, claims: Mapping[str, Claim]) -> str | None:
        """Return the id of a gateway that serves robots of this one, by claims that are not over."""
        return next(
            (
                key
                for key, claim in claims.items()
                if key != self.id and claim.claimed and compete(self._own.robots, claim.robots)
            ),
            None,
        )

    async def _run(self) -> None:
        while True:
            await asyncio.sleep(self._beat)
            try:
                await self.renew()
            except Exception:
                log.exception("while claiming robots")

    async def renew(self) -> None:
        """Store the claim again, and read those of the others.

        A gateway that was cut off from the database for long may find its robots claimed by another one. It goes on
        serving them: that harms no robot, as gateways on one database share goals and stops. It says so until one of
        the two has ended.
        """
        try:
            try:
                conflict = None if await self._claim() else self.conflict
            except Conflict as error:
                conflict = error.detail
                await self._put(claimed=False)
        except Unavailable:
            return
        if conflict is not None and self.conflict is None:
            log.error("%s; both go on serving them", conflict)
        elif conflict is None and self.conflict is not None:
            log.warning("no other gateway serves the same robots any longer")
        self.conflict = conflict

    def others(self) -> list[Claim]:
        """Return the claims of the other gateways that run."""
        return [claim for _, claim in self._sorted()]

    def _sorted(self) -> list[tuple[str, Claim]]:
        return sorted(self._known.items(), key=lambda item: (item[1].robots, item[1].host, item[1].address))

    def document(self) -> dict[str, Any]:
        """Return the gateways that run as `GET /gateways` shows them, this one first."""
        own = replace(self._own, serves=tuple(sorted(self.robots())), seen_at=utc_now())
        every = ((self.id, own), *self._sorted())
        return {
            "gateways": [_document(key, claim, this=key == self.id) for key, claim in every],
            "shared": self._shared,
            "conflict": self.conflict,
        }

    async def close(self) -> None:
        """Give the claim up."""
        await self._tasks.close()
        if self._shared:
            with suppress(Unavailable, TimeoutError):
                async with asyncio.timeout(CLOSE_WITHIN):
                    await self._store.write(self.id, None)


def _claimed(own: Claim, other: Claim) -> Conflict:
    detail = (
        f"{other.where} serves {other.what} on this database, and this gateway is to serve {own.what}: no two gateways "
        "may serve the same robots, unless all of them serve every robot"
    )
    return Conflict(detail, code="robots_claimed")


def _document(key: str, claim: Claim, *, this: bool) -> dict[str, Any]:
    fields = vars(claim) | {"id": key, "this": this, "address": claim.address or None}
    return {name: value for name, value in fields.items() if name not in ("beat", "boot")}
