"""Stores where a robot is while a goal on one of its actions runs, so that the goal can be replayed on a map."""

import asyncio
import math
import time
from collections.abc import Callable
from typing import Any

from dock_gateway.core.event import Event, pose_event
from dock_gateway.core.goal import Goal
from dock_gateway.core.tasks import Tasks
from dock_gateway.robots.registry import Robot

SCAN_INTERVAL = 0.25  # seconds between two scans of the running goals
# Nanoseconds between two stored poses of a goal.
INTERVAL_NS = 200_000_000
# That interval doubles each time this number of poses has been stored.
THIN_AFTER = 1500
# Metres: what has moved by less is where it was.
MOVED_M = 0.005
# Radians: what has turned by less is as it was.
TURNED_RAD = 0.01

Scene = dict[str, Any]


class GoalPoses:
    """Decides which poses of one goal are stored.

    Args:
        thin_after: See `THIN_AFTER`.
    """

    def __init__(self, thin_after: int = THIN_AFTER) -> None:
        self._thin_after = thin_after
        self._count = 0
        self._slot = 0
        self._last: Scene | None = None

    def take(self, scene: Scene, source_ns: int) -> int | None:
        """Return the stamp to store a scene under, or None if it is too early or nothing has changed.

        Stamps are multiples of the interval, so that gateways that share a history store a pose once.
        """
        interval = INTERVAL_NS << (self._count // self._thin_after)
        slot = source_ns // interval * interval
        if slot <= self._slot or (self._last is not None and not differs(self._last, scene)):
            return None
        self._slot, self._last = slot, scene
        self._count += 1
        return slot


def differs(one: Scene, other: Scene) -> bool:
    """Return whether anything has moved from one scene to the other, has appeared or is gone, or has another shape."""
    if one["frame"] != other["frame"] or one["footprint"] != other["footprint"]:
        return True
    return any(_moved(one[name], other[name]) for name in ("robot", "dock", "docked", "staging"))


def _moved(one: dict[str, float] | None, other: dict[str, float] | None) -> bool:
    if one is None or other is None:
        return one is not other
    turned = abs(math.remainder(one["theta"] - other["theta"], math.tau))
    return math.hypot(one["x"] - other["x"], one["y"] - other["y"]) > MOVED_M or turned > TURNED_RAD


class PoseRecorder:
    """Stores the poses of a robot while a goal on its actions runs, also a goal of another client.

    Args:
        running: Returns the goals that run.
        owner: Returns the robot of an action.
        store: Stores an event.
    """

    def __init__(
        self,
        running: Callable[[], list[Goal]],
        owner: Callable[[str], Robot | None],
        store: Callable[[Event], None],
    ) -> None:
        self._running = running
        self._owner = owner
        self._store = store
        self._goals: dict[str, list[Goal]] = {}  # by robot
        self._poses: dict[str, GoalPoses] = {}
        self._changed: Callable[[], None] = lambda: None
        self._tasks = Tasks("recording poses")
        self._tasks.spawn(self._run())

    async def _run(self) -> None:
        while True:
            self.scan()
            await asyncio.sleep(SCAN_INTERVAL)

    def scan(self) -> None:
        """Find the running goals."""
        before, self._goals = self._goals.keys(), {}
        running = self._running()
        for goal in running:
            if (robot := self._owner(goal.action_name)) is not None:
                self._goals.setdefault(robot.namespace, []).append(goal)
        known = {goal.goal_id for goal in running}
        self._poses = {goal_id: poses for goal_id, poses in self._poses.items() if goal_id in known}
        if before != self._goals.keys():
            self._changed()

    def watched(self, topic: str) -> set[str]:
        """Return the robots that have running goals."""
        return set(self._goals)

    def on_watch(self, topic: str, changed: Callable[[], None]) -> None:
        """Register `changed`, to be called when other robots have running goals."""
        self._changed = changed

    def hear(self, robot: str, scene: Scene, source_ns: int) -> None:
        """Store a scene with the robot's running goals, if it is due."""
        for goal in self._goals.get(robot, ()):
            if goal.status.terminal:
                continue
            poses = self._poses.setdefault(goal.goal_id, GoalPoses())
            if (stamp_ns := poses.take(scene, min(source_ns, time.time_ns()))) is not None:
                self._store(pose_event(goal, scene, stamp_ns, source_ns))

    async def close(self) -> None:
        """Stop recording."""
        await self._tasks.close()
