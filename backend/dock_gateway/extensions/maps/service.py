"""The maps, scans and paths of all robots, read only while a stream or a request asks for them."""

import asyncio
import logging
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from dock_gateway.core.errors import GatewayError, NotFound
from dock_gateway.core.event import overview_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.narrowing import by_robot
from dock_gateway.core.tasks import cancel
from dock_gateway.extensions.maps.events import surroundings_event
from dock_gateway.extensions.maps.feed import MapFeed
from dock_gateway.extensions.maps.pool import Pool
from dock_gateway.extensions.maps.surroundings import MAP, PATH, SCAN, Surroundings
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.frames import Frames
from dock_gateway.graph.relays import Relays
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

# The maps of all robots in one event.
MAPS = "maps"
NARROW = by_robot(MAPS)
# Seconds between two events of a scan.
TICK = 0.2
# Seconds between two checks for the topics of a robot.
CHECK_INTERVAL = 1.0
# Seconds between two events of what has not changed, for readers that have just come.
REPEAT = 2.0
# Seconds for which a topic is still read after its last stream has ended.
LINGER = 3.0
# Seconds for which a topic is read after a request.
ASKED = 15.0
# Seconds that a request waits for the first map.
WAIT = 3.0


class Maps:
    """Publishes maps, scans and paths to the streams that want them, and has the newest maps for requests.

    Args:
        settings: The names of the topics.
        relays: The relayed topics.
        graph: Knows who publishes what.
        fanout: Receives the events, and knows the subscribers.
        robots: Returns the names of all robots.
    """

    def __init__(
        self, settings: Settings, relays: Relays, graph: GraphCache, fanout: Fanout, robots: Callable[[], list[str]]
    ) -> None:
        self._fanout = fanout
        self._robots = robots
        feeds = Pool(lambda topic: MapFeed(relays, graph, topic))
        frames = Pool(lambda topic: Frames(relays, graph, topic))
        self._make = partial(Surroundings, settings=settings, relays=relays, graph=graph, feeds=feeds, frames=frames)
        self._views: dict[str, Surroundings] = {}
        self._until: dict[tuple[str, str], float] = {}
        self._checked: dict[str, tuple[float, set[str]]] = {}  # when, and what was wanted
        self._sent: dict[tuple[str, str], tuple[object, float]] = {}
        self._changed = asyncio.Event()
        self._task = asyncio.create_task(self._run())
        for topic in (MAP, SCAN, PATH, MAPS):
            fanout.on_watch(topic, self._changed.set)

    async def surroundings(self, robot: str) -> Surroundings:
        """Return what is known of a robot's map, which is read for a while from now on.

        Raises:
            NotFound: There is no map (`map_not_found`); the error says why.
        """
        began = time.monotonic()
        self._until[robot, MAP] = began + ASKED
        self._changed.set()
        while (view := self._views.get(robot)) is None or not view.settled:
            if time.monotonic() - began > WAIT:
                break
            await asyncio.sleep(TICK / 4)
        if view is None or view.feed is None or view.feed.grid is None:
            hint = None if view is None else view.map_document()["hint"]
            raise NotFound(f"there is no map of {robot}: {hint or 'its topics are not read'}", code="map_not_found")
        return view

    async def _run(self) -> None:
        while True:
            self._changed.clear()
            try:
                await self._check(time.monotonic())
            except Exception:
                log.exception("while reading maps")
                await asyncio.sleep(CHECK_INTERVAL)
            with suppress(TimeoutError):
                async with asyncio.timeout(TICK if self._until else None):
                    await self._changed.wait()

    def _wanted(self, now: float) -> dict[str, set[str]]:
        known = self._robots()
        for kind in (MAP, SCAN, PATH):
            for robot in self._fanout.watched(kind):
                self._until[robot, kind] = max(now + LINGER, self._until.get((robot, kind), 0.0))
        for robot in known if self._fanout.watched(MAPS) else ():
            self._until[robot, MAP] = max(now + LINGER, self._until.get((robot, MAP), 0.0))
        self._until = {key: until for key, until in self._until.items() if until > now and key[0] in known}
        wanted: defaultdict[str, set[str]] = defaultdict(set)
        for robot, kind in self._until:
            wanted[robot].add(kind)
        return wanted

    async def _check(self, now: float) -> None:
        wanted = self._wanted(now)
        for robot in self._views.keys() - wanted.keys():
            await self._views.pop(robot).close()
            del self._checked[robot]
        for robot, kinds in wanted.items():
            view = self._views.setdefault(robot, self._make(robot))
            at, before = self._checked.get(robot, (0.0, set()))
            if kinds != before or now - at >= CHECK_INTERVAL:
                self._checked[robot] = now, kinds
                try:
                    await view.check(kinds)
                except GatewayError as error:
                    log.warning("cannot read the surroundings of %s: %s", robot, error.detail)
            self._show(robot, view, now)
        self._show_all(now)
        self._sent = {key: sent for key, sent in self._sent.items() if key[1] in self._views or key[0] == MAPS}

    def _show(self, robot: str, view: Surroundings, now: float) -> None:
        if robot in self._fanout.watched(MAP):
            document = view.map_document()
            if self._due(MAP, robot, document, now):
                self._tell(MAP, robot, document, document["topic"])
        if robot in self._fanout.watched(SCAN):
            scan = view.scan_document()
            if scan is not None and (scan["points"] or self._due(SCAN, robot, scan, now)):
                self._tell(SCAN, robot, scan, view.scan_reader.topic)
        if robot in self._fanout.watched(PATH):
            path = view.path_document(now)
            if self._due(PATH, robot, path, now):
                self._tell(PATH, robot, path, view.path_reader.topic)

    def _show_all(self, now: float) -> None:
        if not self._fanout.watched(MAPS):
            return
        documents = {robot: view.map_document() for robot, view in sorted(self._views.items())}
        found = {robot: document for robot, document in documents.items() if document["map"] is not None}
        if self._due(MAPS, "", found, now):
            self._fanout.publish(overview_event(MAPS, found, utc_now(), NARROW))

    def _due(self, kind: str, robot: str, document: object, now: float) -> bool:
        """Return whether something is to be sent: it has changed, or it is time to repeat it."""
        before, at = self._sent.get((kind, robot), (None, 0.0))
        if document == before and now - at < REPEAT:
            return False
        self._sent[kind, robot] = document, now
        return True

    def _tell(self, kind: str, robot: str, document: dict[str, Any], topic: str | None) -> None:
        self._fanout.publish(surroundings_event(kind, document, utc_now(), robot=robot, source=topic))

    async def close(self) -> None:
        """Leave all topics."""
        await cancel(self._task)
        for view in self._views.values():
            await view.close()
