"""The places of all gateways that share the history."""

import logging
from typing import Any

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.missions.places.place import PlaceEntry
from dock_gateway.extensions.missions.step_entry import StepEntry
from dock_gateway.extensions.missions.step_kinds import Waypoint
from dock_gateway.storage.shared_entries import SharedBook

log = logging.getLogger(__name__)

MAX_PLACES = 500
# How many ids an error names.
NAMED = 10


class Places:
    """The places.

    Args:
        book: Stores them.
    """

    def __init__(self, book: SharedBook[PlaceEntry]) -> None:
        self._book = book

    async def documents(self) -> list[dict[str, Any]]:
        """Return the places as `GET /places` shows them, by id.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return [self._document(place_id, place) for place_id, place in sorted((await self._book.read()).items())]

    async def document(self, place_id: str) -> dict[str, Any]:
        """Return a place as `GET /places/{place_id}` shows it.

        Raises:
            NotFound: `place_not_found`.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return self._document(place_id, await self._book.find(place_id))

    async def replace(
        self, place_id: str, place: PlaceEntry, condition: Condition = UNCONDITIONAL
    ) -> tuple[dict[str, Any], bool]:
        """Store a place, new or changed; return it, and whether it is new.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            Conflict: `limit_reached`.
            Unavailable: The history does not answer (`history_unavailable`); the place is what it was.
        """
        new = await self._book.replace(place_id, place, condition=condition)
        log.info("place %s: %g, %g in %s, by %s", place_id, place.x, place.y, place.frame, place.changed_by)
        return self._document(place_id, place), new

    async def remove(self, place_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a place.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: `place_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the place is still there.
        """
        await self._book.remove(place_id, condition)
        log.info("place %s removed", place_id)

    async def pose_of(self, step: StepEntry) -> Waypoint | None:
        """Return where the place of a step is; None if it has none, or there is no such place.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        if step.place is None:
            return None
        place = (await self._book.read()).get(step.place)
        return None if place is None else place.pose

    async def require(self, step: StepEntry, path: str) -> StepEntry:
        """Return a step with the pose of its place, if it drives to one.

        Args:
            step: The step.
            path: Where it is in a request, for errors.

        Raises:
            InvalidField: There is no such place.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        if step.place is None:
            return step
        pose = await self.pose_of(step)
        if pose is None:
            known = sorted(self._book.keys())
            named = ", ".join(known[:NAMED]) + (", …" if len(known) > NAMED else "")
            expected = f"the id of a place: {named}" if known else "the id of a place; there is none yet"
            raise InvalidField([FieldError(f"{path}.navigate.place", expected, f"got {step.place!r}")])
        return step.model_copy(update={"drives_to": pose})

    def _document(self, place_id: str, place: PlaceEntry) -> dict[str, Any]:
        return {"id": place_id, "etag": self._book.etag(place), **place.model_dump()}
