"""When robots were last stopped: no mission begins, or goes on, that nobody has let do so since."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime

from dock_gateway.core.errors import Conflict
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.storage.entries import Dependency
from dock_gateway.storage.shared_entries import SharedEntries


@dataclass(frozen=True)
class LastStop:
    """The last stop of a robot.

    Attributes:
        at: When it was last requested or released.
        requested_at: When it was last requested; None if that was not noted.
    """

    at: datetime
    requested_at: datetime | None = None


class LastStops(SharedEntries[LastStop]):
    """The last stop of each robot since when nobody has let it go on.

    A released stop starts no robot, also after a restart or at another gateway.
    """

    def note(self, robot: str, now: datetime) -> None:
        """Note a stop. It counts at once, and `sync` stores it."""
        self.put(robot, LastStop(now, now))

    def note_release(self, robot: str, now: datetime) -> None:
        """Note that a stop is released, as `note`."""
        found = self.get(robot)
        self.put(robot, LastStop(now) if found is None else replace(found, at=now))

    async def allow(self, robot: str, since: datetime) -> None:
        """Let a robot go on, unless it was stopped again since a time.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        await self.read()
        known = self.get(robot)
        if known is None or known.at > since:
            return

        def check(stored: Mapping[str, LastStop]) -> None:
            if stored.get(robot) != known:
                raise Conflict("it was stopped again")

        try:
            await self.store(robot, None, check)
        except Conflict:
            return

    def at(self, robot: str) -> datetime | None:
        """Return when a robot was last stopped or released; None if that was never noted, or it was let go on."""
        found = self.get(robot)
        return None if found is None else found.at

    def holds(self, robot: str, mission: MissionEntry) -> bool:
        """Return whether a robot was stopped since somebody last let a mission begin or go on."""
        return _is_since(self.get(robot), mission)

    def none_since(self, robot: str, mission: MissionEntry) -> Dependency:
        """Return the check that the stored stops have none of a robot for which a mission has to be held.

        It raises Conflict.
        """

        def check(stored: Mapping[str, LastStop]) -> None:
            if _is_since(stored.get(robot), mission):
                raise Conflict(f"{robot} was stopped")

        return self.dependency(check)


def _is_since(stop: LastStop | None, mission: MissionEntry) -> bool:
    return stop is not None and stop.requested_at is not None and stop.requested_at > mission.allowed_since
