"""The frames of robots, as `tf` and `tf_static` relate them."""

import asyncio
import logging
from typing import Any

from dock_gateway.core.frames import frame_name, transform_of
from dock_gateway.core.graph import TRANSFORMS
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.topic_reader import TopicReader
from robot_io.transform import Transform
from robot_io.transform_tree import TransformError, TransformTree

log = logging.getLogger(__name__)

NOW = 0.0
# Bytes of a message after which others have their turn.
LARGE = 4_000
# The suffix of the topic with the frames that never move; without it, the topic has those that move.
STATIC = "_static"


class Frames:
    """The frames that one pair of topics relates, for all robots that have it.

    Args:
        relays: The relayed topics.
        graph: Knows who publishes what.
        moving: Absolute name of the topic; that of the frames that never move ends with `STATIC`.
    """

    def __init__(self, relays: Relays, graph: GraphCache, moving: str) -> None:
        self._fixed = f"{moving}{STATIC}"
        self._tree = TransformTree()
        self._readers = [TopicReader(relays, graph, topic, TRANSFORMS, self) for topic in (moving, self._fixed)]
        self._doubted = False

    async def check(self) -> None:
        """Join the topics if they are there."""
        for reader in self._readers:
            await reader.check()

    async def offer(self, message: Received) -> None:
        """Take transforms."""
        try:
            transforms = message.kind.decode(message.data).transforms
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            self._doubt(message.topic, error)
            transforms = ()
        for stamped in transforms:
            try:
                self._add(stamped, fixed=message.topic == self._fixed)
            except ValueError as error:  # the others of the message count
                self._doubt(message.topic, error)
        if message.size > LARGE:
            await asyncio.sleep(0)

    def _add(self, stamped: Any, *, fixed: bool) -> None:
        parent, child = frame_name(stamped.header.frame_id), frame_name(stamped.child_frame_id)
        stamp = stamped.header.stamp.sec + stamped.header.stamp.nanosec / 1e9
        self._tree.add(parent, child, stamp, transform_of(stamped.transform), fixed=fixed)

    def _doubt(self, topic: str, error: Exception) -> None:
        if not self._doubted:
            self._doubted = True
            log.warning("%s: a transform is not used: it %s", topic, error)

    def locate(self, frame: str, target: str, stamp: float = NOW) -> Transform:
        """Return where a frame lies in another one: at a time, or the newest that is known if not for that time.

        Raises:
            TransformError: They are not related.
        """
        if stamp != NOW:
            try:
                return self._tree.lookup(target, frame, stamp)
            except TransformError:  # clocks may differ
                pass
        return self._tree.lookup(target, frame, NOW)

    async def close(self) -> None:
        """Leave the topics."""
        for reader in self._readers:
            await reader.close()
