"""A site's answers to stops and releases."""

from collections.abc import Iterable
from dataclasses import dataclass

from pydantic import BaseModel, StrictBool, ValidationError

from dock_gateway.sites.names import to_hub

# Characters of a sentence of a site.
MAX_DETAIL = 500
# Failures of a robot that has been sent zero velocity, or that is not there.
HARMLESS = frozenset({"robot_not_found", "latch_not_published"})


class SiteProblem(BaseModel):
    """The part of a problem of a site that the hub reads."""

    code: str
    detail: str


class SiteFailure(SiteProblem):
    """A part of a stop that failed."""

    action_name: str | None = None
    robot: str | None = None

    def at_hub(self, site: str) -> dict[str, str | None]:
        """Return it with names of the hub."""
        action, robot = (None if name is None else to_hub(site, name) for name in (self.action_name, self.robot))
        return {"action_name": action, "robot": robot, "code": self.code[:60], "detail": self.detail[:MAX_DETAIL]}


class SiteLatch(BaseModel):
    """The latch of a site."""

    latched: StrictBool
    robots: list[str]


class SiteReport(BaseModel):
    """The part of a stop report that the hub reads. Names are not checked: none keeps a stop unconfirmed."""

    canceling: list[str]
    failed: list[SiteFailure]
    unconfirmed: list[str]
    stopped: list[str]
    not_stopped: list[str]
    stop: SiteLatch
    warning: SiteProblem | None = None


@dataclass(frozen=True)
class StopOutcome:
    """What became of a stop at one site, as `POST /stop` answers it.

    Attributes:
        stopped: Whether the site has confirmed it.
        robots: The robots there that a stop holds, with names of the hub, as in the next ones.
        halted: The robots to which zero velocity was published.
        not_stopped: The other robots of the site.
        canceling: The goals that are being canceled.
        failed: The actions that refused that, and the robots to which zero velocity could not be published.
        unconfirmed: The actions that have not answered yet.
        warning: What the site has said besides.
        code: Why it is not confirmed, in a word.
        detail: The same in a sentence.
        repeated: Whether it is sent again until it is confirmed or released.
    """

    stopped: bool
    robots: tuple[str, ...] = ()
    halted: tuple[str, ...] = ()
    not_stopped: tuple[str, ...] = ()
    canceling: tuple[str, ...] = ()
    failed: tuple[dict[str, str | None], ...] = ()
    unconfirmed: tuple[str, ...] = ()
    warning: str | None = None
    code: str | None = None
    detail: str | None = None
    repeated: bool = False


@dataclass(frozen=True)
class ReleaseOutcome:
    """What became of a release at one site: `stopped_again`: a stop came while it waited."""

    released: bool
    code: str | None = None
    detail: str | None = None


def read_problem(body: bytes, status: int) -> tuple[str, str]:
    """Return the code and the sentence of a problem."""
    try:
        problem = SiteProblem.model_validate_json(body)
    except ValidationError:
        return "site_failed", f"the site has answered {status}"
    return problem.code[:60], problem.detail[:MAX_DETAIL]


def judge(name: str, body: bytes, *, latch: bool) -> StopOutcome:
    """Return what the report of a site says of a stop."""
    try:
        report = SiteReport.model_validate_json(body)
    except ValidationError:
        report = None
    if report is None or (latch and not report.stop.latched):
        detail = f"the site {name} has not said that the stop is latched"
        return StopOutcome(stopped=False, code="site_failed", detail=detail)
    moving = next((each for each in report.failed if each.robot and each.code not in HARMLESS), None)
    return StopOutcome(
        stopped=moving is None,
        robots=_names(name, report.stop.robots),
        halted=_names(name, report.stopped),
        not_stopped=_names(name, report.not_stopped),
        canceling=tuple(report.canceling),
        failed=tuple(each.at_hub(name) for each in report.failed),
        unconfirmed=_names(name, report.unconfirmed),
        warning=None if report.warning is None else report.warning.detail[:MAX_DETAIL],
        code=None if moving is None else moving.code,
        detail=None if moving is None else moving.detail[:MAX_DETAIL],
    )


def _names(site: str, names: Iterable[str]) -> tuple[str, ...]:
    return tuple(to_hub(site, name) for name in names)
