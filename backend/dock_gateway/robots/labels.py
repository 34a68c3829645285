"""The labels of robots: display names and groups, shared by the gateways that share a history."""

import asyncio
import logging
import unicodedata
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from dock_gateway.core.errors import Conflict, limit_reached
from dock_gateway.core.namespace import normalize_namespace
from dock_gateway.core.tasks import cancel
from dock_gateway.core.versions import UNCONDITIONAL, Condition, entity_tag
from dock_gateway.storage import Entries
from dock_gateway.storage.shared_entries import SYNC_INTERVAL, SharedEntries

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class RobotLabel:
    """The display name of a robot, and the groups that it is in."""

    display_name: str | None
    groups: tuple[str, ...]


NO_LABEL = RobotLabel(None, ())


class Labels:
    """Holds the labels, by namespace. A robot that is not on the graph can have one, too.

    Args:
        store: Stores them.
        robots: Returns the namespaces of the robots that are known now.
        most: Maximum number of labels.
        sync_interval: Seconds between two reads of what other gateways have changed.
    """

    def __init__(
        self,
        store: Entries[RobotLabel],
        robots: Callable[[], Collection[str]],
        *,
        most: int = 2000,
        sync_interval: float = SYNC_INTERVAL,
    ) -> None:
        self._entries = SharedEntries(store)
        self._robots = robots
        self._most = most
        self._sync_interval = sync_interval
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Read the labels, and keep on reading other gateways' changes."""
        await self._entries.sync()
        self._task = asyncio.create_task(self._sync())

    def get(self, robot: str) -> RobotLabel:
        """Return the label of a robot; an empty one if it has none."""
        return self._entries.get(robot) or NO_LABEL

    def robots(self) -> set[str]:
        """Return the robots that have a label."""
        return self._entries.keys()

    def in_group(self, group: str) -> set[str]:
        """Return the robots that are in a group."""
        return {robot for robot, label in self._entries.all().items() if group in label.groups}

    def etag(self, robot: str) -> str:
        """Return the entity tag of the label of a robot, also of an empty one."""
        return entity_tag(self.get(robot))

    async def replace(self, robot: str, label: RobotLabel, condition: Condition = UNCONDITIONAL) -> None:
        """Store the label of a robot; an empty one removes it.

        Raises:
            ChangedMeanwhile: The label has not the version of the condition.
            Conflict: The display name belongs to another robot (`display_name_taken`), or there are too many labels
                (`limit_reached`).
            Unavailable: The history does not answer (`history_unavailable`); the label is what it was.
        """
        known = frozenset(self._robots())

        def check(labels: Mapping[str, RobotLabel]) -> None:
            if robot in labels or not condition.absent:
                condition.require(entity_tag(labels.get(robot) or NO_LABEL))
            others = {name: other for name, other in labels.items() if name != robot}
            if label != NO_LABEL and len(others) >= self._most:
                raise limit_reached(self._most, "labels")
            if label.display_name is not None:
                _require_free(label.display_name, others, (known | others.keys()) - {robot})

        await self._entries.store(robot, None if label == NO_LABEL else label, check)
        log.info("label of %s: display name %r, groups %s", robot, label.display_name, list(label.groups))

    async def _sync(self) -> None:
        while True:
            await asyncio.sleep(self._sync_interval)
            try:
                await self._entries.sync()
            except Exception:
                log.exception("while reading the labels")

    async def close(self) -> None:
        """Stop the synchronization with the history."""
        if self._task is not None:
            await cancel(self._task)


def _require_free(display_name: str, labels: Mapping[str, RobotLabel], namespaces: Collection[str]) -> None:
    """Check that a display name is neither another robot's nor the namespace of one."""
    name = _compared(display_name)
    for robot, label in labels.items():
        if label.display_name is not None and _compared(label.display_name) == name:
            raise Conflict(f"the display name of {robot} is {label.display_name!r}", code="display_name_taken")
    for namespace in namespaces:
        if normalize_namespace(name) == _compared(namespace):
            raise Conflict(f"{display_name!r} is the namespace of the robot {namespace}", code="display_name_taken")


def _compared(name: str) -> str:
    return unicodedata.normalize("NFKC", name).casefold()
