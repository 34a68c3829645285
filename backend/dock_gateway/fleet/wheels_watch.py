"""Stops a robot whose commands end while it moves and a docking goal runs: its server is dead, frozen or out of reach.

DDS tells neither a death nor SIGSTOP in time, but a server that drives a robot commands it several times a second. A
base with a command timeout stops by itself; one without goes on driving.

A gateway that has just stalled must not take that for the silence of a server. So commands count from when they
arrived, those that wait are heard before the robot is stopped, and two scans in a row have to find the same silence.
"""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Iterator

from dock_gateway.core.goal import Goal
from dock_gateway.core.tasks import Tasks
from dock_gateway.fleet.findings import Finding, commands_lost
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.wheels import VelocityCommand

log = logging.getLogger(__name__)

# Seconds between two scans.
INTERVAL = 0.05
# A server that is slower than usual has this many of its own intervals, up to the longest silence in seconds.
MISSED, LONGEST = 1.5, 2.0
UNKNOWN = "a node that has left the ROS graph"


class WheelsWatch:
    """Watches the commands of robots with a running docking goal of any sender.

    Args:
        actions: The actions, with their goals.
        robots: The robots.
        name: Returns the node of a publisher on the velocity topic of a robot; None if it is not known.
        timeout: Seconds without a command after which a robot that moves is stopped; 0: never. A node that usually
            commands more rarely has one and a half of its intervals.

    Attributes:
        findings: The robots that were stopped, until their goals have ended or they are commanded again.
    """

    def __init__(
        self,
        actions: ActionRegistry,
        robots: RobotRegistry,
        name: Callable[[str, bytes], Awaitable[str | None]],
        timeout: float,
    ) -> None:
        self._actions = actions
        self._robots = robots
        self._name = name
        self._timeout = timeout
        self._goals: dict[str, set[str]] = {}  # of each robot, those that run
        self._ended_at: dict[str, float] = {}
        self._names: dict[bytes, str] = {}
        self._silent: dict[str, VelocityCommand] = {}  # the last of robots whose commands had ended
        self._stopped: dict[str, Finding] = {}
        self._changed: Callable[[], None] = lambda: None
        self._wake = asyncio.Event()
        self._tasks = Tasks("watching commands")
        if timeout > 0:
            for listeners in (actions.on_sent, actions.on_change):
                listeners.append(self._follow)
            for listeners in (actions.on_end, actions.on_lost):
                listeners.append(self._leave)
            self._tasks.spawn(self._run())
        actions.before_lost.append(self.halt)

    @property
    def findings(self) -> list[Finding]:
        """The findings for alerts."""
        return list(self._stopped.values())

    # ------------------------------------------------------------------ which robots

    def _robot_of(self, goal: Goal) -> str | None:
        docks = self._actions.verb_of(goal.action_name) is not None
        owner = self._robots.owner(goal.action_name) if docks else None
        return None if owner is None else owner.namespace

    def _follow(self, goal: Goal) -> None:
        if goal.status.terminal or (robot := self._robot_of(goal)) is None:
            return
        goals = self._goals.setdefault(robot, set())
        if goal.goal_id not in goals:
            goals.add(goal.goal_id)
            self._ended_at.pop(robot, None)
            self._robots.get(robot).wheels.leave()
            self._changed()

    def _leave(self, goal: Goal) -> None:
        for robot, goals in list(self._goals.items()):
            goals.discard(goal.goal_id)
            if not goals:
                del self._goals[robot]
                self._ended_at[robot] = time.monotonic()
                self._stopped.pop(robot, None)
                self._changed()

    def watched(self, topic: str) -> set[str]:
        """Return the robots whose commands are wanted."""
        return set(self._goals)

    def on_watch(self, topic: str, changed: Callable[[], None]) -> None:
        """Register `changed`, to be called when other robots are wanted."""

        def both() -> None:
            changed()
            self._wake.set()

        self._changed = both

    # ------------------------------------------------------------------ watching

    async def _run(self) -> None:
        while True:
            self.scan(time.monotonic())
            if self._goals or self._ended_at:
                await asyncio.sleep(INTERVAL)
            else:
                self._names.clear()
                self._wake.clear()
                await self._wake.wait()

    def scan(self, now: float) -> None:
        """Stop the robots whose commands have ended.

        Args:
            now: The current time, on the monotonic clock.
        """
        for robot, last in self._heard(now):
            self._check(robot, last, now)

    def _heard(self, now: float) -> Iterator[tuple[str, VelocityCommand]]:
        """Yield the robots whose commands are heard: with a goal, and a moment longer."""
        for robot in [*self._goals, *self._ended_at]:
            wheels = self._robots.get(robot).wheels if robot in self._robots else None
            if wheels is None or wheels.last is None:
                self._ended_at.pop(robot, None)
                self._silent.pop(robot, None)
                continue
            if wheels.last.motion and now - wheels.last.at > self._timeout:
                wheels.catch_up()
            yield robot, wheels.last

    def _check(self, robot: str, last: VelocityCommand, now: float) -> None:
        if last.publisher is not None and last.publisher not in self._names:
            self._names[last.publisher] = UNKNOWN
            self._tasks.spawn(self._learn(robot, last.publisher))
        allowed = self._allowed(robot)
        others = robot not in self._goals and last.at > self._ended_at.get(robot, now)  # drive it now, for no goal
        if last.motion and not others and now - last.at > allowed:
            if self._silent.get(robot) == last:
                self._stop(robot, last, allowed)
            self._silent[robot] = last
            return
        self._silent.pop(robot, None)
        if robot in self._stopped and last.motion and last.publisher is not None:
            del self._stopped[robot]
            log.info("%s is driven again", robot)

    def _allowed(self, robot: str) -> float:
        """Return the seconds without a command that do not stop a robot."""
        return max(self._timeout, min(LONGEST, MISSED * self._robots.get(robot).wheels.interval))

    def _stop(self, robot: str, last: VelocityCommand, allowed: float) -> None:
        wheels = self._robots.get(robot).wheels
        wheels.last = VelocityCommand(time.monotonic(), motion=False)
        try:
            wheels.publish_zero()
        except Exception:
            log.exception("the commands of %s have ended, and zero velocity could not be published", robot)
            wheels.last = last  # again at the next scan
            return
        if last.publisher is None:
            return  # none was heard since the goal began: it may stand still as well
        finding = commands_lost(robot, self._names[last.publisher], allowed)
        if robot in self._goals:
            self._stopped[robot] = finding
        log.warning("%s", finding.detail)

    async def _learn(self, robot: str, publisher: bytes) -> None:
        self._names[publisher] = await self._name(robot, publisher) or UNKNOWN

    # ------------------------------------------------------------------ goals that are lost

    def halt(self, goal: Goal) -> str:
        """Stop the robot of a docking goal that is about to be lost; return what was done, as a clause."""
        if (robot := self._robot_of(goal)) is None:
            return ""
        wheels = self._robots.get(robot).wheels
        wheels.catch_up()
        last = wheels.last
        if last is not None and last.motion and last.publisher and time.monotonic() - last.at <= self._allowed(robot):
            return f"zero velocity was not sent, as {self._names.get(last.publisher, UNKNOWN)} drives the robot"
        try:
            wheels.publish_zero()
        except Exception as error:
            log.exception("zero velocity could not be published to %s", robot)
            return f"zero velocity could not be sent: {error}"
        return "zero velocity was sent"

    async def close(self) -> None:
        """Stop watching."""
        await self._tasks.close()
