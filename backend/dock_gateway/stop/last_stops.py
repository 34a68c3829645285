"""When robots were last stopped: what drives them by itself waits until a person lets it go on (ISO 3691-4)."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime

from dock_gateway.core.errors import Conflict
from dock_gateway.storage.entries import Dependency
from dock_gateway.storage.shared_entries import SharedEntries

# What the key of a release ends with, after the name of its robot, which has no space.
_RELEASED = " released"


@dataclass(frozen=True)
class LastStop:
    """A stop of a robot, or its release.

    Attributes:
        at: When it was requested.
    """

    at: datetime


class LastStops(SharedEntries[LastStop]):
    """The last stop of each robot that waits for a person.

    A released stop starts no robot, also after a restart or at another gateway.
    """

    def note(self, robot: str, now: datetime) -> None:
        """Note a stop. It counts at once, and `sync` stores it."""
        self.put(robot, LastStop(now))

    def note_release(self, robot: str, now: datetime) -> None:
        """Note that a stop is released, as `note`: beside the stop, so that it replaces none of another gateway."""
        self.put(_release_of(robot), LastStop(now))

    async def allow(self, robot: str, since: datetime | None = None) -> None:
        """Let a robot go on, unless it was stopped again since a time, or just now at another gateway.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        await self.read()
        if (stopped_at := self.at(robot)) is None or (since is not None and stopped_at > since):
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

    def all_at(self) -> dict[str, datetime]:
        """Return the robots that wait for a person, sorted by name, with the time of their last stop or release."""
        robots = {key.removesuffix(_RELEASED) for key in self.keys()}
        return {robot: at for robot in sorted(robots) if (at := self.at(robot)) is not None}

    def any_since(self, robot: str, time: datetime) -> bool:
        """Return whether a robot was stopped after a time, and still waits for a person."""
        return _is_since(self.get(robot), time)

    def none_since(self, robot: str, time: datetime) -> Dependency:
        """Return the check that the stored stops have none of a robot after a time. It raises Conflict."""

        def check(stored: Mapping[str, LastStop]) -> None:
            if _is_since(stored.get(robot), time):
                raise Conflict(f"{robot} was stopped")

        return self.dependency(check)


def _is_since(stop: LastStop | None, time: datetime) -> bool:
    return stop is not None and stop.at > time


def _release_of(robot: str) -> str:
    return robot + _RELEASED
