"""Stop: the robot stands still, its goals are canceled, whoever sent them, and none is sent until it is released."""

import asyncio
import logging
import time
from dataclasses import dataclass, field
from typing import Any

from dock_gateway.actions.registry import Action, ActionRegistry
from dock_gateway.core.errors import GatewayError, Unavailable
from dock_gateway.core.tasks import Tasks
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import Robot, RobotRegistry

log = logging.getLogger(__name__)

# A stop is answered within 100 ms. Half of them are for the action servers to answer.
CONFIRM_WITHIN = 0.05
# Zero velocity is published again after so many seconds. Who asks for the same stop until then joins it.
REPEAT_AFTER = 0.1
# To tell hundreds of robots takes some 20 ms of the loop, which hundreds of stops a second cannot have each: after it,
# who joins does not have it done once more for so many times as long.
REST = 4
# The disk may take the rest, but for what the answer itself needs.
STORE_WITHIN = 0.08


@dataclass
class StopReport:
    """What a stop did.

    Attributes:
        canceling: The goals that are being canceled.
        failed: The actions that refused or could not be reached, and the robots that zero velocity could not be
            published to.
        unconfirmed: The actions that were asked to cancel their goals and have not answered yet.
        stop: The latch, as `GET /stop` shows it.
        problem: Why a restart of the gateway would forget the stop, where it would.
    """

    canceling: list[str] = field(default_factory=list)
    failed: list[dict[str, str | None]] = field(default_factory=list)
    unconfirmed: list[str] = field(default_factory=list)
    stop: dict[str, Any] = field(default_factory=dict)
    problem: GatewayError | None = None


class Halt:
    """One stop that is carried out, for everyone who asks for it until it has been repeated.

    Attributes:
        robots: Who is stopped.
        cancels: The requests to cancel every goal, by action.
        unreached: The robots that could not be told to stand still the last time, and why.
        latched: Whether one of those who asked wants the stop to hold.
        joined: Whether somebody has joined since it was carried out last.
        took: How long it took to tell all robots, in seconds.
        told_at: When that was done last, on the monotonic clock.
        confirmed: Set when the action servers have answered, or their time is up.
    """

    def __init__(self, robots: list[Robot]) -> None:
        self.robots = robots
        self.cancels: dict[Action, asyncio.Task[list[str]]] = {}
        self.unreached: dict[str, Exception] = {}
        self.latched = self.joined = False
        self.took = self.told_at = 0.0
        self.confirmed = asyncio.Event()

    def publish_zero(self) -> None:
        """Tell each robot to stand still, whatever becomes of the others."""
        began = time.monotonic()
        self.unreached = {}
        for robot in self.robots:
            try:
                robot.velocity.publish_zero()
            except Exception as error:
                log.exception("zero velocity could not be published to %s", robot.namespace)
                self.unreached[robot.namespace] = error
        self.told_at = time.monotonic()
        self.took = self.told_at - began

    async def ended(self, timeout: float | None) -> None:
        """Wait until all action servers have answered, or the time is up."""
        pending = [cancel for cancel in self.cancels.values() if not cancel.done()]
        if pending and (timeout is None or timeout > 0):
            await asyncio.wait(pending, timeout=timeout)

    def report(self) -> StopReport:
        """What has been done until now."""
        report = StopReport(failed=[_not_told(robot, error) for robot, error in self.unreached.items()])
        for action, task in self.cancels.items():
            if not task.done():
                report.unconfirmed.append(action.name)
            elif (error := task.exception()) is None:
                report.canceling += task.result()
            else:
                report.failed.append(_not_canceled(action.name, error))
                report.canceling += getattr(error, "extra", {}).get("canceling", [])
        return report


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
        self._halts: dict[str, Halt] = {}  # by namespace, while they can be joined
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
        """
        name = self._robots.get(namespace).namespace
        await self._interlock.release(name)
        return self._interlock.document(name)

    async def stop(
        self, namespace: str | None = None, *, latch: bool = True, by: str | None = None, wait: float = 0.0
    ) -> StopReport:
        """Publish zero velocity, cancel every goal on every action of the robot, publish zero velocity again.

        All is done before it waits for anybody: for action servers and the disk no longer than a moment. Who asks for
        a stop that was begun a moment ago joins it, and it is repeated.

        Args:
            namespace: The robot; None is the configured one. Robots in namespaces below it are stopped, too.
            latch: Refuse goals until the stop is released.
            by: Who asked for it.
            wait: Seconds that action servers may take to answer, where they are more than the moment.

        Raises:
            NotFound: There is no such robot.
            Unavailable: `ros_unavailable`: no robot could be told to stand still. Goals are canceled and the stop is
                latched nevertheless, as the report in `extra` says.
        """
        began = time.monotonic()
        name = self._robots.get(namespace).namespace
        if (halt := self._halts.get(name)) is None:
            halt = self._begin(name)
        else:
            self._join(halt)
        if new := latch and not (halt.latched and self._interlock.holds(name)):
            halt.latched = True
            self._interlock.latch(name, by)
        await halt.confirmed.wait()
        await halt.ended(began + CONFIRM_WITHIN - time.monotonic())
        if new:
            self._interlock.tell(name)
        problem = await self._interlock.stored(began + STORE_WITHIN - time.monotonic()) if latch else None
        if wait > CONFIRM_WITHIN:
            await halt.ended(began + wait - time.monotonic())
        report = halt.report()
        report.stop, report.problem = self._interlock.document(name), problem
        if len(halt.unreached) == len(halt.robots):
            detail = "zero velocity could not be published; use the robot's own emergency stop if it moves"
            done_all_the_same = {key: value for key, value in vars(report).items() if key != "problem"}
            raise Unavailable(detail, code="ros_unavailable", **done_all_the_same)
        return report

    # ------------------------------------------------------------------ carrying it out

    def _begin(self, name: str) -> Halt:
        self._halts[name] = halt = Halt(self._robots.under(name))
        halt.publish_zero()
        for action in self._actions.under(name):
            self._cancel(halt, action)
        self._tasks.spawn(self._carry_on(name, halt))
        return halt

    def _join(self, halt: Halt) -> None:
        """Do again what has come to be undone since: something may have driven a robot, or a goal may have begun."""
        halt.joined = True
        if time.monotonic() - halt.told_at > REST * halt.took:
            halt.publish_zero()
        for action, cancel in list(halt.cancels.items()):
            if cancel.done() and action.canceler.uncanceled:
                self._cancel(halt, action)
            else:
                action.delivery.stop()

    def _cancel(self, halt: Halt, action: Action) -> None:
        action.delivery.stop()
        halt.cancels[action] = self._tasks.spawn(action.canceler.cancel_all())

    async def _carry_on(self, name: str, halt: Halt) -> None:
        try:
            await halt.ended(CONFIRM_WITHIN)
            # Not before the cancels: a server that heard of the latch first would abort its goal.
            if halt.latched:
                self._interlock.tell(name)
            log.info("stop of %s: zero velocity, canceling %s", name, halt.report().canceling or "no goal")
            halt.confirmed.set()
            while await self._repeat(halt):
                pass
        finally:
            del self._halts[name]
            halt.confirmed.set()
        if halt.report().unconfirmed:
            await halt.ended(None)
            halt.publish_zero()

    async def _repeat(self, halt: Halt) -> bool:
        """What drove a robot may have had the last word until now. Returns whether others have joined meanwhile."""
        halt.joined = False
        await asyncio.sleep(max(REPEAT_AFTER, REST * halt.took))
        halt.publish_zero()
        return halt.joined

    async def close(self) -> None:
        """Wait for nothing any more."""
        await self._tasks.close()


def _not_told(robot: str, error: Exception) -> dict[str, str | None]:
    detail = f"zero velocity could not be published to {robot}: {error!r:.200}"
    return {"action_name": None, "robot": robot, "code": "publish_failed", "detail": detail}


def _not_canceled(action_name: str, error: BaseException) -> dict[str, str | None]:
    code, detail = GatewayError.code, "the gateway's log has the details"
    if isinstance(error, GatewayError):
        code, detail = error.code, error.detail
    return {"action_name": action_name, "robot": None, "code": code, "detail": detail}
