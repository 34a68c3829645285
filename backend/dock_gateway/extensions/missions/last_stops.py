"""When robots were last stopped: no mission begins, or goes on, that nobody has let do so since."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime

from dock_gateway.core.errors import Conflict
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.storage.entries import Dependency
from dock_gateway.storage.shared_entries import SharedEntries


@dataclass(frozen=True)
class LastStop:
    """A stop of a robot, or its release.

    Attributes:
        at: When it was requested.
    """

    at: datetime


class LastStops(SharedEntries[LastStop]):
    """The last stop of each robot since when nobody has let it go on.

    A released stop starts no robot, also after a restart or at another gateway.
    """

    def note(self, robot: str, now: datetime) -> None:
        """Note a stop. It counts at once, and `sync` stores it."""
        self.put(robot, LastStop(now))

    def note_release(self, robot: str, now: datetime) -> None:
        """Note that a stop is released, as `note`: beside the stop, so that it replaces none of another gateway."""
        self.put(_release_of(robot), LastStop(now))

    async def allow(self, robot: str, since: datetime) -> None:
        """Let a robot go on, unless it was stopped again since a time.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        await self.read()
        if (stopped_at := self.at(robot)) is None or stopped_at > since:
            return
        for key in (robot, _release_of(robot)):
            with suppress(Conflict):
                await self._remove(key, self.get(key))

    async def _write(self, key: str, entry: LastStop | None) -> None:
        def check(stored: Mapping[str, LastStop]) -> None:
            if entry is not None and key in stored and stored[key].at > entry.at:
                raise Conflict("a later one is stored")

        with suppress(Conflict):
            await self._store.write(key, entry, check)

    async def _remove(self, key: str, known: LastStop | None) -> None:
        def check(stored: Mapping[str, LastStop]) -> None:
            if stored.get(key) != known:
                raise Conflict("it was stopped again")

        if known is not None:
            await self.store(key, None, check)

    def at(self, robot: str) -> datetime | None:
        """Return when a robot was last stopped or released; None if that was never noted, or it was let go on."""
        noted = (self.get(robot), self.get(_release_of(robot)))
        return max((each.at for each in noted if each is not None), default=None)

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
    return stop is not None and stop.at > mission.allowed_since


def _release_of(robot: str) -> str:
    return f"{robot} released"
