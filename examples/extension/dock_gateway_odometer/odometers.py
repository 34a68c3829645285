"""Counts the metres that each robot drives, from its odometry, and stores them."""

import asyncio
import logging
import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from dock_gateway.core.event import utc_now
from dock_gateway.core.tasks import Tasks
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import AlertKind
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.topic_reader import TopicReader
from dock_gateway.http.parts import Parts
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedEntries
from dock_gateway_odometer.settings import OdometerSettings

log = logging.getLogger(__name__)

ODOMETRY = "nav_msgs/msg/Odometry"
SERVICE_DUE = AlertKind("service_due", critical=False)
# Seconds between two checks of the robots, each of which stores what has been counted.
INTERVAL = 1.0
# Metres: a larger step is no driving, but a pose that was set.
LARGEST_STEP = 1.0


@dataclass(frozen=True)
class Distance:
    """What a robot has driven, as it is stored: a new field needs a default, and no change of the database."""

    metres: float
    due_since: datetime | None = None


class Odometer:
    """Reads the odometry of one robot."""

    def __init__(self) -> None:
        self.new_metres = 0.0
        self._last: tuple[float, float] | None = None

    async def offer(self, message: Received) -> None:
        """Take a message."""
        position = message.kind.decode(message.data).pose.pose.position
        if not (math.isfinite(position.x) and math.isfinite(position.y)):
            return
        here = position.x, position.y
        step = 0.0 if self._last is None else math.dist(here, self._last)
        self._last = here
        self.new_metres += step if step <= LARGEST_STEP else 0.0


class Odometers:
    """The odometers of all robots.

    Args:
        parts: Those of the gateway.
    """

    def __init__(self, parts: Parts) -> None:
        self._settings, self._robots = parts[Settings], parts[RobotRegistry]
        self._relays, self._graph = parts[Relays], parts[GraphCache]
        self._service_metres = 1000 * self._settings.of(OdometerSettings).odometer_service_km
        self._stored = SharedEntries(parts[History].documents("odometer", Distance))
        self._odometers: dict[str, tuple[Odometer, TopicReader]] = {}
        self._tasks = Tasks("counting metres")

    async def open(self) -> None:
        """Read what was counted before, and go on; if the history does not answer now, later."""
        await self._stored.sync()
        self._tasks.spawn(self._run())

    async def close(self) -> None:
        """Store what was counted, and leave the topics."""
        await self._tasks.close()
        await self._store()
        for _, reader in self._odometers.values():
            await reader.close()

    def metres(self, robot: str) -> float:
        """Return what a robot has driven."""
        stored = self._stored.get(robot)
        counted = self._odometers[robot][0].new_metres if robot in self._odometers else 0.0
        return (0.0 if stored is None else stored.metres) + counted

    def alerts(self) -> Iterator[Alert]:
        """Yield an alert for each robot that is due for service."""
        for robot in self._robots.namespaces():
            stored = self._stored.get(robot)
            if stored is not None and stored.due_since is not None:
                detail = f"{robot} has driven {stored.metres / 1000:.1f} km."
                yield Alert(SERVICE_DUE, robot, stored.due_since, "Due for service", detail)

    async def _run(self) -> None:
        while True:
            try:
                await self._follow_robots()
                await self._store()
            except Exception:
                log.exception("while odometers are followed")
            await asyncio.sleep(INTERVAL)

    async def _follow_robots(self) -> None:
        robots = self._robots.namespaces()
        for robot in self._odometers.keys() - set(robots):
            await self._odometers.pop(robot)[1].close()
        for robot in robots:
            if robot not in self._odometers:
                odometer = Odometer()
                topic = self._settings.resolve("odom", robot)
                reader = TopicReader(self._relays, self._graph, topic, ODOMETRY, odometer)
                self._odometers[robot] = odometer, reader
            await self._odometers[robot][1].check()

    async def _store(self) -> None:
        changed = [robot for robot, (odometer, _) in self._odometers.items() if odometer.new_metres]
        for robot in changed:
            odometer, stored = self._odometers[robot][0], self._stored.get(robot) or Distance(0.0)
            metres, odometer.new_metres = stored.metres + odometer.new_metres, 0.0
            due = stored.due_since or (utc_now() if metres >= self._service_metres else None)
            self._stored.put(robot, Distance(metres, due))
        if changed and not await self._stored.sync():
            log.warning("the metres are not stored yet: the history does not answer")

    def document(self, robot: str) -> dict[str, Any]:
        """Return what `GET /odometer` answers."""
        return {"robot": robot, "metres": self.metres(robot)}
