"""The rules of latched stops: a stopped robot stays stopped until it is released.

A robot is a namespace. A stop also holds for every namespace below it.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from datetime import datetime
from types import MappingProxyType
from typing import Any

from dock_gateway.core.filters import lineage


@dataclass(frozen=True)
class Latch:
    """A latched stop.

    Attributes:
        stopped_at: When it was requested.
        by: Who requested it, if known.
        released: The robots below that were released since, of a stop of all robots.
    """

    stopped_at: datetime
    by: str | None = None
    released: tuple[str, ...] = ()


class Latches:
    """The latched stops by namespace.

    Args:
        held: The robots that are held.
        shared: Actions of several robots. Nothing tells whose goal on them is, so a stop of any robot holds for them.
        homes: The robots of actions that are not in the namespace of their robot.
    """

    def __init__(
        self,
        held: dict[str, Latch] | None = None,
        shared: Collection[str] = (),
        homes: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self.held = dict(held or {})
        self._shared = shared
        self._homes = homes

    def latch(self, namespace: str, latch: Latch) -> bool:
        """Hold a robot. If it is held already, keep the first latch and return False."""
        if namespace in self.held:
            return False
        self.held[namespace] = latch
        return True

    def renew(self, namespace: str) -> bool:
        """Hold those, too, that were released of a stop; return whether there were any."""
        latch = self.held[namespace]
        self.held[namespace] = replace(latch, released=())
        return bool(latch.released)

    def release_of(self, over: str, namespace: str) -> None:
        """Release a robot, and those below it, of the stop of a namespace above."""
        latch = self.held[over]
        self.held[over] = replace(latch, released=(*latch.released, namespace))

    def rename(self, namespace: str, by: str) -> bool:
        """Say who holds a robot that is held; return whether that is news."""
        before = self.held[namespace]
        self.held[namespace] = replace(before, by=by)
        return before.by != by

    def release(self, namespace: str) -> bool:
        """Release one robot; return False if it was not held."""
        return self.held.pop(namespace, None) is not None

    def over(self, name: str, leave_out: AbstractSet[str] = frozenset()) -> str | None:
        """Return the namespace nearest to the root whose stop holds for a namespace or an action, or None.

        Args:
            name: The namespace or the action.
            leave_out: Namespaces whose stops do not count.
        """
        if name in self._shared:
            return min(self.held.keys() - leave_out, default=None)
        names = tuple(lineage(self._homes.get(name, name)))
        held = (above for above in names if above in self.held and above not in leave_out)
        return next((above for above in held if not any(each in names for each in self.held[above].released)), None)

    def documents(self, robots: Iterable[str], places: Collection[str] = ()) -> dict[str, dict[str, Any]]:
        """Return for each robot whether a stop holds, and the held robots at or below it; ready for `orjson`.

        Args:
            robots: The robots, and namespaces that are none.
            places: The latter.
        """
        names = sorted(robots)
        below: defaultdict[str, list[str]] = defaultdict(list)
        for name in names:
            if self.over(name) is not None and name not in places:
                for above in lineage(name):
                    below[above].append(name)
        return {name: self._document(name, below[name]) for name in names}

    def _document(self, namespace: str, below: list[str]) -> dict[str, Any]:
        over = self.over(namespace)
        latch = None if over is None else self.held[over]
        return {
            "latched": latch is not None,
            "stopped_at": latch and latch.stopped_at,
            "by": latch and latch.by,
            "robots": below,
        }
