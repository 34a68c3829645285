"""Stops that are latched: a robot that was stopped stays so until somebody releases it. The rules, and the file.

A robot is a namespace, and a stop holds for what is below it, too.
"""

import logging
import os
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import orjson

from dock_gateway.events import utc_now
from dock_gateway.goals import encode
from dock_gateway.namespaces import is_under

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Latch:
    """A stop that holds: since when, and who asked for it, where that is known."""

    since: datetime
    by: str | None = None


class Latches:
    """The latched stops by namespace."""

    def __init__(self, held: dict[str, Latch] | None = None) -> None:
        self.held = dict(held or {})

    def latch(self, namespace: str, latch: Latch) -> None:
        """Hold a robot; one that is held already keeps the time and the name of the first."""
        self.held.setdefault(namespace, latch)

    def release(self, namespace: str) -> None:
        """Let one robot go."""
        self.held.pop(namespace, None)

    def over(self, name: str) -> str | None:
        """The namespace, nearest to the root, whose stop holds for a namespace or an action; None where none does."""
        return min((held for held in self.held if is_under(name, held)), key=len, default=None)

    def document(self, namespace: str, robots: Iterable[str]) -> dict[str, Any]:
        """Whether a stop holds for a robot, and which of `robots`, at or below it, are held; ready for `orjson`."""
        over = self.over(namespace)
        latch = None if over is None else self.held[over]
        return {
            "latched": latch is not None,
            "since": latch and latch.since,
            "by": latch and latch.by,
            "robots": sorted(name for name in robots if is_under(name, namespace) and self.over(name) is not None),
        }


class LatchFile:
    """Keeps latched stops across a crash, and across a power cut."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def read(self, default: str) -> dict[str, Latch]:
        """What was latched. Where the file cannot be read, the robot `default` is: no stop is forgotten."""
        try:
            stops = orjson.loads(self.path.read_bytes())
            return {name: Latch(datetime.fromisoformat(stop["since"]), stop["by"]) for name, stop in stops.items()}
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            log.error("%s cannot be read, so %s counts as stopped: %r", self.path, default, error)
            return {default: Latch(utc_now())}

    def write(self, held: dict[str, Latch]) -> None:
        """Keep what is latched now; it is on the disk once this returns.

        Raises:
            OSError: The disk does not take it.
        """
        self.path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        beside = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        try:
            with beside.open("wb") as file:
                file.write(encode(held))
                file.flush()
                # First for a crash, which takes no disk, then for a power cut: one in between leaves what cannot be
                # read, and that is taken for a stop.
                beside.replace(self.path)
                os.fsync(file.fileno())
        except OSError:
            with suppress(OSError):
                beside.unlink()
            raise
        folder = os.open(self.path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
