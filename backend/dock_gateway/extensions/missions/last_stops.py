"""When robots were last stopped, which counts for missions that would begin by themselves: of groups and schedules."""

from dataclasses import dataclass
from datetime import datetime

from dock_gateway.storage.shared_entries import SharedEntries


@dataclass(frozen=True)
class LastStop:
    """When a stop of a robot was last requested or released."""

    at: datetime


class LastStops(SharedEntries[LastStop]):
    """The last stop of each robot since when nobody has let it go on.

    A released stop starts no robot, also after a restart or at another gateway.
    """

    def note(self, robot: str, now: datetime) -> None:
        """Note a stop, or its release. It counts at once, and `sync` stores it."""
        self.put(robot, LastStop(now))

    def allow(self, robot: str) -> None:
        """Note that somebody lets a robot go on."""
        if robot in self.keys():
            self.put(robot, None)

    def at(self, robot: str) -> datetime | None:
        """Return when a robot was last stopped or released; None if that was never noted, or it was let go on."""
        found = self.get(robot)
        return None if found is None else found.at
