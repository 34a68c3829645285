"""Stop: halts the robot, cancels its goals, regardless of sender, and sends none until the stop is released."""

import asyncio
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from dock_gateway.core.errors import GatewayError, NotFound, ServedElsewhere, Unavailable
from dock_gateway.core.filters import lineage
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.namespace import ALL_ROBOTS
from dock_gateway.core.share import EVERYTHING, Share
from dock_gateway.core.tasks import Tasks
from dock_gateway.goals.action import Action
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import Robot, RobotRegistry

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class StopTiming:
    """Timeouts that let a stop be answered within 100 ms. Times are in seconds.

    Publishing zero velocity to hundreds of robots blocks the loop for some 20 ms, too long to repeat for hundreds of
    stops per second: see `rest`.

    Attributes:
        begin_within: Time after which a stop begins without its body. Most bodies come with the headers.
        body_within: Time after which it is carried out without its body.
        confirm_within: Time for the answers of the action servers.
        store_within: Time after the request until which the answer waits for the disk.
        repeat_after: Time before zero velocity is published again. Requests for the same stop until then join it.
        rest: Requests that join do not repeat it until this many times its duration has passed.
    """

    begin_within: float = 0.03
    body_within: float = 2.0
    confirm_within: float = 0.05
    store_within: float = 0.08
    repeat_after: float = 0.1
    rest: float = 4.0


TIMING = StopTiming()


@dataclass
class StopReport:
    """The result of a stop.

    Attributes:
        canceling: The goals that are being canceled.
        failed: The actions that refused or could not be reached, and the robots that are not known, to which zero
            velocity could not be published, or whose nodes do not get the stop.
        unconfirmed: The actions that have not answered the cancel request yet.
        stop: The latch, as `GET /stop` shows it.
        stopped: The robots to which zero velocity was published, sorted.
        not_stopped: The other robots of this gateway, sorted: those that were not meant, and those that failed.
        others: The other gateways, where this one has a share of the robots and all of them were to stop.
        problems: Why more robots were stopped than were named, and why a restart of the gateway would forget the stop.
    """

    canceling: list[str] = field(default_factory=list)
    failed: list[dict[str, str | None]] = field(default_factory=list)
    unconfirmed: list[str] = field(default_factory=list)
    stop: dict[str, Any] = field(default_factory=dict)
    stopped: list[str] = field(default_factory=list)
    not_stopped: list[str] = field(default_factory=list)
    others: list[dict[str, Any]] = field(default_factory=list)
    problems: list[GatewayError] = field(default_factory=list)

    def add(self, other: "StopReport") -> None:
        """Add what was done to other robots."""
        self.canceling += other.canceling
        self.failed += other.failed
        self.unconfirmed += other.unconfirmed
        self.stopped = sorted({*self.stopped, *other.stopped})


class Halt:
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
                robot.velocity.publish_zero()
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
            failed=[_not_stopped(robot, error) for robot, error in self.unreached.items()],
            stopped=[robot.namespace for robot in self.robots if robot.namespace not in self.unreached],
        )
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
        interlock: Latches the stops.
        timing: How long to wait.
        share: The robots that this gateway serves.

    Attributes:
        on_stop: Called with the namespace of a robot that is stopped.
    """

    def __init__(
        self,
        robots: RobotRegistry,
        actions: ActionRegistry,
        interlock: Interlock,
        timing: StopTiming = TIMING,
        share: Share = EVERYTHING,
    ) -> None:
        self.timing = timing
        self._share = share
        self.on_stop = Listeners[[str]]("a robot is stopped")
        self._robots = robots
        self._actions = actions
        self._interlock = interlock
        self._halts: dict[str, Halt] = {}  # by namespace, while they can be joined
        self._tasks = Tasks("stopping")

    def state(self, namespace: str | None = None) -> dict[str, Any]:
        """Return the latch of a robot; default: that of all robots.

        Raises:
            NotFound: There is no such robot.
        """
        return self._interlock.document(self._robots.place(namespace))

    async def release(self, namespace: str | None = None) -> dict[str, Any]:
        """Release the stop of a robot and those below it, of all robots by default; return the latch.

        Raises:
            NotFound: There is no such robot.
            Conflict: `stop_latched`: a stop of a namespace above holds for it.
        """
        name = self._robots.place(namespace)
        await self._interlock.release(name)
        return self._interlock.document(name)

    async def stop(self, *namespaces: str, latch: bool = True, by: str | None = None, wait: float = 0.0) -> StopReport:
        """Publish zero velocity, cancel every goal on every action of the robots, publish zero velocity again.

        All requests are sent before it waits: less than 100 ms for action servers and the disk, unless `wait` is
        longer. A request for a stop that has just started joins it, and the stop is repeated. An unknown robot does not
        keep the others from being stopped. If no robot is known, the name may be misspelt, and all are stopped.

        Args:
            namespaces: The robots; none means all. Robots in namespaces below them are stopped, too.
            latch: Refuse goals until the stop is released.
            by: Who requested it.
            wait: Seconds to wait for the action servers' answers, if that is longer than usual.

        Raises:
            ServedElsewhere: None is one of this gateway's.
            Unavailable: `ros_unavailable`: zero velocity could not be published to any robot. Goals are canceled and
                the stop is latched nevertheless, as the report in `extra` says.
        """
        began = time.monotonic()
        report = StopReport()
        names = self._known(namespaces, report)
        joined = names & self._halts.keys()
        halts = {name: self._halts[name] if name in joined else self._begin(name) for name in sorted(names)}
        # Before the goals are canceled, whose error names who requested it.
        new = [name for name, halt in halts.items() if latch and self._latch(name, halt, by)]
        for name, halt in halts.items():
            (self._join if name in joined else self._cancel_goals)(name, halt)
        for halt in halts.values():
            await halt.confirmed.wait()
            await halt.ended(began + self.timing.confirm_within - time.monotonic())
        for name in new:
            self._interlock.publish(name)
        if latch:
            unstored = await self._interlock.stored(began + self.timing.store_within - time.monotonic())
            report.problems += [] if unstored is None else [unstored]
        if wait > self.timing.confirm_within:
            for halt in halts.values():
                await halt.ended(began + wait - time.monotonic())
        self._complete(report, halts)
        if halts and all(halt.robots and len(halt.unreached) == len(halt.robots) for halt in halts.values()):
            detail = "zero velocity could not be published; use the robot's own emergency stop if it moves"
            done_all_the_same = {key: value for key, value in vars(report).items() if key != "problems"}
            raise Unavailable(detail, code="ros_unavailable", **done_all_the_same)
        return report

    def _complete(self, report: StopReport, halts: dict[str, Halt]) -> None:
        report.stop = _together([self._interlock.document(name) for name in halts])
        if self._share.limited and ALL_ROBOTS in halts:
            report.others = [claim.document() for claim in self._share.others()]
        for name, halt in halts.items():
            report.add(halt.report())
            if halt.latched:
                report.failed += [_not_latched(*each) for each in self._interlock.unpublished(name).items()]
        stopped = {*report.stopped}
        report.not_stopped = [
            each.namespace for each in self._robots.under(ALL_ROBOTS) if each.namespace not in stopped
        ]

    def _known(self, namespaces: tuple[str, ...], report: StopReport) -> set[str]:
        """Return the robots to stop but those below others of them. Report those that are not known."""
        names: set[str] = set()
        refused: dict[str, GatewayError] = {}
        for namespace in namespaces or (ALL_ROBOTS,):
            try:
                names.add(self._robots.place(namespace))
            except GatewayError as error:
                refused[namespace] = error
        report.failed += [_not_known(robot, error) for robot, error in refused.items()]
        if not names:
            elsewhere = [error for error in refused.values() if isinstance(error, ServedElsewhere)]
            if len(elsewhere) == len(refused):
                raise elsewhere[0]
            problem = next(error for error in refused.values() if error not in elsewhere)
            report.problems.append(NotFound(f"{problem.detail}: all robots are stopped", code=problem.code))
            return {ALL_ROBOTS}
        return {name for name in names if not names & (set(lineage(name)) - {name})}

    def _latch(self, name: str, halt: Halt, by: str | None) -> bool:
        """Latch a stop; return False if it is latched already."""
        if halt.latched and self._interlock.holds(name):
            return False
        halt.latched = True
        self._interlock.latch(name, by)
        return True

    # ------------------------------------------------------------------ execution

    def _begin(self, name: str) -> Halt:
        self._halts[name] = halt = Halt(self._robots.under(name))
        halt.publish_zero()
        self._tasks.spawn(self._carry_on(name, halt))
        return halt

    def _cancel_goals(self, name: str, halt: Halt) -> None:
        for action in self._actions.under(name):
            self._cancel(halt, action)
        self._notify(halt.robots)

    def _join(self, name: str, halt: Halt) -> None:
        """Repeat the stop: since it began, a robot may have been driven or have appeared, or a goal have started."""
        halt.joined = True
        known = {robot.namespace for robot in halt.robots}
        new = [robot for robot in self._robots.under(name) if robot.namespace not in known]
        halt.robots += new
        if new or time.monotonic() - halt.published_at > self.timing.rest * halt.took:
            halt.publish_zero()
            self._notify(halt.robots)
        for action in self._actions.under(name):
            cancel = halt.cancels.get(action)
            if cancel is None or (cancel.done() and action.canceler.uncanceled):
                self._cancel(halt, action)
            else:
                with _keeping_on():
                    action.delivery.stop()

    def _notify(self, robots: list[Robot]) -> None:
        for robot in robots:
            self.on_stop(robot.namespace)

    def _cancel(self, halt: Halt, action: Action) -> None:
        with _keeping_on():
            action.delivery.stop()
        halt.cancels[action] = self._tasks.spawn(action.canceler.cancel_all())

    async def _carry_on(self, name: str, halt: Halt) -> None:
        try:
            await halt.ended(self.timing.confirm_within)
            # Not before the cancels: a server that receives the latch first would abort its goal.
            if halt.latched:
                self._interlock.publish(name)
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
        """Publish zero velocity again, to override commands sent since; return whether others joined meanwhile."""
        halt.joined = False
        await asyncio.sleep(max(self.timing.repeat_after, self.timing.rest * halt.took))
        halt.publish_zero()
        return halt.joined

    async def close(self) -> None:
        """Stop all background work."""
        await self._tasks.close()


@contextmanager
def _keeping_on() -> Iterator[None]:
    """Log any error: it keeps nothing else from being stopped."""
    try:
        yield
    except Exception:
        log.exception("a part of a stop failed")


def _together(stops: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the latch of several robots: latched if each of them is, since the first was."""
    latched = all(stop["latched"] for stop in stops)
    first = min(stops, key=lambda stop: stop["since"]) if latched else {"since": None, "by": None}
    return {
        "latched": latched,
        "since": first["since"],
        "by": first["by"],
        "robots": sorted({robot for stop in stops for robot in stop["robots"]}),
        "persisted": all(stop["persisted"] for stop in stops),
    }


def _not_stopped(robot: str, error: Exception) -> dict[str, str | None]:
    detail = f"zero velocity could not be published to {robot}: {error!r:.200}"
    return {"action_name": None, "robot": robot, "code": "publish_failed", "detail": detail}


def _not_latched(robot: str, reason: str) -> dict[str, str | None]:
    detail = f"the stop could not be published on the topic of {robot}, so its nodes do not know of it: {reason}"
    return {"action_name": None, "robot": robot, "code": "latch_not_published", "detail": detail[:400]}


def _not_known(robot: str, error: GatewayError) -> dict[str, str | None]:
    return {"action_name": None, "robot": robot, "code": error.code, "detail": error.detail}


def _not_canceled(action_name: str, error: BaseException) -> dict[str, str | None]:
    code, detail = GatewayError.code, "the gateway's log has the details"
    if isinstance(error, GatewayError):
        code, detail = error.code, error.detail
    return {"action_name": action_name, "robot": None, "code": code, "detail": detail}
