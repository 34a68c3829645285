"""Knows the sites, and which process of each is welcome. Pure: hellos in, answers out; the caller has the clocks.

A site's name belongs to the installation that came first, until an admin forgets the site. One process of it is welcome
at a time: another one is, as soon as the first has left or was silent for `SILENT_AFTER` seconds.
"""

from collections import Counter, deque
from dataclasses import dataclass, field
from enum import StrEnum

from dock_gateway.sites.messages import Hello, Refusal, Welcome, compatible

# Seconds without a hello after which a site is unreachable, and another process of it is welcome.
SILENT_AFTER = 10.0
# Maximum number of sites, and of names whose refusals are counted.
MAX_SITES = 1000


class SiteState(StrEnum):
    """The state of a site."""

    CONNECTED = "connected"
    UNREACHABLE = "unreachable"
    REFUSED = "refused"


@dataclass
class Site:
    """A site, as its hellos describe it.

    Attributes:
        name: Its name.
        installation: The installation that has the name; None if none was welcome yet.
        since: When its state changed, in seconds since 1970.
        instance: The process that is welcome, or was last.
        version: Its release.
        machine: The name of its machine.
        heard_at: Time of that process's last hello, on the hub's monotonic clock; None: it has left or never came.
        clock_offset: Seconds that its clock is ahead of the hub's, as the fastest of the last hellos shows it.
        offsets: The same, as each of the last hellos shows it: less by what the hello took.
        refused: How many hellos were refused, by code.
        refused_at: When the last one was, on the monotonic clock.
        detail: Why that was.
    """

    name: str
    installation: str | None = None
    since: float = 0.0
    instance: str | None = None
    version: str | None = None
    machine: str = ""
    heard_at: float | None = None
    clock_offset: float = 0.0
    offsets: deque[float] = field(default_factory=lambda: deque(maxlen=5))
    refused: Counter[str] = field(default_factory=Counter)
    refused_at: float | None = None
    detail: str | None = None

    def note_offset(self, offset: float) -> None:
        """Take over what a hello shows of its clock. One that is far off shows that a clock was set."""
        self.offsets.append(offset)
        self.clock_offset = max(each for each in self.offsets if abs(each - offset) < SILENT_AFTER)

    def state(self, now: float) -> SiteState:
        """Return its state at a time on the monotonic clock."""
        if self.heard_at is not None and now - self.heard_at < SILENT_AFTER:
            return SiteState.CONNECTED
        if self.refused_at is not None and now - self.refused_at < SILENT_AFTER:
            return SiteState.REFUSED
        return SiteState.UNREACHABLE


class Directory:
    """The sites of a hub.

    Args:
        version: The hub's release.
        known: The installation of each site that is known from before.
    """

    def __init__(self, version: str, known: dict[str, str]) -> None:
        self._version = version
        self.sites = {name: Site(name, installation) for name, installation in known.items()}

    def judge(self, name: str, hello: Hello, now: float, wall: float) -> Welcome | Refusal:
        """Answer the hello of a site.

        Args:
            name: The site, from the subject.
            hello: What it says.
            now: Seconds on the monotonic clock.
            wall: Seconds since 1970.
        """
        site = self.sites.get(name)
        if site is None:
            if len(self.sites) >= MAX_SITES:
                return Refusal(code="limit_reached", detail=f"this hub has {MAX_SITES} sites already")
            site = self.sites[name] = Site(name, since=wall)
        installation = str(hello.installation)
        if site.installation not in (None, installation):
            return self._refuse(
                site,
                now,
                "site_name_taken",
                f"the name {name} belongs to another gateway; if that is gone, an admin can forget it with "
                f"DELETE /sites/{name}",
            )
        if not compatible(hello.version, self._version):
            return self._refuse(
                site,
                now,
                "version_refused",
                f"the gateway is {hello.version} and the hub {self._version}: they may be one minor release apart",
            )
        if hello.instance != site.instance and site.state(now) is SiteState.CONNECTED:
            return self._refuse(
                site,
                now,
                "site_connected_elsewhere",
                f"another process of {name} is connected; it was heard of {now - (site.heard_at or now):.0f} s ago",
            )
        if hello.leaving:
            self.lose(name, hello.instance, wall)
            return Welcome(hub_version=self._version, at=wall)
        if site.state(now) is not SiteState.CONNECTED or site.instance != hello.instance:
            site.since = wall
        site.installation, site.instance, site.heard_at = installation, hello.instance, now
        site.version, site.machine = hello.version, hello.name_of_machine
        site.note_offset(hello.at - wall)
        site.detail = site.refused_at = None
        return Welcome(hub_version=self._version, at=wall)

    def _refuse(self, site: Site, now: float, code: str, detail: str) -> Refusal:
        site.refused[code] += 1
        site.refused_at, site.detail = now, detail
        return Refusal(code=code, detail=detail)

    def count_malformed(self, name: str, code: str, detail: str) -> bool:
        """Count a message of a site that cannot be read; return whether the site is known."""
        site = self.sites.get(name)
        if site is not None:
            site.refused[code] += 1
            site.detail = detail
        return site is not None

    def lose(self, name: str, instance: str, wall: float) -> None:
        """Note that a process has left, or is gone for certain."""
        site = self.sites.get(name)
        if site is not None and site.instance == instance and site.heard_at is not None:
            site.heard_at, site.since = None, wall

    def welcome_instance(self, name: str, now: float) -> str | None:
        """Return the process of a site that is welcome now; None if there is none."""
        site = self.sites.get(name)
        return site.instance if site is not None and site.state(now) is SiteState.CONNECTED else None

    def forget(self, name: str) -> bool:
        """Forget a site and its installation; return whether it was known."""
        return self.sites.pop(name, None) is not None
