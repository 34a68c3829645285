"""The JSON shapes of stops of a hub."""

from datetime import datetime

from dock_gateway.http.schema import Problem, Schema
from dock_gateway.stop.schema import StopFailure, StopReport


class PendingStop(Schema):
    """A stop that a site has not confirmed: it is sent again until it is, or until it is released at the hub."""

    robots: list[str]
    by: str | None
    stopped_at: datetime


class StopAtSite(Schema):
    """What became of a stop at one site.

    `stopped` is true only if the site has confirmed it. `robots` lists those that it holds there, `halted` those to
    which zero velocity was published, `not_stopped` the others. `repeated`: it is sent again until it is confirmed or
    released.
    """

    stopped: bool
    robots: list[str]
    halted: list[str]
    not_stopped: list[str]
    canceling: list[str]
    failed: list[StopFailure]
    unconfirmed: list[str]
    warning: str | None
    code: str | None
    detail: str | None
    repeated: bool


class HubStopReport(StopReport):
    """A stop that every site has confirmed: as at a gateway, of all sites together, and of each in `sites`."""

    sites: dict[str, StopAtSite]


class HubStopProblem(Problem):
    """A stop that not every site has confirmed. `sites` says which have."""

    sites: dict[str, StopAtSite] | None = None
    warning: "Problem | None" = None


class ReleaseAtSite(Schema):
    """What became of a release at one site."""

    released: bool
    code: str | None
    detail: str | None


class HubReleaseReport(Schema):
    """A release that every site has carried out."""

    sites: dict[str, ReleaseAtSite]


class HubReleaseProblem(Problem):
    """A release that not every site has carried out. `sites` says which have."""

    sites: dict[str, ReleaseAtSite] | None = None
