"""Stopping robots, and releasing the stop. `stop/order` reads the request of each door, and declares what it needs."""

from typing import Any

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import Unavailable
from dock_gateway.http.parts import Parts
from dock_gateway.stop.order import StopOrder, releases_stop, stops_robots
from dock_gateway.stop.stop_report import narrow_report
from dock_gateway.stop.stopper import Stopper


@stops_robots
async def stop(parts: Parts, principal: Principal, order: StopOrder, *, wait: float = 0.0) -> dict[str, Any]:
    """Stop robots.

    Args:
        parts: Stop them.
        principal: The user, who is shown the robots that their grant covers.
        order: What the request means.
        wait: Seconds that action servers may take to answer.

    Returns:
        The report, with what was wrong with the request as `warning`.

    Raises:
        ServedElsewhere: The robots are those of another gateway.
        Unavailable: Zero velocity could not be published.
    """
    try:
        report = await parts[Stopper].stop(*order.robots, latch=order.latch, by=order.by, wait=wait)
    except Unavailable as error:
        error.extra = narrow_report(error.extra, principal.grant)
        raise
    return narrow_report(report.document(), principal.grant) | {"warning": order.warning(*report.problems)}


@releases_stop
async def release_stop(parts: Parts, _: Principal, robot: str | None) -> dict[str, Any]:
    """Release the stop of a robot and of those below it; of all without one. Return the state of the stop.

    Raises:
        GatewayError: There is no such robot, or something else still holds it.
    """
    return await parts[Stopper].release(robot)
