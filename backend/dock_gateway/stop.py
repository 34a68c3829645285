"""Stop: the robot stands still and its goals are canceled, whoever sent them."""

import asyncio
import logging
from dataclasses import dataclass, field

from dock_gateway.actions import ActionRegistry
from dock_gateway.errors import GatewayError
from dock_gateway.robots import RobotRegistry

log = logging.getLogger(__name__)


@dataclass
class StopReport:
    """What a stop did: the goals that are being canceled, and what could not be reached."""

    canceling: list[str] = field(default_factory=list)
    failed: list[dict[str, str]] = field(default_factory=list)


async def stop(robots: RobotRegistry, actions: ActionRegistry, namespace: str | None = None) -> StopReport:
    """Publish zero velocity at once, cancel every goal on every action of the robot, publish zero velocity again.

    Args:
        robots: The robots.
        actions: The actions.
        namespace: The robot; None is the configured one. Robots in namespaces below it are stopped, too.

    Raises:
        NotFound: There is no such robot.
        Unavailable: The ROS thread is down.
    """
    name = robots.get(namespace).namespace
    report = StopReport()
    targets, stopped = actions.under(name), robots.under(name)
    for action in targets:
        action.goals.disown_pending()
    zeros = asyncio.gather(*(robot.velocity.publish_zero() for robot in stopped), return_exceptions=True)
    answers = await asyncio.gather(*(action.goals.cancel_all() for action in targets), return_exceptions=True)
    for action, answer in zip(targets, answers, strict=True):
        if isinstance(answer, list):
            report.canceling.extend(answer)
        else:
            report.failed.append(_failure(action.name, answer))
            report.canceling.extend(getattr(answer, "extra", {}).get("canceling", []))
    again = await asyncio.gather(*(robot.velocity.publish_zero() for robot in stopped), return_exceptions=True)
    log.info("stop of %s: zero velocity, canceling %s", name, report.canceling or "no goal")
    for error in (*await zeros, *again):
        if error is not None:
            raise error
    return report


def _failure(action_name: str, error: BaseException) -> dict[str, str]:
    if isinstance(error, GatewayError):
        return {"action_name": action_name, "code": error.code, "detail": error.detail}
    log.error("while stopping %s", action_name, exc_info=error)
    return {"action_name": action_name, "code": GatewayError.code, "detail": "the gateway's log has the details"}
