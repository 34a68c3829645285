"""`/stop` of a hub: stops robots of any sites, and releases them. A stop is never said to be done before it is."""

import asyncio
from collections.abc import Iterable
from dataclasses import asdict, replace
from typing import Any

from fastapi import APIRouter, Request

from dock_gateway.audit.subjects import robots_text
from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import GatewayError, NotFound, ServerTimeout
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant
from dock_gateway.core.namespace import read_namespace
from dock_gateway.http.openapi import body
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import principal_of
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import Answer, BelowQuery, RobotsQuery, json_response, read_json
from dock_gateway.http.route import ApiRoute
from dock_gateway.sites.names import site_grant, to_site
from dock_gateway.stop.order import STOP_REQUEST, StopOrder, read_order, releases_stop, stops_robots
from dock_hub.stop_outcomes import StopOutcome
from dock_hub.stop_requests import BODY_WITHIN, WHOLE
from dock_hub.stop_schema import HubReleaseReport, HubStopReport
from dock_hub.stops import Stops

router = APIRouter(route_class=ApiRoute, tags=["Stop"])


@router.post(
    "/stop",
    responses=problems(404) | problems(504, schema="HubStopProblem"),
    openapi_extra=body(STOP_REQUEST, required=False),
)
@stops_robots
async def stop(request: Request, stops: Part[Stops], robot: RobotsQuery = None) -> Answer[HubStopReport]:
    """Stop robots of any sites, each as `POST /stop` of its own site does; without `robot`, all robots of all sites.

    `robot` may be repeated. `/berlin` is all robots of the site `berlin`. The answer comes within 5 s. It is 200 only
    if every site has confirmed that its stop is latched; else `504 stop_incomplete`, whose `sites` say which have. A
    stop that is not confirmed is sent again whenever its site can be reached, until it is confirmed or released here.
    With `{"latch": false}` it is not sent again after the answer.

    A malformed request stops robots, too: those that it clearly names, all if that is not clear or none is of a site.
    A body that is not there within 0.5 s is not read.
    """
    value: Any
    try:
        value = await read_json(request, empty={}, within=BODY_WITHIN)
    except GatewayError as error:
        value = error
    principal = principal_of(request)
    order = read_order(principal, value, query=request.query_params)
    audited(request, robot=robots_text(order.robots))
    targets, unknown = _targets(stops.sites(), order.robots)
    problems = []
    if not targets:
        detail = f"there is no site {', '.join(unknown)}: all sites are asked to stop"
        problems.append(NotFound(detail, code="site_not_found"))
        targets = dict.fromkeys(stops.sites(), (WHOLE,))
        audited(request, robot=WHOLE)
    stopped = await stops.stop(targets, latch=order.latch, by=order.by, user=principal.name)
    outcomes = {name: _narrowed(outcome, principal.grant) for name, outcome in stopped.items()}
    return _answer({**outcomes, **unknown} if not problems else outcomes, order, order.warning(*problems))


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


def _narrowed(outcome: StopOutcome, grant: Grant) -> StopOutcome:
    """Return an outcome with the robots of a grant, as a gateway answers."""
    halted, not_stopped = (tuple(filter(grant.covers_robot, each)) for each in (outcome.halted, outcome.not_stopped))
    return replace(outcome, halted=halted, not_stopped=not_stopped)


def _answer(outcomes: dict[str, StopOutcome], order: StopOrder, warned: dict[str, Any] | None) -> Answer[Any]:
    sites = {name: asdict(outcome) for name, outcome in sorted(outcomes.items())}
    missed = {name: outcome for name, outcome in sorted(outcomes.items()) if not outcome.stopped}
    if not missed:

        def together(name: str) -> list[Any]:
            return [each for outcome in outcomes.values() for each in getattr(outcome, name)]

        report = {name: together(name) for name in ("canceling", "failed", "unconfirmed", "not_stopped")}
        held = sorted(together("robots"))
        stop = {"latched": order.latch, "stopped_at": utc_now(), "by": order.by, "robots": held, "persisted": True}
        stopped = sorted(together("halted"))
        return json_response(
            {**report, "stopped": stopped, "stop": stop, "others": [], "warning": warned, "sites": sites}
        )
    reasons = "; ".join(f"{name}: {outcome.detail}" for name, outcome in missed.items())
    raise ServerTimeout(
        f"the stop is not confirmed by {len(missed)} of {len(outcomes)} sites ({reasons}); use a robot's own emergency "
        "stop if it moves",
        code="stop_incomplete",
        sites=sites,
        warning=warned,
    )


@router.delete("/stop", responses=problems(504, schema="HubReleaseProblem"))
@releases_stop
async def release_stop(request: Request, stops: Part[Stops], robot: BelowQuery = None) -> Answer[HubReleaseReport]:
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
