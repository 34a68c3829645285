"""The surroundings of one robot: its map, its laser scan and its path."""

import logging
from collections.abc import Callable
from typing import Any, TypeVar

from dock_gateway.core.frames import frame_name
from dock_gateway.core.graph import TRANSFORMS
from dock_gateway.core.laser import path_points, scan_points
from dock_gateway.core.scene import BASE, ODOM, Pose
from dock_gateway.extensions.maps.feed import GRID_TYPE, MapFeed
from dock_gateway.extensions.maps.pool import Pool
from dock_gateway.extensions.maps.settings import MapSettings
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.frames import STATIC, Frames
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.topic_reader import MOST_BYTES, TopicReader, find_topic
from dock_gateway.settings import Settings
from robot_io.transform import Transform
from robot_io.transform_tree import TransformError

log = logging.getLogger(__name__)

# What may be wanted of a robot.
MAP, SCAN, PATH = "map", "scan", "path"
# Seconds for which a path is shown without a newer one.
PATH_FOR = 10.0
# The most bytes of a scan: its numbers are read at once.
SCAN_BYTES = 1_000_000
P = TypeVar("P", MapFeed, Frames)
UNKNOWN_MAP: dict[str, Any] = {"topic": None, "map": None, "odom": None, "hint": "Not known yet."}


class Newest:
    """Keeps the newest message of a topic until it is taken."""

    def __init__(self) -> None:
        self._message: Received | None = None

    async def offer(self, message: Received) -> None:
        """Take a message."""
        self._message = message

    def take(self) -> Received | None:
        """Return the newest message; None if it was taken before."""
        message, self._message = self._message, None
        return message


class Surroundings:
    """Reads what is wanted of one robot.

    Args:
        robot: Its namespace.
        settings: The names of the topics.
        relays: The relayed topics.
        graph: Knows who publishes what.
        feeds: The map topics, for all robots.
        frames: The topics with transforms, for all robots.
    """

    def __init__(
        self,
        robot: str,
        *,
        settings: Settings,
        relays: Relays,
        graph: GraphCache,
        feeds: Pool[MapFeed],
        frames: Pool[Frames],
    ) -> None:
        def topic(name: str, type_name: str, most: int = MOST_BYTES) -> tuple[Newest, TopicReader]:
            newest = Newest()
            return newest, TopicReader(relays, graph, settings.resolve(name, robot), type_name, newest, most=most)

        self.feed: MapFeed | None = None
        self._preferred: MapFeed | None = None
        self._spare: MapFeed | None = None
        self._graph = graph
        self._robot = robot
        topics = settings.of(MapSettings)
        self._map_names = settings.own_or_shared(topics.map_topic, robot)
        self._frame_names = settings.own_or_shared("tf", robot)
        self._feeds = feeds
        self._pool = frames
        self._frames: Frames | None = None
        self._taken: dict[str, str] = {}  # by purpose, the topic that is in use
        self._odometry, self._odometry_reader = topic("odom", "nav_msgs/msg/Odometry")
        self._scan, self.scan_reader = topic(topics.scan_topic, "sensor_msgs/msg/LaserScan", SCAN_BYTES)
        self._path, self.path_reader = topic(topics.path_topic, "nav_msgs/msg/Path")
        self._odom, self._base = ODOM, BASE
        self._frames_known = False
        self._path_until = 0.0
        self._shown_path = _nothing(None)
        self._doubts: dict[str, str] = {}

    async def check(self, kinds: set[str]) -> None:
        """Join the topics of what is wanted, and leave the others."""
        await self._choose_map(wanted=MAP in kinds)
        self._frames = await self._use(
            "frames", self._pool, self._frames, self._frame_names, TRANSFORMS, wanted=bool(kinds)
        )
        for part in (self._preferred, self._spare, self._frames):
            if part is not None:
                await part.check()
        await self._learn_frames(wanted=bool(kinds))
        for reader, kind in ((self.scan_reader, SCAN), (self.path_reader, PATH)):
            await (reader.check() if kind in kinds else reader.close())

    async def close(self) -> None:
        """Leave all topics."""
        await self.check(set())

    async def _choose_map(self, *, wanted: bool) -> None:
        """Read the robot's own map, and that of all robots while its own is advertised and silent."""
        before = self._preferred
        preferred = await self._use("map", self._feeds, before, self._map_names, GRID_TYPE, wanted=wanted)
        others = [name for name in self._map_names if preferred is not None and name != preferred.topic]
        silent = preferred is not None and preferred is before and preferred.grid is None
        spare = await self._use(
            "spare map", self._feeds, self._spare, others, GRID_TYPE, wanted=silent and bool(others)
        )
        self._preferred, self._spare = preferred, spare
        self.feed = spare if spare is not None and spare.grid is not None else preferred

    async def _use(
        self, purpose: str, pool: Pool[P], used: P | None, names: list[str], type_name: str, *, wanted: bool
    ) -> P | None:
        """Take what is wanted out of a pool, or another one if another topic is published now."""
        suffixes = ("", STATIC) if type_name == TRANSFORMS else ("",)
        topic = await find_topic(self._graph, names, type_name, suffixes=suffixes) if wanted else None
        before = self._taken.get(purpose)
        if topic == before:
            return used
        if before is not None:
            del self._taken[purpose]
            await pool.give(before)
        if topic is None:
            return None
        self._taken[purpose] = topic
        return pool.take(topic)

    async def _learn_frames(self, *, wanted: bool) -> None:
        """Learn from one message of odometry what the robot's frames are called."""
        if (message := self._odometry.take()) is not None:
            self._frames_known = True
            try:
                odometry = message.kind.decode(message.data)
                odom, base = frame_name(odometry.header.frame_id), frame_name(odometry.child_frame_id)
            except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
                log.debug("odometry of %s cannot be read: %s", self._robot, error)
            else:
                self._odom, self._base = odom or ODOM, base or BASE
        if wanted and not self._frames_known:
            await self._odometry_reader.check()
        else:
            await self._odometry_reader.close()
            self._frames_known = wanted

    @property
    def settled(self) -> bool:
        """Whether the map is known, and where the robot is on it; or why there is none."""
        feed = self.feed
        return feed is not None and feed.settled and (feed.grid is None or self.map_document()["odom"] is not None)

    def map_document(self) -> dict[str, Any]:
        """Return the robot's map for JSON: without the cells, and where the robot's odometry begins in it."""
        feed = self.feed
        if feed is None:
            return UNKNOWN_MAP
        odom, hint = None, feed.hint
        if feed.grid is not None:
            try:
                odom = _flat(self._locate(self._odom, feed.grid.frame))
            except (TransformError, ValueError) as error:
                hint = hint or (
                    f"The map's frame '{feed.grid.frame}' has no transform to the robot's '{self._odom}': {error}."
                )
        return {
            "topic": feed.topic if feed.there else None,
            "map": None if feed.grid is None else feed.grid.document(),
            "odom": None if odom is None else odom.document(),
            "hint": hint,
        }

    def scan_document(self) -> dict[str, Any] | None:
        """Return what the laser sees, for JSON; None if nothing is new."""
        message = self._scan.take()
        if message is None:
            return _nothing(self.scan_reader.hint) if self.scan_reader.there and self.scan_reader.hint else None

        def read(scan: Any, frame: str, stamp: float) -> dict[str, Any]:
            try:
                return {"frame": ODOM, "points": scan_points(scan, self._locate(frame, self._odom, stamp))}
            except TransformError:
                return {"frame": BASE, "points": scan_points(scan, self._locate(frame, self._base, stamp))}

        return self._read(message, read)

    def path_document(self, now: float) -> dict[str, Any]:
        """Return the robot's path, for JSON. An old one is shown no more."""
        message = self._path.take()
        if message is None:
            if now >= self._path_until:
                self._shown_path = _nothing(self.path_reader.hint if self.path_reader.there else None)
            return self._shown_path
        self._path_until = now + PATH_FOR

        def read(path: Any, frame: str, _: float) -> dict[str, Any]:
            grid = self.feed and self.feed.grid
            if grid and grid.frame == frame:
                return {"frame": MAP, "points": path_points(path, Transform())}
            return {"frame": ODOM, "points": path_points(path, self._locate(frame, self._odom))}

        self._shown_path = self._read(message, read)
        return self._shown_path

    def _read(self, message: Received, read: Callable[[Any, str, float], dict[str, Any]]) -> dict[str, Any]:
        try:
            decoded = message.kind.decode(message.data)
            header = decoded.header
            frame = frame_name(header.frame_id)
            return {**read(decoded, frame, header.stamp.sec + header.stamp.nanosec / 1e9), "hint": None}
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            hint = f"{message.topic} is not shown: {error}."
            if not isinstance(error, TransformError) and self._doubts.get(message.topic) != hint:
                log.warning("%s", hint)
            self._doubts[message.topic] = hint
            return _nothing(hint)

    def _locate(self, frame: str, target: str, stamp: float = 0.0) -> Transform:
        if frame == target:
            return Transform()
        if self._frames is None:
            raise TransformError("no transforms are read yet")
        return self._frames.locate(frame, target, stamp)


def _nothing(hint: str | None) -> dict[str, Any]:
    return {"frame": None, "points": [], "hint": hint}


def _flat(transform: Transform) -> Pose:
    x, y, _ = transform.translation
    return Pose.in_plane(x, y, transform.rotation)
