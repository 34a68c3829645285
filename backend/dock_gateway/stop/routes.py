"""`/stop`: stop a robot, check whether a stop is latched, release it.

A malformed request still stops the robot, unless it is unclear which robot is meant. Any other error is reported in
the response's `warning`.
"""

import asyncio
from http import HTTPStatus
from typing import Any

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.audit.subjects import robots_text
from dock_gateway.audit.trail import Trail, audited
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.grant import Role
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import principal_of
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    RobotQuery,
    RobotsQuery,
    json_response,
    known_query,
    read_json,
    read_wait,
)
from dock_gateway.stop.requests import PREFER, STOP_REQUEST, noting, read_robots, read_stop, warning
from dock_gateway.stop.schema import StopReport, StopState
from dock_gateway.stop.stopper import Stopper

router = APIRouter(tags=["Stop"])
only_robot = Depends(known_query("robot"))


async def stop_robots(
    stopper: Stopper,
    principal: Principal,
    robots: list[str],
    value: object,
    *,
    wait: float = 0.0,
    wrong: list[GatewayError] | None = None,
) -> dict[str, Any]:
    """Stop robots as requested, or by the defaults if the request cannot be read.

    Args:
        stopper: Stops them.
        principal: The user who stops them; recorded if known, even if the rest of the request cannot be read.
        robots: The robots; none is the configured one.
        value: The decoded body, or the fields of a command.
        wait: Seconds that action servers may take to answer.
        wrong: Errors already found in the request.

    Returns:
        The report, with the errors as `warning`.

    Raises:
        NotFound: There is none of these robots.
        Unavailable: Zero velocity could not be published.
    """
    wrong = [] if wrong is None else wrong
    how = read_stop(principal, value, wrong)
    report = vars(await stopper.stop(*robots, **how, wait=wait))
    if (problem := report.pop("problem")) is not None:
        wrong.insert(0, problem)
    return {**report, "warning": warning(wrong) if wrong else None}


@router.post(
    "/stop",
    response_model=StopReport,
    responses=problems(404, 421, 422) | problems(503, schema="StopProblem"),
    openapi_extra={**body(STOP_REQUEST, required=False), "parameters": PREFER},
)
@operation(Role.VIEWER, Scope.ANY, reads_body=True)
async def stop(request: Request, stopper: Part[Stopper], robot: RobotsQuery = None) -> Response:
    """Stop the robot: publish zero velocity at once, cancel all goals on all its actions, and refuse new ones.

    Goals of other clients are canceled, too. New goals are refused (`409 stop_latched`) until `DELETE /stop` releases
    the stop; with `{"latch": false}` they are not refused. Robots in namespaces below are stopped, too: on a gateway
    without a namespace, a request without `robot` stops all robots. The response comes within 100 ms; action servers
    that have not answered by then are listed in `unconfirmed`. `Prefer: wait=2` waits up to 2 s for them.

    `robot` may be repeated, to stop several at once. Those that are not known are in `failed`, the others are stopped.

    A malformed request still stops the robot, unless it is unclear which robot is meant. Unreadable parts are
    ignored, and `warning` names the error. `warning` also says if a restart of the gateway would lose the stop.
    If the body comes late, the robot is stopped before, and the stop is latched as the body says, or after 2 s.
    """
    value: Any = {}
    wait = 0.0
    wrong: list[GatewayError] = []
    with noting(wrong):
        value = await _read_body(request, stopper)
    with noting(wrong):
        wait = read_wait(request)
    robots = read_robots(request.query_params, value, wrong)
    if robots:
        audited(request, robot=robots_text(robots))
    return json_response(await stop_robots(stopper, principal_of(request), robots, value, wait=wait, wrong=wrong))


async def _read_body(request: Request, stopper: Stopper) -> Any:
    """Return the decoded body. If it is late, stop the robot meanwhile, without latching: the body may name another.

    The audit log has that as a stop of its own, as the body may never come, or be about another robot.
    """
    timing = stopper.timing
    reading = asyncio.create_task(read_json(request, empty={}, within=timing.body_within))
    await asyncio.wait({reading}, timeout=timing.begin_within)
    if not reading.done():
        wrong: list[GatewayError] = []
        with noting(wrong):
            await stopper.stop(*read_robots(request.query_params, {}, []), latch=False)
        status, code = (wrong[0].status, wrong[0].code) if wrong else (HTTPStatus.OK, None)
        await Trail(request.scope).record(status, code)
    return await reading


@router.get("/stop", response_model=StopState, responses=problems(404, 422), dependencies=[only_robot])
@operation(Role.VIEWER, Scope.ROBOT)
async def get_stop(stopper: Part[Stopper], robot: RobotQuery = None) -> Response:
    """Return whether a stop is latched for a robot."""
    return json_response(stopper.state(robot))


@router.delete("/stop", response_model=StopState, responses=problems(404, 409, 422), dependencies=[only_robot])
@operation(Role.SUPERVISOR, Scope.ROBOTS, Audit.STORED_FIRST)
async def release_stop(stopper: Part[Stopper], robot: RobotQuery = None) -> Response:
    """Release the stop of a robot and of the robots below it; also if none is latched. The robot does not move."""
    return json_response(await stopper.release(robot))
