"""The JSON shapes of stops of a hub: those of a gateway, with what each site has answered."""

from datetime import datetime

from dock_gateway.http.schema import Problem, Schema
from dock_gateway.stop.schema import LatchedStops, StopProblem, StopReport


class PendingStop(Schema):
    """A stop that a site has not confirmed: it is sent again until it is, or until it is released at the hub."""

    robots: list[str]
    by: str | None
    stopped_at: datetime


class StopAtSite(Schema):
    """What became of a stop at one site.

    `stopped` is true only if the site has confirmed it; if not, `code` and `detail` say why. `repeated`: it is sent
    again until it is confirmed or released.
    """

    stopped: bool
    code: str | None
    detail: str | None
    warning: str | None
    repeated: bool


class HubStopReport(StopReport):
    """A stop that every site has confirmed: the report of a gateway, for all sites together. `sites` has each."""

    sites: dict[str, StopAtSite]


class HubStopProblem(StopProblem):
    """A stop that not every site has confirmed. `sites` says which have; the report says what is known to be done.

    Robots of a site that has not confirmed it are in `not_stopped`, and the site is in `failed`.
    """

    sites: dict[str, StopAtSite] | None = None
    warning: Problem | None = None


class ReleaseAtSite(Schema):
    """What became of a release at one site."""

    released: bool
    code: str | None
    detail: str | None


class HubStopState(LatchedStops):
    """The stops of all robots that were released together, after a release that every site has carried out."""

    sites: dict[str, ReleaseAtSite]


class HubReleaseProblem(Problem):
    """A release that not every site has carried out. `sites` says which have."""

    sites: dict[str, ReleaseAtSite] | None = None
