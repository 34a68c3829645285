"""One request to stop robots of a site, or to release them."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime
from http import HTTPStatus
from typing import Protocol
from urllib.parse import urlencode

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.filters import is_under
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Grant, Role
from dock_hub.site_client import JSON, SiteRequest
from dock_hub.stop_outcomes import SiteLatch, StopOutcome, judge, read_latch, read_problem

# All robots of a site.
WHOLE = "/"
# Seconds that a stop waits for the rest of its request: who made it, for example.
BODY_WITHIN = 0.5
# Characters of the robots that a stop of a site names. For more, the whole site is stopped.
MAX_QUERY = 60_000
# Everyone may stop every robot.
STOPS_ALL = Grant(Role.VIEWER)
# So may who sees no robot of a site; no name on the ROS graph begins with a digit.
STOPS_UNSEEN = Grant(Role.VIEWER, robots=("/0",))
# Answers of a site that will not change: it does not know the robot, or does not let the hub do it.
FINAL = frozenset({400, 403, 404, 405, 409, 421, 422})


class SiteAnswer(Protocol):
    """The answer of a site."""

    @property
    def status(self) -> int:
        """The status."""

    @property
    def body(self) -> bytes:
        """The body."""


class SiteApi(Protocol):
    """The API of a site."""

    async def ask(self, request: SiteRequest) -> SiteAnswer:
        """Make a request.

        Raises:
            GatewayError: There is no answer.
        """


class ReachableSites(Protocol):
    """The part of the sites that stops need."""

    def names(self) -> list[str]:
        """Return the names of all sites, sorted."""

    def client(self, name: str) -> SiteApi:
        """Return the API of a site.

        Raises:
            GatewayError: It is not connected, or there is no such site.
        """


@dataclass(frozen=True)
class StopEntry:
    """A stop that a site has not confirmed, as stored.

    Attributes:
        robots: The robots, by the site's own names; `/` is all of them.
        user: The user of the hub who asked for it.
        by: Who stopped them, as the request says.
        stopped_at: When it was asked for first.
    """

    robots: tuple[str, ...]
    user: str | None
    by: str | None
    stopped_at: datetime

    def join(self, later: "StopEntry") -> "StopEntry":
        """Return one stop for both."""
        return replace(later, robots=outermost((*self.robots, *later.robots)), stopped_at=self.stopped_at)


@dataclass(frozen=True)
class StopOptions:
    """How robots are stopped.

    Attributes:
        latch: Whether goals are refused until the stop is released.
        wait: Seconds that a site may wait for its action servers to answer.
    """

    latch: bool = True
    wait: float = 0.0


REPEATED = StopOptions()


class SiteStopper:
    """Asks sites.

    Args:
        sites: The sites.
        deadline: Seconds that a site may take. It does not begin later.
    """

    def __init__(self, sites: ReachableSites, deadline: float) -> None:
        self._sites = sites
        self._deadline = deadline

    def is_connected(self, name: str) -> bool:
        """Return whether a site can be asked."""
        try:
            self._sites.client(name)
        except GatewayError:
            return False
        return True

    async def stop(self, name: str, entry: StopEntry, options: StopOptions) -> tuple[bool, StopOutcome]:
        """Send a stop. Return whether there is no use in another attempt, and what became of it."""
        body = encode({"latch": options.latch, "by": entry.by})
        query = urlencode([("robot", robot) for robot in entry.robots])
        if len(query) > MAX_QUERY:  # the site would refuse it
            query = urlencode({"robot": WHOLE})
        headers = [*JSON, (b"prefer", f"wait={options.wait:.0f}".encode())]
        request = SiteRequest("POST", "/stop", query, body, entry.user, STOPS_ALL, headers, self._deadline)
        try:
            answer = await self._sites.client(name).ask(request)
        except GatewayError as error:
            return False, StopOutcome(stopped=False, code=error.code, detail=error.detail)
        if answer.status != HTTPStatus.OK:
            problem = read_problem(name, answer.body, answer.status)
            return answer.status in FINAL, StopOutcome(stopped=False, code=problem.code, detail=problem.detail)
        outcome = judge(name, answer.body, latch=options.latch)
        return outcome.stopped, outcome

    async def ask(self, method: str, name: str, robot: str, user: str | None, grant: Grant) -> SiteLatch:
        """Return the latch of a robot, with GET; release it before, with DELETE.

        Raises:
            GatewayError: The site has refused it, or there is no answer.
        """
        query = urlencode({"robot": robot})
        request = SiteRequest(method, "/stop", query, user=user, grant=grant, deadline=self._deadline)
        answer = await self._sites.client(name).ask(request)
        if answer.status != HTTPStatus.OK:
            raise read_problem(name, answer.body, answer.status)
        return read_latch(name, answer.body)


def outermost(robots: Iterable[str]) -> tuple[str, ...]:
    """Return robots, sorted, without those below others."""
    names = sorted(set(robots))
    return tuple(name for name in names if not any(name != other and is_under(name, other) for other in names))
