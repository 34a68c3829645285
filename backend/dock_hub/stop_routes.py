"""`/stop` of a hub: stops robots of any sites, and releases them. A stop is never said to be done before it is."""

import asyncio
from collections.abc import Awaitable, Callable, Iterable
from typing import Any

from fastapi import APIRouter, Request

from dock_gateway.audit.subjects import robots_text
from dock_gateway.audit.trail import audited
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError, NotFound, ServerTimeout, not_covered
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import principal_of
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    Answer,
    AnyRobotQuery,
    BelowQuery,
    RobotsQuery,
    json_response,
    read_json,
    read_wait,
)
from dock_gateway.http.route import ApiRoute
from dock_gateway.sites.names import site_grant, to_site
from dock_gateway.stop.order import PREFER, STOP_REQUEST, noting, read_order, releases_stop, stops_robots
from dock_gateway.stop.schema import LatchedStops
from dock_gateway.stop.stop_report import narrow_report, together
from dock_hub.overview import Overview
from dock_hub.stop_outcomes import NOT_LATCHED, SiteLatch, StopOutcome, report_of_all
from dock_hub.stop_requests import BODY_WITHIN, WHOLE, StopOptions
from dock_hub.stop_schema import HubStopReport, HubStopState
from dock_hub.stops import Stops

router = APIRouter(route_class=ApiRoute, tags=["Stop"])

# Asks a site about a robot by its own name, for a user with a grant there.
AskSite = Callable[[str, str, str | None, Grant], Awaitable[SiteLatch]]


@router.get("/stop")
@operation(Role.VIEWER, Scope.LISTED, errors=(404, 504))
async def get_stop(request: Request, stops: Part[Stops], robot: AnyRobotQuery = None) -> Answer[LatchedStops]:
    """Return which robots are stopped: a robot and those below it, those of a site (`/berlin`), or all.

    Each site is asked. Without `robot`, no robot of a site that does not answer counts as stopped.
    """
    answers = await _ask_sites(principal_of(request), stops.sites(), robot, stops.state)
    return json_response(together([_latch(answer) for answer in answers.values()]))


@router.post(
    "/stop",
    responses=problems(404) | problems(504, schema="HubStopProblem"),
    openapi_extra={**body(STOP_REQUEST, required=False), "parameters": PREFER},
)
@stops_robots
async def stop(
    request: Request, stops: Part[Stops], overview: Part[Overview], robot: RobotsQuery = None
) -> Answer[HubStopReport]:
    """Stop robots of any sites, each as `POST /stop` of its own site does; without `robot`, all robots of all sites.

    `robot` may be repeated. `/berlin` is all robots of the site `berlin`. The answer comes within 5 s. It is 200 only
    if every site has confirmed that its stop is latched; else `504 stop_incomplete`, whose `sites` say which have. A
    stop that is not confirmed is sent again whenever its site can be reached, until it is confirmed or released here.
    With `{"latch": false}` it is not sent again after the answer. `Prefer: wait=2` lets the sites wait up to 2 s for
    their action servers, and 3 s at most.

    A malformed request stops robots, too: those that it clearly names, all if that is not clear or none is of a site.
    A body that is not there within 0.5 s is not read.
    """
    value: Any
    wait = 0.0
    wrong: list[GatewayError] = []
    try:
        value = await read_json(request, empty={}, within=BODY_WITHIN)
    except GatewayError as error:
        value = error
    with noting(wrong):
        wait = read_wait(request)
    principal = principal_of(request)
    order = read_order(principal, value, query=request.query_params, wrong=wrong)
    audited(request, robot=robots_text(order.robots))
    targets, unknown = _targets(stops.sites(), order.robots)
    problems: list[GatewayError] = []
    if not targets:
        detail = f"there is no site {', '.join(unknown)}: all sites are asked to stop"
        problems.append(NotFound(detail, code="site_not_found"))
        targets, unknown = dict.fromkeys(stops.sites(), (WHOLE,)), {}
        audited(request, robot=WHOLE)
    outcomes = await stops.stop(targets, StopOptions(order.latch, wait), by=order.by, user=principal.name) | unknown
    problems += [outcome.warning for outcome in outcomes.values() if outcome.warning is not None]
    report = narrow_report(report_of_all(outcomes, overview.namespaces()), principal.grant)
    report |= {
        "warning": order.warning(*problems),
        "sites": {name: outcome.document() for name, outcome in sorted(outcomes.items())},
    }
    if missed := [f"{name}: {each.detail}" for name, each in sorted(outcomes.items()) if not each.stopped]:
        raise ServerTimeout(
            f"the stop is not confirmed by {len(missed)} of {len(outcomes)} sites ({'; '.join(missed)}); use a robot's "
            "own emergency stop if it moves",
            code="stop_incomplete",
            **report,
        )
    return json_response(report)


def _targets(sites: list[str], robots: Iterable[str]) -> tuple[dict[str, tuple[str, ...]], dict[str, StopOutcome]]:
    """Return the robots to stop of each site, by its own names, and what becomes of those of no site.

    Raises:
        NotFound: There is no site (`site_not_found`).
    """
    if not sites:
        raise NotFound("there is no site", code="site_not_found")
    targets: dict[str, tuple[str, ...]] = {}
    unknown: dict[str, StopOutcome] = {}
    for name in robots:
        site = name[1:].partition("/")[0]
        if name == WHOLE:
            targets |= dict.fromkeys(sites, (WHOLE,))
        elif (own := to_site(site, name)) is not None and site in sites:
            targets[site] = (*targets.get(site, ()), own)
        else:
            detail = f"there is no site {site[:60]}"
            unknown[site[:60]] = StopOutcome(stopped=False, code="site_not_found", detail=detail)
    return targets, unknown


@router.delete("/stop", responses=problems(409) | problems(504, schema="HubReleaseProblem"))
@releases_stop
async def release_stop(request: Request, stops: Part[Stops], robot: BelowQuery = None) -> Answer[HubStopState]:
    """Release the stop of a robot, of all robots of a site (`/berlin`), or of all robots; it moves none.

    A stop that a site has not confirmed is dropped. The release is sent once to each site that can be reached, never
    later; the site decides whether the user may. `504 release_incomplete` names the sites that have not released it.
    For one site, the error is that of the site.
    """
    answers = await _ask_sites(principal_of(request), stops.sites(), robot, stops.release)
    documents = {site: _released(answer) for site, answer in answers.items()}
    if missed := {site: error for site, error in answers.items() if isinstance(error, GatewayError)}:
        reasons = "; ".join(f"{site}: {error.detail}" for site, error in missed.items())
        detail = f"{len(missed)} of {len(answers)} sites have not released it ({reasons})"
        raise ServerTimeout(detail, code="release_incomplete", sites=documents)
    return json_response(together([_latch(answer) for answer in answers.values()]) | {"sites": documents})


async def _ask_sites(
    principal: Principal, sites: list[str], robot: str | None, ask: AskSite
) -> dict[str, SiteLatch | GatewayError]:
    """Ask the site of a robot, or all sites without one; return the latch at each, or why that is not known.

    Raises:
        NotFound: There is no such site (`site_not_found`).
        GatewayError: The only site that was asked has failed.
    """
    name = WHOLE if robot is None else read_namespace(robot)
    own = dict.fromkeys(sites, WHOLE)
    if name != WHOLE:
        site = name[1:].partition("/")[0]
        if site not in own:
            raise NotFound(f"there is no site {site[:60]}", code="site_not_found")
        own = {site: to_site(site, name) or WHOLE}

    async def ask_one(site: str, grant: Grant) -> SiteLatch | GatewayError:
        try:
            return await ask(site, own[site], principal.name, grant)
        except GatewayError as error:
            if name != WHOLE:
                raise
            return error

    grants = {site: grant for site in own if (grant := site_grant(principal.grant, site)) is not None}
    if not grants and name != WHOLE:
        raise not_covered(f"the robot {name}")
    return dict(zip(grants, await asyncio.gather(*map(ask_one, grants, grants.values())), strict=True))


def _latch(answer: SiteLatch | GatewayError) -> dict[str, Any]:
    return (NOT_LATCHED if isinstance(answer, GatewayError) else answer).model_dump()


def _released(answer: SiteLatch | GatewayError) -> dict[str, Any]:
    if isinstance(answer, GatewayError):
        return {"released": False, "code": answer.code, "detail": answer.detail}
    return {"released": True, "code": None, "detail": None}
