"""A site's answers to stops and releases."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

from pydantic import BaseModel, StrictBool, ValidationError

from dock_gateway.core.errors import GatewayError
from dock_gateway.sites.messages import Refusal
from dock_gateway.sites.names import to_hub
from dock_gateway.sites.tunnel.failures import SiteFailed, refused
from dock_gateway.stop.stop_report import together

# Characters of a sentence of a site.
MAX_DETAIL = 500
# Failures of a robot that has been sent zero velocity, or that is not there.
HARMLESS = frozenset({"robot_not_found", "latch_not_published"})
# The code of a stop that a restart would lose.
NOT_PERSISTED = "stop_not_persisted"


class SiteProblem(BaseModel):
    """The part of a problem of a site that the hub reads."""

    code: str
    detail: str
    status: int = 500

    def about(self, site: str) -> Self:
        """Return it with the name of the site in the sentence."""
        return self.model_copy(update={"detail": f"{site}: {self.detail}"})

    def error(self, site: str) -> GatewayError:
        """Return it as an error of the hub."""
        code, detail = self.code[:60] or "site_failed", self.detail[:MAX_DETAIL]
        return refused(site, Refusal.model_construct(code=code, detail=detail, status=self.status))


class SiteFailure(BaseModel):
    """A part of a stop that failed."""

    action_name: str | None = None
    robot: str | None = None
    code: str
    detail: str

    def at_hub(self, site: str) -> Self:
        """Return it with names of the hub."""
        action, robot = (None if name is None else to_hub(site, name) for name in (self.action_name, self.robot))
        short = {"code": self.code[:60], "detail": self.detail[:MAX_DETAIL]}
        return self.model_copy(update={"action_name": action, "robot": robot, **short})


class StoppedRobot(BaseModel, frozen=True):
    """A robot of a site that is stopped."""

    robot: str
    stopped_at: str
    by: str | None = None


class SiteLatch(BaseModel, frozen=True):
    """The latched stops of a site."""

    latched: StrictBool
    for_all: StrictBool
    stopped_at: str | None = None
    by: str | None = None
    robots: list[str]
    stops: list[StoppedRobot]
    persisted: StrictBool

    def at_hub(self, site: str) -> Self:
        """Return it with names of the hub."""
        stops = [each.model_copy(update={"robot": to_hub(site, each.robot)}) for each in self.stops]
        return self.model_copy(update={"robots": _names(site, self.robots), "stops": stops})


class OtherGateway(BaseModel):
    """Another gateway of a site, and the patterns of the robots that it serves; none: every robot."""

    host: str
    address: str | None = None
    robots: list[str]

    def at_hub(self, site: str) -> Self:
        """Return it with names of the hub."""
        return self.model_copy(update={"robots": _names(site, self.robots or ["/", "/*"])})


class SiteReport(BaseModel, frozen=True):
    """The part of a stop report that the hub reads. Names are not checked: none keeps a stop unconfirmed."""

    stopped: list[str]
    not_stopped: list[str]
    canceling: list[str]
    failed: list[SiteFailure]
    unconfirmed: list[str]
    stop: SiteLatch
    others: list[OtherGateway]
    warning: SiteProblem | None = None

    def at_hub(self, site: str) -> Self:
        """Return it with names of the hub."""
        renamed = {name: _names(site, getattr(self, name)) for name in ("stopped", "not_stopped", "unconfirmed")}
        listed = {name: [each.at_hub(site) for each in getattr(self, name)] for name in ("failed", "others")}
        return self.model_copy(update={**renamed, **listed, "stop": self.stop.at_hub(site)})


NOT_LATCHED = SiteLatch(latched=False, for_all=False, robots=[], stops=[], persisted=True)
NO_REPORT = SiteReport(
    stopped=[],
    not_stopped=[],
    canceling=[],
    failed=[],
    unconfirmed=[],
    stop=NOT_LATCHED,
    others=[],
)


@dataclass(frozen=True)
class StopOutcome:
    """What became of a stop at one site.

    Attributes:
        stopped: Whether the site has confirmed it.
        report: Its report, with names of the hub; an empty one if there is none that can be relied on.
        warning: What in the request the site could not understand, or what a restart would lose.
        code: Why it is not confirmed, in a word.
        detail: The same in a sentence.
        repeated: Whether it is sent again until it is confirmed or released.
    """

    stopped: bool
    report: SiteReport = NO_REPORT
    warning: GatewayError | None = None
    code: str | None = None
    detail: str | None = None
    repeated: bool = False

    def document(self) -> dict[str, Any]:
        """Return it as `sites` of `POST /stop` has it."""
        warning = None if self.warning is None else self.warning.detail
        document = {"stopped": self.stopped, "code": self.code, "detail": self.detail}
        return document | {"warning": warning, "repeated": self.repeated}


def read_problem(site: str, body: bytes, status: int) -> GatewayError:
    """Return the problem that a site has answered with as an error of the hub."""
    try:
        problem = SiteProblem.model_validate_json(body)
    except ValidationError:
        return SiteFailed(f"the site {site} has answered {status}", site=site)
    return problem.model_copy(update={"status": status}).error(site)


def read_latch(site: str, body: bytes) -> SiteLatch:
    """Return the latch of a robot of a site, with names of the hub.

    Raises:
        SiteFailed: The answer is none.
    """
    try:
        return SiteLatch.model_validate_json(body).at_hub(site)
    except ValidationError:
        raise SiteFailed(f"the site {site} has not said whether a stop is latched", site=site) from None


def judge(site: str, body: bytes, *, latch: bool) -> StopOutcome:
    """Return what the report of a site says of a stop."""
    try:
        report = SiteReport.model_validate_json(body)
    except ValidationError:
        report = None
    if report is None or (latch and not report.stop.for_all):
        detail = f"the site {site} has not said that the stop is latched"
        return StopOutcome(stopped=False, code="site_failed", detail=detail)
    moving = next((each for each in report.failed if each.robot and each.code not in HARMLESS), None)
    return StopOutcome(
        stopped=moving is None,
        report=report.at_hub(site),
        warning=None if report.warning is None else report.warning.about(site).error(site),
        code=None if moving is None else moving.code[:60],
        detail=None if moving is None else moving.detail[:MAX_DETAIL],
    )


def report_of_all(outcomes: Mapping[str, StopOutcome], robots: Iterable[str]) -> dict[str, Any]:
    """Return what became of a stop at several sites as one report, as a gateway makes it.

    Args:
        outcomes: What became of it at each site.
        robots: The robots of all sites. Those that no site reports as stopped are `not_stopped`.
    """
    reports = [outcome.report for outcome in outcomes.values()]
    stopped = {robot for report in reports for robot in report.stopped}
    known = {*robots, *(robot for report in reports for robot in report.not_stopped)}
    silent = [
        {"action_name": None, "robot": f"/{site}", "code": outcome.code, "detail": outcome.detail}
        for site, outcome in outcomes.items()
        if not outcome.stopped and not outcome.report.failed
    ]
    stop = together([report.stop.model_dump() for report in reports])
    unsaved = any(each.warning is not None and each.warning.code == NOT_PERSISTED for each in outcomes.values())
    return {
        "stopped": sorted(stopped),
        "not_stopped": sorted(known - stopped),
        "canceling": [goal_id for report in reports for goal_id in report.canceling],
        "failed": [each.model_dump() for report in reports for each in report.failed] + silent,
        "unconfirmed": [name for report in reports for name in report.unconfirmed],
        "stop": stop | {"persisted": stop["persisted"] and not unsaved},
        "others": [each.model_dump() for report in reports for each in report.others],
    }


def _names(site: str, names: Iterable[str]) -> list[str]:
    return [to_hub(site, name) for name in names]
