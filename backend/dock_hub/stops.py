"""Stops of sites, and their release.

A stop is sent at once, and counts as done only when the site has said that it is latched. Until then it is stored and
sent again whenever the site can be reached, also by the next process of the hub. A release drops it; it is sent once,
and never later. No release is sent while a stop is on its way to the same site, and a stop that met a release on its
way is sent again: so the last of both that was asked for is what holds.
"""

import asyncio
import logging
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.filters import is_under
from dock_gateway.core.grant import Grant
from dock_gateway.core.tasks import Tasks
from dock_gateway.sites.names import to_hub
from dock_gateway.storage import Entries
from dock_hub.stop_outcomes import NOT_PERSISTED, SiteLatch, StopOutcome
from dock_hub.stop_requests import REPEATED, ReachableSites, SiteStopper, StopEntry, StopOptions, outermost

log = logging.getLogger(__name__)

NOT_STORED = "the hub's database does not answer: if the hub restarts now, it will not repeat this stop"


@dataclass(frozen=True)
class StopTimes:
    """Times in seconds.

    Attributes:
        answer_within: Time that an answer waits for the sites.
        deadline: Time that a site may take. It does not begin later.
        longest_wait: Time that a site may wait for its action servers, so that its answer is here before that.
        repeat_after: Time between two attempts.
    """

    answer_within: float = 5.0
    deadline: float = 5.0
    longest_wait: float = 3.0
    repeat_after: float = 0.5


@dataclass(eq=False)
class _Site:
    """The requests that are on their way to one site.

    Attributes:
        entry: The stop that it has not confirmed.
        unsaved: Whether the database may have another one.
        stops: Number of stops that were asked for.
        sending: The stops that are on their way.
        release: The release that is on its way.
    """

    entry: StopEntry | None = None
    unsaved: bool = False
    stops: int = 0
    sending: set[asyncio.Task[StopOutcome]] = field(default_factory=set)
    release: asyncio.Task[SiteLatch] | None = None
    saving: asyncio.Lock = field(default_factory=asyncio.Lock)


class Stops:
    """Stops sites, and releases them.

    Args:
        sites: The sites.
        store: Has the stops that are not confirmed, by site.
        times: How long to wait.
    """

    def __init__(self, sites: ReachableSites, store: Entries[StopEntry], times: StopTimes = StopTimes()) -> None:
        self._reach = sites
        self._stopper = SiteStopper(sites, times.deadline)
        self._store = store
        self._times = times
        self._sites: dict[str, _Site] = {}
        self._read = False
        self._wanted = asyncio.Event()  # something is to be repeated or stored
        self._tasks = Tasks("stopping sites")

    def open(self) -> None:
        """Read the stops that the last process of the hub has left, and repeat what is not confirmed from now on."""
        self._tasks.spawn(self._run())

    @property
    def ready(self) -> bool:
        """Whether the stops that the last process has left are known."""
        return self._read

    async def close(self) -> None:
        """Send nothing any longer."""
        await self._tasks.close()

    def sites(self) -> list[str]:
        """Return the names of all sites, sorted."""
        return self._reach.names()

    def pending(self, name: str) -> dict[str, Any] | None:
        """Return the stop that a site has not confirmed, as `GET /sites` shows it; None if there is none."""
        entry = self._site(name).entry
        if entry is None:
            return None
        return {
            "robots": [to_hub(name, robot) for robot in entry.robots],
            "by": entry.by,
            "stopped_at": entry.stopped_at,
        }

    async def forget(self, name: str) -> None:
        """Drop the stop that a site has not confirmed.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        site = self._site(name)
        site.entry, site.unsaved = None, True
        await self._save(name, site)

    def _site(self, name: str) -> _Site:
        return self._sites.setdefault(name, _Site())

    # ------------------------------------------------------------------ stops

    async def stop(
        self, targets: Mapping[str, tuple[str, ...]], options: StopOptions, *, by: str | None, user: str | None
    ) -> dict[str, StopOutcome]:
        """Stop robots of sites, all at the same time. What is not confirmed by then is repeated, if it is latched.

        Args:
            targets: The robots of each site, by its own names; `/` is all of them.
            options: How.
            by: Who stops them.
            user: The user of the hub who asks.
        """
        now, until = utc_now(), time.monotonic() + self._times.answer_within
        options = replace(options, wait=min(options.wait, self._times.longest_wait))
        sending = {
            name: self._begin(name, StopEntry(outermost(robots), user, by, now), options)
            for name, robots in targets.items()
        }
        if sending:
            await asyncio.wait(sending.values(), timeout=self._times.answer_within)
        await self._stored(targets, until)
        outcomes = {name: self._outcome(name, task, latch=options.latch) for name, task in sending.items()}
        for name, outcome in outcomes.items():
            if outcome.repeated:
                log.warning("the site %s has not confirmed a stop, which is repeated: %s", name, outcome.detail)
        return outcomes

    async def _stored(self, names: Iterable[str], until: float) -> None:
        """Wait until what is not confirmed is stored; as short as that takes, if it does not work."""
        saving = [self._tasks.spawn(self._save(name, site)) for name in names if (site := self._site(name)).entry]
        if saving:
            await asyncio.wait(saving, timeout=max(0.1, until - time.monotonic()))

    def _begin(self, name: str, entry: StopEntry, options: StopOptions) -> "asyncio.Task[StopOutcome]":
        site = self._site(name)
        site.stops += 1
        if options.latch:
            site.entry = entry = entry if site.entry is None else site.entry.join(entry)
            site.unsaved = True
            self._tasks.spawn(self._save(name, site))
            self._wanted.set()
        return self._send(name, site, entry, options)

    def _outcome(self, name: str, task: "asyncio.Task[StopOutcome]", *, latch: bool) -> StopOutcome:
        if task.done() and task.exception() is None:
            outcome = task.result()
        else:
            seconds = f"{self._times.answer_within:g} s"
            detail = f"the site {name} has not confirmed the stop within {seconds}; whether it has stopped is not known"
            outcome = StopOutcome(stopped=False, code="site_timeout", detail=detail)
        if outcome.stopped or not latch or self._site(name).entry is None:
            return outcome
        unsaved = Unavailable(NOT_STORED, code=NOT_PERSISTED) if self._site(name).unsaved else outcome.warning
        return replace(outcome, repeated=True, warning=unsaved)

    def _send(self, name: str, site: _Site, entry: StopEntry, options: StopOptions) -> "asyncio.Task[StopOutcome]":
        task = self._tasks.spawn(self._confirm(name, site, entry, options))
        site.sending.add(task)
        task.add_done_callback(site.sending.discard)
        return task

    async def _confirm(self, name: str, site: _Site, entry: StopEntry, options: StopOptions) -> StopOutcome:
        """Send a stop; once more, if a release was on its way, which could come after it."""
        release = site.release
        final, outcome = await self._insist(name, entry, options)
        if release is not None:
            await asyncio.wait({release})
            final, outcome = await self._insist(name, entry, options)
        if final and options.latch and site.entry is entry:
            site.entry, site.unsaved = None, True
            self._tasks.spawn(self._save(name, site))
            if outcome.stopped:
                log.info("the site %s has confirmed the stop", name)
            else:
                log.warning("the site %s refuses a stop: %s", name, outcome.detail)
        return outcome

    async def _insist(self, name: str, entry: StopEntry, options: StopOptions) -> tuple[bool, StopOutcome]:
        """Send a stop until that is of no use or the site is gone: it may only just have connected."""
        until = time.monotonic() + self._times.answer_within
        while True:
            final, outcome = await self._stopper.stop(name, entry, options)
            dropped = options.latch and self._site(name).entry is None
            if final or dropped or not self._stopper.is_connected(name):
                return final, outcome
            if time.monotonic() + self._times.repeat_after >= until:
                return final, outcome
            await asyncio.sleep(self._times.repeat_after)

    # ------------------------------------------------------------------ releases

    async def state(self, name: str, robot: str, user: str | None, grant: Grant) -> SiteLatch:
        """Return the latch of a robot of a site; arguments as `release`.

        Raises:
            GatewayError: The site knows no such robot, or there is no answer.
        """
        return await self._stopper.ask("GET", name, robot, user, grant)

    async def release(self, name: str, robot: str, user: str | None, grant: Grant) -> SiteLatch:
        """Release the stop of robots of a site: drop what is not confirmed, and ask the site once.

        Args:
            name: The site.
            robot: The robot, by the site's own name; those below it are released, too.
            user: The user of the hub who asks.
            grant: What they may do at the site.

        Returns:
            The latch that the robot has at the site now.

        Raises:
            Unavailable: What is not confirmed cannot be dropped, as the database does not answer
                (`history_unavailable`). Nothing is released then.
            Conflict: More robots are stopped (`stop_latched`), or a stop came meanwhile (`stopped_again`).
            GatewayError: The site has not released it, or there is no answer.
        """
        site = self._site(name)
        stops = site.stops
        await self._drop(name, site, robot)
        while on_their_way := {*site.sending, *([] if site.release is None else [site.release])}:
            await asyncio.wait(on_their_way)
        if site.stops != stops:
            raise Conflict(f"a stop of the site {name} was asked for meanwhile; it holds", code="stopped_again")
        site.release = task = self._tasks.spawn(self._stopper.ask("DELETE", name, robot, user, grant))
        task.add_done_callback(lambda _: setattr(site, "release", None))
        return await asyncio.shield(task)

    async def _drop(self, name: str, site: _Site, robot: str) -> None:
        if not self._read:
            raise Unavailable("the stops that are not confirmed are not read yet", code="history_unavailable")
        entry = site.entry
        if entry is not None:
            if any(is_under(robot, each) and each != robot for each in entry.robots):
                detail = f"a stop of more than {to_hub(name, robot)} is not confirmed yet; release that one"
                raise Conflict(detail, code="stop_latched")
            rest = tuple(each for each in entry.robots if not is_under(each, robot))
            if rest != entry.robots:
                site.entry, site.unsaved = (replace(entry, robots=rest) if rest else None), True
        if site.unsaved:
            try:
                await self._save(name, site)
            except Unavailable:
                if entry is not None:  # it will be repeated, as before
                    site.entry = entry if site.entry is None else entry.join(site.entry)
                raise

    # ------------------------------------------------------------------ what is not confirmed

    async def _run(self) -> None:
        await self._read_stored()
        while True:
            await self._wanted.wait()
            self._wanted.clear()
            for name, site in list(self._sites.items()):
                if site.entry is not None and not site.sending:
                    self._send(name, site, site.entry, REPEATED)
                if site.unsaved and not site.saving.locked():
                    self._tasks.spawn(self._save(name, site))
                if site.entry is not None or site.unsaved:
                    self._wanted.set()
            await asyncio.sleep(self._times.repeat_after)

    async def _read_stored(self) -> None:
        while not self._read:
            try:
                stored = await self._store.read()
            except Unavailable as error:
                log.warning("%s; stops of an earlier process are repeated when it does", error.detail)
                await asyncio.sleep(self._times.repeat_after)
                continue
            for name, entry in stored.items():
                site = self._site(name)
                site.entry = entry if site.entry is None else entry.join(site.entry)
                log.warning("the stop of the site %s since %s is not confirmed; it is repeated", name, entry.stopped_at)
            self._read = True
            self._wanted.set()

    async def _save(self, name: str, site: _Site) -> None:
        """Store what a site has not confirmed.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`). It is tried again.
        """
        async with site.saving:
            if not (self._read and site.unsaved):  # what the last process has left is read first
                return
            entry = site.entry
            await self._store.write(name, entry)
            if site.entry is entry:
                site.unsaved = False
