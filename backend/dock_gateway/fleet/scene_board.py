"""Collects the scenes of all robots, and publishes them together."""

import asyncio
import logging
import time
from collections.abc import Callable

from dock_gateway.core.event import overview_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.narrowing import by_robot
from dock_gateway.core.tasks import Tasks
from dock_gateway.fleet.pose_recorder import Scene, differs

log = logging.getLogger(__name__)

TOPIC = "scenes"
NARROW = by_robot(TOPIC)
INTERVAL = 0.2  # seconds between two events
# Seconds between two events while nothing moves, for readers that have just come.
REPEAT = 1.0
# Seconds for which a robot without a new pose is still shown.
SHOWN_FOR = 2.0


class SceneBoard:
    """Publishes the scenes of all robots in one event, encoded once, while there are subscribers.

    Args:
        fanout: Receives the events, and knows the subscribers.
        robots: Returns the names of all robots.
    """

    def __init__(self, fanout: Fanout, robots: Callable[[], list[str]]) -> None:
        self._fanout = fanout
        self._robots = robots
        self._wanted: set[str] = set()
        self._heard: dict[str, tuple[Scene, float]] = {}  # with the time of the scan before
        self._published: dict[str, Scene] = {}
        self._now = self._due = 0.0  # on the monotonic clock
        self._changed: Callable[[], None] = lambda: None
        self._tasks = Tasks("publishing scenes")
        self._tasks.spawn(self._run())

    async def _run(self) -> None:
        while True:
            try:
                self.scan(time.monotonic())
            except Exception:
                log.exception("while publishing the scenes of all robots")
            await asyncio.sleep(INTERVAL)

    def watched(self, topic: str) -> set[str]:
        """Return the robots whose scenes are wanted: all or none."""
        return self._wanted

    def on_watch(self, topic: str, changed: Callable[[], None]) -> None:
        """Register `changed`, to be called when other robots are wanted."""
        self._changed = changed

    def hear(self, robot: str, scene: Scene, source_ns: int) -> None:
        """Take up a robot's scene."""
        self._heard[robot] = scene, self._now

    def scan(self, now: float) -> None:
        """Find the robots that are wanted, and publish their scenes if something has moved or it is time."""
        self._now = now
        wanted = set(self._robots()) if self._fanout.watched(TOPIC) else set()
        if not self._wanted:
            self._heard, self._published, self._due = {}, {}, now + REPEAT
        if wanted != self._wanted:
            self._wanted = wanted
            self._changed()
        if not wanted:
            return
        heard = sorted(self._heard.items())
        scenes = {robot: scene for robot, (scene, at) in heard if robot in wanted and now - at <= SHOWN_FOR}
        if now >= self._due or self._moved(scenes):
            self._published, self._due = scenes, now + REPEAT
            self._fanout.publish(overview_event(TOPIC, scenes, utc_now(), NARROW))

    def _moved(self, scenes: dict[str, Scene]) -> bool:
        before = self._published
        return scenes.keys() != before.keys() or any(differs(before[robot], scenes[robot]) for robot in scenes)

    async def close(self) -> None:
        """Stop publishing."""
        await self._tasks.close()
