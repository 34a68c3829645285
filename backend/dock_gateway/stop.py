"""Stop: the robot stands still, its goals are canceled, whoever sent them, and none is sent until it is released."""

import asyncio
import logging
from dataclasses import dataclass, field
from typing import Any

from dock_gateway.actions import Action, ActionRegistry
from dock_gateway.errors import GatewayError
from dock_gateway.interlock import Interlock
from dock_gateway.robots import Robot, RobotRegistry
from dock_gateway.tasks import Tasks

log = logging.getLogger(__name__)

# A stop is answered within 100 ms. Half of them are for the action servers to answer.
CONFIRM_WITHIN = 0.05


@dataclass
class StopReport:
    """What a stop did.

    Attributes:
        canceling: The goals that are being canceled.
        failed: The actions that refused, or could not be reached.
        unconfirmed: The actions that were asked to cancel their goals and have not answered yet.
        stop: The latch, as `GET /stop` shows it.
    """

    canceling: list[str] = field(default_factory=list)
    failed: list[dict[str, str]] = field(default_factory=list)
    unconfirmed: list[str] = field(default_factory=list)
    stop: dict[str, Any] = field(default_factory=dict)


class Stopper:
    """Stops robots, and releases them.

    Args:
        robots: The robots.
        actions: The actions.
        interlock: Where stops are latched.
    """

    def __init__(self, robots: RobotRegistry, actions: ActionRegistry, interlock: Interlock) -> None:
        self._robots = robots
        self._actions = actions
        self._interlock = interlock
        self._tasks = Tasks("stopping")

    def state(self, namespace: str | None = None) -> dict[str, Any]:
        """The latch of a robot, the configured one where none is named.

        Raises:
            NotFound: There is no such robot.
        """
        return self._interlock.document(self._robots.get(namespace).namespace)

    async def release(self, namespace: str | None = None) -> dict[str, Any]:
        """Let goals through again, to a robot and those below it; returns the latch.

        Raises:
            NotFound: There is no such robot.
            Conflict: `stop_latched`: a stop of a namespace above holds for it.
            Unavailable: The ROS thread is down.
        """
        name = self._robots.get(namespace).namespace
        await self._interlock.release(name)
        return self._interlock.document(name)

    async def stop(
        self, namespace: str | None = None, *, latch: bool = True, by: str | None = None, wait: float = 0.0
    ) -> StopReport:
        """Publish zero velocity, cancel every goal on every action of the robot, publish zero velocity again.

        It waits for the ROS thread, and for action servers no longer than a moment.

        Args:
            namespace: The robot; None is the configured one. Robots in namespaces below it are stopped, too.
            latch: Refuse goals until the stop is released.
            by: Who asked for it.
            wait: Seconds that action servers may take to answer, where they are more than the moment.

        Raises:
            NotFound: There is no such robot.
            Unavailable: The ROS thread is down.
        """
        name = self._robots.get(namespace).namespace
        targets, stopped = self._actions.under(name), self._robots.under(name)
        pending: list[asyncio.Future[Any]] = []
        if latch:
            pending.append(self._interlock.latch(name, by))
        for action in targets:
            action.goals.disown_pending()
        zeros = self._tasks.spawn(_publish_zero(stopped))
        cancels = {action: self._tasks.spawn(action.goals.cancel_all()) for action in targets}
        pending += cancels.values()
        if pending:
            await asyncio.wait(pending, timeout=CONFIRM_WITHIN)
        await zeros
        # Only now: a server that heard of the latch first would abort its goal, where it is to be canceled.
        if latch:
            await self._interlock.tell(name)
        again = self._tasks.spawn(self._once_more(stopped, list(cancels.values())))
        if wait > CONFIRM_WITHIN:
            await asyncio.wait([again, *pending], timeout=wait - CONFIRM_WITHIN)
        report = _report(cancels)
        report.stop = self._interlock.document(name)
        log.info("stop of %s: zero velocity, canceling %s", name, report.canceling or "no goal")
        return report

    async def _once_more(self, robots: list[Robot], cancels: list["asyncio.Task[list[str]]"]) -> None:
        """What drove the robot until it was canceled may have had the last word."""
        await asyncio.gather(*cancels, return_exceptions=True)
        await _publish_zero(robots)

    async def close(self) -> None:
        """Wait for nothing any more."""
        await self._tasks.close()


async def _publish_zero(robots: list[Robot]) -> None:
    await asyncio.gather(*(robot.velocity.publish_zero() for robot in robots))


def _report(cancels: dict[Action, "asyncio.Task[list[str]]"]) -> StopReport:
    report = StopReport()
    for action, task in cancels.items():
        if not task.done():
            report.unconfirmed.append(action.name)
        elif (error := task.exception()) is None:
            report.canceling += task.result()
        else:
            report.failed.append(_failure(action.name, error))
            report.canceling += getattr(error, "extra", {}).get("canceling", [])
    return report


def _failure(action_name: str, error: BaseException) -> dict[str, str]:
    if isinstance(error, GatewayError):
        return {"action_name": action_name, "code": error.code, "detail": error.detail}
    return {"action_name": action_name, "code": GatewayError.code, "detail": "the gateway's log has the details"}
