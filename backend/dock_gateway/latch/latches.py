"""Stops that are latched: a robot that was stopped stays so until somebody releases it. The rules.

A robot is a namespace, and a stop holds for what is below it, too.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from dock_gateway.core.filters import lineage


@dataclass(frozen=True)
class Latch:
    """A stop that holds: since when, and who asked for it, where that is known."""

    since: datetime
    by: str | None = None


class Latches:
    """The latched stops by namespace."""

    def __init__(self, held: dict[str, Latch] | None = None) -> None:
        self.held = dict(held or {})

    def latch(self, namespace: str, latch: Latch) -> bool:
        """Hold a robot; False for one that is held already, which keeps the time and the name of the first."""
        if namespace in self.held:
            return False
        self.held[namespace] = latch
        return True

    def release(self, namespace: str) -> bool:
        """Let one robot go; False where it was not held."""
        return self.held.pop(namespace, None) is not None

    def over(self, name: str) -> str | None:
        """The namespace, nearest to the root, whose stop holds for a namespace or an action; None where none does."""
        return next((above for above in lineage(name) if above in self.held), None)

    def documents(self, robots: Iterable[str]) -> dict[str, dict[str, Any]]:
        """Whether a stop holds for each robot, and which at or below it are held; ready for `orjson`."""
        names = sorted(robots)
        below: defaultdict[str, list[str]] = defaultdict(list)
        for name in names:
            if self.over(name) is not None:
                for above in lineage(name):
                    below[above].append(name)
        return {name: self._document(name, below[name]) for name in names}

    def _document(self, namespace: str, below: list[str]) -> dict[str, Any]:
        over = self.over(namespace)
        latch = None if over is None else self.held[over]
        return {
            "latched": latch is not None,
            "since": latch and latch.since,
            "by": latch and latch.by,
            "robots": below,
        }
