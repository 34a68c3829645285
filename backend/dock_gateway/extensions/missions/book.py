"""The missions of all gateways that share the history: those that have not ended, which change, and the ended ones."""

import logging
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

from dock_gateway.core.cursor import Cursor, newest
from dock_gateway.core.errors import Conflict, NotFound, limit_reached
from dock_gateway.core.event import Event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.notices import Notices
from dock_gateway.extensions.missions.turns import last_order, next_order, require_turn
from dock_gateway.storage import Entries
from dock_gateway.storage.entries import Dependency
from dock_gateway.storage.shared_entries import SharedEntries

log = logging.getLogger(__name__)

# The missions that have not ended, of all robots together.
MAX_MISSIONS = 500
# Those of them that agents have asked for: people can always add theirs.
MAX_OF_AGENTS = 50
# The ended ones that are kept.
MAX_ENDED = 1000

Covers = Callable[[MissionEntry, Grant], bool]


class MissionBook(SharedEntries[MissionEntry]):
    """The missions that have not ended, by their ids, and the history of the others.

    A change is stored before it counts, and only if nobody else has made one meanwhile: several gateways may follow the
    same mission, and one of them changes it.

    Args:
        fanout: Receives an event for each change.
        store: Stores those that have not ended.
        past: Stores the ended ones.
        covers: Returns whether a grant covers a mission.

    Attributes:
        waits: What those wait for that this gateway follows, by their ids; `set_wait` changes it.
        notices: What missions have told people.
    """

    def __init__(
        self, fanout: Fanout, store: Entries[MissionEntry], past: Entries[MissionEntry], covers: Covers
    ) -> None:
        super().__init__(store)
        self._fanout = fanout
        self._past = past
        self._covers = covers
        self._seen: dict[str, int] | None = None  # the revisions whose events were published; None: nothing was read
        self.waits: dict[str, str] = {}
        self.notices = Notices()

    async def read(self) -> Mapping[str, MissionEntry]:
        """Read other gateways' changes, publish them, and return the missions that have not ended.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        for mission_id, mission in [*(await super().read()).items()]:
            if mission.status.ended:  # its gateway was killed before it was moved
                await self._move_to_past(mission_id, mission)
        missions = self.all()
        if self._seen is None:
            for mission_id, mission in (await self._past.read()).items():
                self.notices.add(mission_id, mission)
        self.notices.update(missions)
        if self._seen is not None:
            for mission_id, mission in missions.items():
                if self._seen.get(mission_id, -1) < mission.revision:
                    self._publish(mission_id, mission)
        self._seen = {mission_id: mission.revision for mission_id, mission in missions.items()}
        self.waits = {key: reason for key, reason in self.waits.items() if key in missions}
        return missions

    async def add(self, mission_id: str, mission: MissionEntry) -> MissionEntry:
        """Store a new mission; return it, or the first one as it is now if the request was sent twice.

        Raises:
            Conflict: There are too many (`limit_reached`), or the id is that of another one (`idempotency_key_reused`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        first = await self._past.get(mission_id)
        last = last_order(self.all())

        def check(stored: Mapping[str, MissionEntry]) -> None:
            nonlocal first, last
            first = first or stored.get(mission_id)
            if first is not None:
                raise Conflict("this Idempotency-Key was used for another mission", code="idempotency_key_reused")
            if len(stored) >= MAX_MISSIONS:
                raise limit_reached(MAX_MISSIONS, "missions")
            _require_room(mission, stored)
            last = last_order(stored)
            if mission.order <= last:
                raise Conflict("another gateway has queued one meanwhile")

        while True:
            mission = mission.model_copy(update={"order": next_order(last, mission.created_at)})
            try:
                await self.store(mission_id, mission, check)
            except Conflict:
                if first is not None and _is_same(first, mission):
                    return first
                if first is not None or mission.order > last:
                    raise
            else:
                self._published(mission_id, mission)
                return mission

    async def change(
        self,
        mission_id: str,
        before: MissionEntry,
        after: MissionEntry,
        allow: Callable[[Mapping[str, MissionEntry]], None] = lambda _: None,
        dependency: Dependency | None = None,
    ) -> bool:
        """Store a change, unless another one was first; return whether it was stored.

        Args:
            mission_id: The mission.
            before: As it was read.
            after: With the change.
            allow: Is given all that are stored, and raises Conflict if the change must not be made after all.
            dependency: Entries of another kind that are checked in the same transaction.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """

        def check(stored: Mapping[str, MissionEntry]) -> None:
            found = stored.get(mission_id)
            if found is None or found.revision != before.revision:
                raise Conflict("it was changed meanwhile")
            if after.active and not before.active:
                require_turn(stored, mission_id, after.its_robot)
            allow(stored)

        try:
            await self.store(mission_id, after, check, dependency)
        except Conflict:
            await self.read()
            return False
        self.waits.pop(mission_id, None)
        self.notices.add(mission_id, after)
        self._published(mission_id, after)
        if after.status.ended:
            await self._move_to_past(mission_id, after)
        if (before.status, before.step) != (after.status, after.step):
            log.info("mission %s of %s: %s, step %d", mission_id, after.robot, after.status.value, after.step)
        return True

    def set_wait(self, mission_id: str, reason: str) -> None:
        """Set what a mission waits for; another reason is an event."""
        if self.waits.get(mission_id) == reason:
            return
        self.waits[mission_id] = reason
        mission = self.get(mission_id)
        if mission is not None:
            self._publish(mission_id, mission)

    async def amend(
        self, mission_id: str, grant: Grant, revise: Callable[[MissionEntry], MissionEntry]
    ) -> MissionEntry:
        """Change a mission for a person; return it.

        Args:
            mission_id: Its id.
            grant: What the person may do.
            revise: Returns the mission with the change, or raises if that cannot be made.

        Raises:
            NotFound: There is none, or the grant does not cover it (`mission_not_found`).
            Conflict: It has ended (`mission_ended`).
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """
        while True:
            before = await self.find(mission_id, grant)
            if before.status.ended:
                raise Conflict(f"the mission is {before.status.value}", code="mission_ended")
            after = revise(before)
            if after is before or await self.change(mission_id, before, after):
                return after

    async def find(self, mission_id: str, grant: Grant = UNLIMITED) -> MissionEntry:
        """Return a mission.

        Raises:
            NotFound: There is none, or the grant does not cover it (`mission_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        mission = (await self.read()).get(mission_id) or await self._past.get(mission_id)
        if mission is None or not self._covers(mission, grant):
            raise NotFound(f"there is no mission {mission_id}", code="mission_not_found")
        return mission

    async def has(self, robot: str) -> bool:
        """Return whether there is a mission of a robot.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return any(mission.robot == robot for mission in (await self._all()).values())

    async def document(self, mission_id: str, grant: Grant) -> Mapping[str, Any]:
        """Return a mission as `GET /missions/{mission_id}` shows it.

        Raises:
            NotFound, Unavailable: As `find`.
        """
        return self.describe(mission_id, await self.find(mission_id, grant))

    async def page(
        self,
        robot: str | None,
        statuses: frozenset[MissionStatus],
        grant: Grant,
        limit: int,
        end: Cursor | None,
        *,
        since: datetime | None = None,
    ) -> tuple[list[Mapping[str, Any]], Cursor | None]:
        """Return a page of the missions of a grant, newest first, and where it ends if there are more.

        With `since`, without those that had ended before that time.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        # Those that have ended are many, and read from the database only where they are asked for.
        with_ended = not statuses or any(status.ended for status in statuses)
        missions = await self._all() if with_ended else await self.read()
        found = (
            Cursor(mission.created_at, mission_id)
            for mission_id, mission in missions.items()
            if robot in (None, mission.robot)
            and (not statuses or mission.status in statuses)
            and (since is None or mission.finished_at is None or mission.finished_at >= since)
            and self._covers(mission, grant)
        )
        places, end = newest(found, limit, end)
        return [self.describe(place.id, missions[place.id]) for place in places], end

    async def _all(self) -> Mapping[str, MissionEntry]:
        """Return all missions. One that is moved to the ended ones meanwhile is found there."""
        missions = await self.read()
        return {**missions, **await self._past.read()}

    def describe(self, mission_id: str, mission: MissionEntry) -> Mapping[str, Any]:
        """Return a mission as the API shows it."""
        return mission.document(mission_id, self.waits.get(mission_id))

    async def _move_to_past(self, mission_id: str, mission: MissionEntry) -> None:
        """Move a mission whose end is stored to the ended ones, of which those that ended first are forgotten.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); it is moved later.
        """
        self.notices.add(mission_id, mission)
        await self._past.write(mission_id, mission)
        await self.store(mission_id, None, lambda _: None)
        past = (await self._past.read()).items()
        ended = sorted((each.finished_at or each.created_at, key) for key, each in past)
        for _, oldest in ended[:-MAX_ENDED]:
            await self._past.write(oldest, None)

    def _published(self, mission_id: str, mission: MissionEntry) -> None:
        if self._seen is not None:
            self._seen[mission_id] = mission.revision
        self._publish(mission_id, mission)

    def _publish(self, mission_id: str, mission: MissionEntry) -> None:
        def narrow(document: dict[str, Any], grant: Grant) -> dict[str, Any] | None:
            return document if self._covers(mission, grant) else None

        document = {"type": "mission", "time": utc_now(), "mission": self.describe(mission_id, mission)}
        self._fanout.publish(Event(encode(document), "mission", narrow=narrow))


def _require_room(mission: MissionEntry, stored: Mapping[str, MissionEntry]) -> None:
    """Refuse the mission of an agent if there are too many of agents."""
    if mission.by_agent and sum(each.by_agent for each in stored.values()) >= MAX_OF_AGENTS:
        raise limit_reached(MAX_OF_AGENTS, "missions of agents")


def _is_same(first: MissionEntry, again: MissionEntry) -> bool:
    """Return whether two requests asked for the same mission."""

    def asked(mission: MissionEntry) -> tuple[object, ...]:
        whose = mission.robot if mission.group is None else None
        if mission.template is not None:  # which may have been changed meanwhile
            return whose, mission.group, mission.template, mission.arguments, mission.battery
        return (
            whose,
            mission.group,
            mission.name,
            mission.priority,
            mission.battery,
            [step.asked for step in mission.steps],
        )

    return asked(first) == asked(again)
