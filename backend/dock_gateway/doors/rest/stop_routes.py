"""`/stop`: stop robots, check whether a stop is latched, release it.

A malformed request stops robots, too. What could not be understood is in the response's `warning`.
"""

import asyncio
from dataclasses import replace
from functools import partial
from typing import Any

from fastapi import APIRouter, Request

from dock_gateway.audit.subjects import robots_text
from dock_gateway.audit.trail import STOP, audited, audited_command
from dock_gateway.core.errors import GatewayError, not_covered
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import ALL_ROBOTS, read_namespace
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, carries_out, operation, operation_of
from dock_gateway.http.parts import AllParts, Part, Parts
from dock_gateway.http.principal import TheGrant, ThePrincipal, principal_of
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
from dock_gateway.operations import stop as operations
from dock_gateway.stop.order import PREFER, STOP_REQUEST, noting, read_order
from dock_gateway.stop.schema import LatchedStops, StopReport
from dock_gateway.stop.stop_report import narrow_stops
from dock_gateway.stop.stopper import Stopper

router = APIRouter(route_class=ApiRoute, tags=["Stop"])


@router.post(
    "/stop",
    responses=problems(421) | problems(503, schema="StopProblem"),
    openapi_extra={**body(STOP_REQUEST, required=False), "parameters": PREFER},
)
@carries_out(operations.stop)
async def stop(request: Request, parts: AllParts, robot: RobotsQuery = None) -> Answer[StopReport]:
    """Stop robots: publish zero velocity at once, cancel all goals on all their actions, and refuse new ones.

    Goals of other clients are canceled, too. New goals are refused (`409 stop_latched`) until `DELETE /stop` releases
    the stop; with `{"latch": false}` they are not refused. Without `robot`, every robot of the gateway is stopped.
    Robots in namespaces below the named ones are stopped, too. The response comes within 100 ms; action servers
    that have not answered by then are listed in `unconfirmed`. `Prefer: wait=2` waits up to 2 s for them.

    `robot` may be repeated, to stop several at once. `stopped` lists the robots to which zero velocity was published,
    `not_stopped` the others.

    A malformed request stops robots, too: those that it clearly names, all if that is not clear or none of them is
    known. `warning` names what could not be understood. It also says if a restart of the gateway would lose the stop.
    If the body comes late, the robots are stopped before, and the stop is latched as the body says, or after 2 s.
    """
    value: Any = {}
    wait = 0.0
    wrong: list[GatewayError] = []
    try:
        value = await _read_body(request, parts)
    except GatewayError as error:
        value = error
    with noting(wrong):
        wait = read_wait(request)
    principal = principal_of(request)
    order = read_order(principal, value, query=request.query_params, wrong=wrong)
    audited(request, robot=robots_text(order.robots))
    return json_response(await operations.stop(parts, principal, order, wait=wait))


async def _read_body(request: Request, parts: Parts) -> Any:
    """Return the decoded body. If it is late, stop the robots first, without latching: the body may name others.

    The audit log has that as a stop of its own, as the body may never come, or be about another robot.
    """
    timing = parts[Stopper].timing
    reading = asyncio.create_task(read_json(request, empty={}, within=timing.body_within))
    await asyncio.wait({reading}, timeout=timing.begin_within)
    if not reading.done():
        principal = principal_of(request)
        order = replace(read_order(principal, {}, query=request.query_params), latch=False)
        stopping = partial(operations.stop, parts, principal, order)
        with noting([]):
            await audited_command(request.scope, STOP, operation_of(operations.stop), {"robot": order.robots}, stopping)
    return await reading


@router.get("/stop")
@operation(Role.VIEWER, Scope.LISTED, errors=(404, 421))
async def get_stop(stopper: Part[Stopper], grant: TheGrant, robot: AnyRobotQuery = None) -> Answer[LatchedStops]:
    """Return which robots are stopped: a robot and those below it; without `robot`, all.

    `robots` and `stops` leave out those beyond the user's limits.
    """
    state = stopper.stops(robot)
    if robot is not None and read_namespace(robot) != ALL_ROBOTS and not grant.covers_robot(read_namespace(robot)):
        raise not_covered(f"the robot {robot}")
    return json_response(narrow_stops(state, grant))


@router.delete("/stop", responses=problems(409))
@carries_out(operations.release_stop)
async def release_stop(parts: AllParts, principal: ThePrincipal, robot: BelowQuery = None) -> Answer[LatchedStops]:
    """Release the stop of a robot and of the robots below it, without `robot` of all; also if none is latched.

    This moves no robot.
    """
    return json_response(await operations.release_stop(parts, principal, robot))
