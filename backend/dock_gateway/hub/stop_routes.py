"""`/stop` of a hub: stops robots of any sites, and releases them. A stop is never said to be done before it is."""

import asyncio
from dataclasses import asdict
from typing import Any

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.audit.subjects import robots_text
from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import GatewayError, NotFound, ServerTimeout
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import principal_of
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import RobotQuery, RobotsQuery, json_response, known_query, read_json
from dock_gateway.hub.stop_outcomes import StopOutcome
from dock_gateway.hub.stop_requests import BODY_WITHIN, WHOLE
from dock_gateway.hub.stop_schema import HubReleaseReport, HubStopReport
from dock_gateway.hub.stops import Stops
from dock_gateway.sites.names import site_grant, to_site
from dock_gateway.stop.requests import STOP_REQUEST, noting, read_robots, read_stop, warning

router = APIRouter(tags=["Stop"])


@router.post(
    "/stop",
    response_model=HubStopReport,
    responses=problems(404, 422) | problems(504, schema="HubStopProblem"),
    openapi_extra=body(STOP_REQUEST, required=False),
)
@operation(Role.VIEWER, Scope.ANY, reads_body=True)
async def stop(request: Request, stops: Part[Stops], robot: RobotsQuery = None) -> Response:
    """Stop robots of any sites, each as `POST /stop` of its own site does; without `robot`, all robots of all sites.

    `robot` may be repeated. `/berlin` is all robots of the site `berlin`. The answer comes within 5 s. It is 200 only
    if every site has confirmed that its stop is latched; else `504 stop_incomplete`, whose `sites` say which have. A
    stop that is not confirmed is sent again whenever its site can be reached, until it is confirmed or released here.
    With `{"latch": false}` it is not sent again after the answer.

    A malformed request still stops robots, unless it is unclear which are meant. A body that is not there within 0.5 s
    is not read: where the query names no robot, all are stopped.
    """
    value: Any = {}
    wrong: list[GatewayError] = []
    with noting(wrong):
        value = await read_json(request, empty={}, within=BODY_WITHIN)
    robots = read_robots(request.query_params, value, wrong)
    if robots:
        audited(request, robot=robots_text(robots))
    principal = principal_of(request)
    how = read_stop(principal, value, wrong)
    targets, unknown = _targets(stops.sites(), robots, wrong)
    outcomes = await stops.stop(targets, **how, user=principal.name) | unknown
    return _answer(outcomes, how, wrong)


def _targets(
    sites: list[str], robots: list[str], wrong: list[GatewayError]
) -> tuple[dict[str, tuple[str, ...]], dict[str, StopOutcome]]:
    """Return the robots to stop of each site, by its own names, and what becomes of those of no site."""
    if not robots:
        if not sites:
            raise NotFound("there is no site", code="site_not_found")
        return dict.fromkeys(sites, (WHOLE,)), {}
    targets: dict[str, tuple[str, ...]] = {}
    unknown: dict[str, StopOutcome] = {}
    for robot in robots:
        with noting(wrong):
            name = read_namespace(f"/{robot.lstrip('/')}")
            site = name[1:].partition("/")[0]
            if name == "/":
                targets |= dict.fromkeys(sites, (WHOLE,))
            elif (own := to_site(site, name)) is not None and site in sites:
                targets[site] = (*targets.get(site, ()), own)
            else:
                detail = f"there is no site {site[:60]}"
                unknown[site[:60]] = StopOutcome(stopped=False, code="site_not_found", detail=detail)
    if not targets:
        raise wrong[0] if wrong else NotFound(f"there is no site {', '.join(unknown)}", code="site_not_found")
    return targets, unknown


def _answer(outcomes: dict[str, StopOutcome], how: dict[str, Any], wrong: list[GatewayError]) -> Response:
    sites = {name: asdict(outcome) for name, outcome in sorted(outcomes.items())}
    warned = warning(wrong) if wrong else None
    missed = {name: outcome for name, outcome in sorted(outcomes.items()) if not outcome.stopped}
    if not missed:
        held = [robot for outcome in outcomes.values() for robot in outcome.robots]
        stop = {"latched": how["latch"], "since": utc_now(), "by": how["by"], "robots": sorted(held), "persisted": True}
        every = {
            name: [each for outcome in outcomes.values() for each in getattr(outcome, name)]
            for name in ("canceling", "failed", "unconfirmed")
        }
        return json_response({**every, "stop": stop, "others": [], "warning": warned, "sites": sites})
    reasons = "; ".join(f"{name}: {outcome.detail}" for name, outcome in missed.items())
    raise ServerTimeout(
        f"the stop is not confirmed by {len(missed)} of {len(outcomes)} sites ({reasons}); use a robot's own emergency "
        "stop if it moves",
        code="stop_incomplete",
        sites=sites,
        warning=warned,
    )


@router.delete(
    "/stop",
    response_model=HubReleaseReport,
    responses=problems(404, 422, 503) | problems(504, schema="HubReleaseProblem"),
    dependencies=[Depends(known_query("robot"))],
)
@operation(Role.SUPERVISOR, Scope.ROBOTS, Audit.STORED_FIRST)
async def release_stop(request: Request, stops: Part[Stops], robot: RobotQuery = None) -> Response:
    """Release the stop of a robot, of all robots of a site (`/berlin`), or of all robots; it moves none.

    A stop that a site has not confirmed is dropped. The release is sent once to each site that can be reached, never
    later; the site decides whether the user may. `504 release_incomplete` names the sites that have not released it.
    """
    principal, sites = principal_of(request), stops.sites()
    name = "/" if robot is None else read_namespace(robot)
    if name == "/":
        targets = dict.fromkeys(sites, WHOLE)
    else:
        site = name[1:].partition("/")[0]
        if site not in sites:
            raise NotFound(f"there is no site {site[:60]}", code="site_not_found")
        targets = {site: to_site(site, name) or WHOLE}
    grants = {site: grant for site in targets if (grant := site_grant(principal.grant, site)) is not None}
    releases = [stops.release(site, targets[site], user=principal.name, grant=grants[site]) for site in grants]
    outcomes = dict(zip(grants, await asyncio.gather(*releases), strict=True))
    documents = {site: asdict(outcome) for site, outcome in outcomes.items()}
    missed = [f"{site}: {outcome.detail}" for site, outcome in outcomes.items() if not outcome.released]
    if missed:
        detail = f"{len(missed)} of {len(outcomes)} sites have not released it ({'; '.join(missed)})"
        raise ServerTimeout(detail, code="release_incomplete", sites=documents)
    return json_response({"sites": documents})
