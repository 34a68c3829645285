"""How far robots are from docks, by their transforms, which are read only while a goal asks for the nearest dock."""

import asyncio
import math
import time
from collections.abc import Mapping

from dock_gateway.core.graph import TRANSFORMS
from dock_gateway.core.scene import BASE
from dock_gateway.extensions.chargers.dock import DockPose
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.frames import STATIC, Frames
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.topic_reader import find_topic, published_types
from dock_gateway.settings import Settings
from robot_io.transform_tree import TransformError

# Seconds that a goal waits for the transforms of its robot, and between two looks at them.
WITHIN = 1.5
LOOK = 0.05


class Distances:
    """Measures how far a robot is from docks.

    Args:
        settings: The names of the robots' topics.
        relays: The relayed topics.
        graph: Knows who publishes what.
    """

    def __init__(self, settings: Settings, relays: Relays, graph: GraphCache) -> None:
        self._settings = settings
        self._relays = relays
        self._graph = graph

    async def measure(self, robot: str, docks: Mapping[str, DockPose]) -> dict[str, float]:
        """Return the distances between a robot and some docks, in metres, of those for which it is known within 1.5 s.

        Args:
            robot: Its namespace.
            docks: Where a docked robot stands at each.

        Raises:
            GatewayError: The graph cannot be read.
        """
        names = self._settings.own_or_shared("tf", robot)
        topic = await find_topic(self._graph, names, TRANSFORMS, suffixes=("", STATIC))
        if not await published_types(self._graph, topic, f"{topic}{STATIC}"):
            return {}
        # Robots that share a topic have frames of their own.
        bases = (BASE, f"{robot.strip('/')}/{BASE}")
        frames = Frames(self._relays, self._graph, topic)
        until = time.monotonic() + WITHIN
        try:
            await frames.check()
            while True:
                distances = {name: _distance(frames, bases, pose) for name, pose in docks.items()}
                found = {name: distance for name, distance in distances.items() if distance is not None}
                if len(found) == len(docks) or time.monotonic() > until:
                    return found
                await asyncio.sleep(LOOK)
        finally:
            await frames.close()


def _distance(frames: Frames, bases: tuple[str, ...], pose: DockPose) -> float | None:
    for base in bases:
        try:
            x, y, _ = frames.locate(base, pose.frame.removeprefix("/")).translation
        except TransformError:
            continue
        return math.hypot(x - pose.x, y - pose.y)
    return None
