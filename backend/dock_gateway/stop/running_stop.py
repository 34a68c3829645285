"""One stop being executed."""

import asyncio
import logging
import time

from dock_gateway.goals.action import Action
from dock_gateway.robots.registry import Robot
from dock_gateway.stop.stop_report import StopReport, not_canceled, not_stopped

log = logging.getLogger(__name__)


class RunningStop:
    """One stop being executed, shared by all requests for it until it has been repeated.

    Attributes:
        robots: The robots to stop.
        cancels: The requests to cancel every goal, by action.
        unreached: The robots to which zero velocity could not be published the last time, and why.
        latched: Whether one of the requests asked for the stop to be latched.
        joined: Whether a request has joined since the last repetition.
        took: How long it took to publish zero velocity to all robots, in seconds.
        published_at: When that was last done, on the monotonic clock.
        confirmed: Set when the action servers have answered or timed out.
    """

    def __init__(self, robots: list[Robot]) -> None:
        self.robots = robots
        self.cancels: dict[Action, asyncio.Task[list[str]]] = {}
        self.unreached: dict[str, Exception] = {}
        self.latched = self.joined = False
        self.took = self.published_at = 0.0
        self.confirmed = asyncio.Event()

    def publish_zero(self) -> None:
        """Publish zero velocity to each robot. A failure does not affect the others."""
        began = time.monotonic()
        self.unreached = {}
        for robot in self.robots:
            try:
                robot.wheels.publish_zero()
            except Exception as error:
                log.exception("zero velocity could not be published to %s", robot.namespace)
                self.unreached[robot.namespace] = error
        self.published_at = time.monotonic()
        self.took = self.published_at - began

    async def ended(self, timeout: float | None) -> None:
        """Wait until all action servers have answered, at most `timeout` seconds."""
        pending = [cancel for cancel in self.cancels.values() if not cancel.done()]
        if pending and (timeout is None or timeout > 0):
            await asyncio.wait(pending, timeout=timeout)

    def report(self) -> StopReport:
        """Return what has been done so far."""
        report = StopReport(
            failed=[not_stopped(robot, error) for robot, error in self.unreached.items()],
            stopped=[robot.namespace for robot in self.robots if robot.namespace not in self.unreached],
        )
        for action, task in self.cancels.items():
            if not task.done():
                report.unconfirmed.append(action.name)
            elif (error := task.exception()) is None:
                report.canceling += task.result()
            else:
                report.failed.append(not_canceled(action.name, error))
                report.canceling += getattr(error, "extra", {}).get("canceling", [])
        return report
