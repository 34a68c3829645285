"""Stops robots, cancels the goals of any client, and sends none until the stop is released."""

import asyncio
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
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
from dock_gateway.stop.running_stop import RunningStop
from dock_gateway.stop.stop_report import StopReport, latched_stops, not_known, not_latched, together

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
        self._running: dict[str, RunningStop] = {}  # by namespace, while they can be joined
        self._tasks = Tasks("stopping")

    def state(self, namespace: str | None = None) -> dict[str, Any]:
        """Return the latch of a robot; default: that of all robots.

        Raises:
            NotFound: There is no such robot.
        """
        return self._interlock.document(self._robots.place(namespace))

    def stops(self, namespace: str | None = None) -> dict[str, Any]:
        """Return which robots are stopped, of one and those below it or, by default, of all, as `GET /stop` shows it.

        Raises:
            NotFound: There is no such robot.
        """
        return self._stops(self._robots.place(namespace))

    def _stops(self, name: str) -> dict[str, Any]:
        return latched_stops(self._interlock.document(name), self._interlock.document)

    async def release(self, namespace: str | None = None) -> dict[str, Any]:
        """Release the stop of a robot and those below it, of all robots by default.

        Return which of them are still stopped.

        Raises:
            NotFound: There is no such robot.
            Conflict: `stop_latched`: a stop of a namespace above holds for it.
        """
        name = self._robots.place(namespace)
        await self._interlock.release(name)
        return self._stops(name)

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
        joined = names & self._running.keys()
        stops = {name: self._running[name] if name in joined else self._begin(name) for name in sorted(names)}
        # Before the goals are canceled, whose error names who requested it.
        new = [name for name, stop in stops.items() if latch and self._latch(name, stop, by)]
        for name, stop in stops.items():
            (self._join if name in joined else self._cancel_goals)(name, stop)
        for stop in stops.values():
            await stop.confirmed.wait()
            await stop.ended(began + self.timing.confirm_within - time.monotonic())
        for name in new:
            self._interlock.publish(name)
        if latch:
            unstored = await self._interlock.stored(began + self.timing.store_within - time.monotonic())
            report.problems += [] if unstored is None else [unstored]
        if wait > self.timing.confirm_within:
            for stop in stops.values():
                await stop.ended(began + wait - time.monotonic())
        self._complete(report, stops)
        if stops and all(stop.robots and len(stop.unreached) == len(stop.robots) for stop in stops.values()):
            detail = "zero velocity could not be published; use the robot's own emergency stop if it moves"
            raise Unavailable(detail, code="ros_unavailable", **report.document())
        return report

    def _complete(self, report: StopReport, stops: dict[str, RunningStop]) -> None:
        report.stop = together([self._stops(name) for name in stops])
        if self._share.limited and ALL_ROBOTS in stops:
            report.others = [claim.document() for claim in self._share.others()]
        for name, stop in stops.items():
            report.add(stop.report())
            if stop.latched:
                report.failed += [not_latched(*each) for each in self._interlock.unpublished(name).items()]
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
        report.failed += [not_known(robot, error) for robot, error in refused.items()]
        if not names:
            elsewhere = [error for error in refused.values() if isinstance(error, ServedElsewhere)]
            if len(elsewhere) == len(refused):
                raise elsewhere[0]
            problem = next(error for error in refused.values() if error not in elsewhere)
            report.problems.append(NotFound(f"{problem.detail}: all robots are stopped", code=problem.code))
            return {ALL_ROBOTS}
        return {name for name in names if not names & (set(lineage(name)) - {name})}

    def _latch(self, name: str, stop: RunningStop, by: str | None) -> bool:
        """Latch a stop; return False if it is latched already."""
        if stop.latched and self._interlock.holds(name):
            return False
        stop.latched = True
        self._interlock.latch(name, by)
        return True

    # ------------------------------------------------------------------ execution

    def _begin(self, name: str) -> RunningStop:
        self._running[name] = stop = RunningStop(self._robots.under(name))
        stop.publish_zero()
        self._tasks.spawn(self._carry_on(name, stop))
        return stop

    def _cancel_goals(self, name: str, stop: RunningStop) -> None:
        for action in self._actions.under(name):
            self._cancel(stop, action)
        self._notify(stop.robots)

    def _join(self, name: str, stop: RunningStop) -> None:
        """Repeat the stop: since it began, a robot may have been driven or have appeared, or a goal have started."""
        stop.joined = True
        known = {robot.namespace for robot in stop.robots}
        new = [robot for robot in self._robots.under(name) if robot.namespace not in known]
        stop.robots += new
        if new or time.monotonic() - stop.published_at > self.timing.rest * stop.took:
            stop.publish_zero()
            self._notify(stop.robots)
        for action in self._actions.under(name):
            cancel = stop.cancels.get(action)
            if cancel is None or (cancel.done() and action.canceler.uncanceled):
                self._cancel(stop, action)
            else:
                with _keeping_on():
                    action.delivery.stop()

    def _notify(self, robots: list[Robot]) -> None:
        for robot in robots:
            self.on_stop(robot.namespace)

    def _cancel(self, stop: RunningStop, action: Action) -> None:
        with _keeping_on():
            action.delivery.stop()
        stop.cancels[action] = self._tasks.spawn(action.canceler.cancel_all())

    async def _carry_on(self, name: str, stop: RunningStop) -> None:
        try:
            await stop.ended(self.timing.confirm_within)
            # Not before the cancels: a server that receives the latch first would abort its goal.
            if stop.latched:
                self._interlock.publish(name)
            log.info("stop of %s: zero velocity, canceling %s", name, stop.report().canceling or "no goal")
            stop.confirmed.set()
            while await self._repeat(stop):
                pass
        finally:
            del self._running[name]
            stop.confirmed.set()
        if stop.report().unconfirmed:
            await stop.ended(None)
            stop.publish_zero()

    async def _repeat(self, stop: RunningStop) -> bool:
        """Publish zero velocity again, to override commands sent since; return whether others joined meanwhile."""
        stop.joined = False
        await asyncio.sleep(max(self.timing.repeat_after, self.timing.rest * stop.took))
        stop.publish_zero()
        return stop.joined

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
