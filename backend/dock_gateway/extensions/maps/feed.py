"""One map topic, for all robots that have it: the newest good map, and its image."""

import asyncio
import logging
from collections import deque

from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.maps.grid import MAX_CELLS, Grid, read_grid
from dock_gateway.extensions.maps.image import encode
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.topic_reader import TopicReader

log = logging.getLogger(__name__)

GRID_TYPE, UPDATE_TYPE = "nav_msgs/msg/OccupancyGrid", "map_msgs/msg/OccupancyGridUpdate"
# Changes of a map that wait for earlier ones; if there are more, the next whole map has them.
MAX_UPDATES = 100
# The most bytes of a message, and of all that wait.
MOST_BYTES = MAX_CELLS + 100_000


class MapFeed:
    """Reads a map topic, and `…_updates` if that is there. What cannot be right is refused; the last good map stays.

    Args:
        relays: The relayed topics.
        graph: Knows who publishes what.
        topic: Absolute name.

    Attributes:
        grid: The newest map; None before the first.
    """

    def __init__(self, relays: Relays, graph: GraphCache, topic: str) -> None:
        self.topic = topic
        self.grid: Grid | None = None
        self._problem: str | None = None
        self._whole = TopicReader(relays, graph, topic, GRID_TYPE, self, most=MOST_BYTES)
        self._parts = TopicReader(relays, graph, f"{topic}_updates", UPDATE_TYPE, self, most=MOST_BYTES)
        self._waiting: deque[Received] = deque()
        self._reading: asyncio.Task[None] | None = None
        self._encoded: tuple[Grid, asyncio.Task[bytes]] | None = None
        self._tasks = Tasks("reading a map")

    @property
    def hint(self) -> str | None:
        """The reason why there is no map, or no newer one; None if all is well."""
        none_yet = f"No map has come on {self.topic} yet." if self.grid is None else None
        return self._problem or self._whole.hint or none_yet

    @property
    def there(self) -> bool:
        """Whether the topic is published at all."""
        return self._whole.there

    @property
    def settled(self) -> bool:
        """Whether there is a map, or it is known why there is none."""
        return self.grid is not None or (self._problem or self._whole.hint) is not None

    async def check(self) -> None:
        """Join the topics if they are there."""
        await self._whole.check()
        await self._parts.check()

    async def offer(self, message: Received) -> None:
        """Take a map or a change of it; it is read in a thread."""
        if message.kind.name == GRID_TYPE:
            self._waiting.clear()
        elif len(self._waiting) >= MAX_UPDATES or sum(each.size for each in self._waiting) > MOST_BYTES:
            return
        self._waiting.append(message)
        if self._reading is None or self._reading.done():
            self._reading = self._tasks.spawn(self._read())

    async def _read(self) -> None:
        while self._waiting:
            messages = list(self._waiting)
            self._waiting.clear()
            self.grid, problem = await asyncio.to_thread(_apply, self.grid, messages)
            if problem is not None:
                problem = f"A map on {self.topic} is not used: {problem}."
                if problem != self._problem:
                    log.warning("%s", problem)
            self._problem = problem

    async def image(self) -> tuple[Grid, bytes] | None:
        """Return the newest map and the pixels of its image, encoded once for all who ask; None without a map."""
        if (grid := self.grid) is None:
            return None
        if self._encoded is None or self._encoded[0] is not grid:
            self._encoded = grid, self._tasks.spawn(asyncio.to_thread(encode, grid.cells))
        return grid, await asyncio.shield(self._encoded[1])

    async def close(self) -> None:
        """Leave the topics."""
        await self._whole.close()
        await self._parts.close()
        await self._tasks.close()


def _apply(grid: Grid | None, messages: list[Received]) -> tuple[Grid | None, str | None]:
    """Return the map after some messages, and what is wrong with the last one that cannot be used."""
    before, problem = grid, None
    for message in messages:
        try:
            decoded = message.kind.decode(message.data)
            if message.kind.name == GRID_TYPE:
                grid, problem = read_grid(decoded), None
            elif grid is not None:
                grid = grid.updated(decoded)
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            problem = str(error)
    if grid is None or grid is before:
        return before, problem
    grid = grid.signed()
    return (before if before is not None and before.revision == grid.revision else grid), problem
