"""Moves missions in their queue: stored one after the other, each only if the queue is still what it was."""

from collections.abc import Callable, Mapping

from dock_gateway.core.errors import Conflict
from dock_gateway.core.grant import Grant
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.turns import Members, place

Changes = list[tuple[str, MissionEntry]]


async def move(
    book: MissionBook, mission_id: str, other_id: str, grant: Grant, members: Members, *, before: bool
) -> MissionEntry:
    """Put a mission right before or behind another one of its queue, whose priority it gets; return it.

    Args:
        book: The missions.
        mission_id: That which is moved.
        other_id: The other one.
        grant: What the person may do, who sees both.
        members: Returns the robots of a group.
        before: Whether it goes before the other one.

    Raises:
        Conflict: One of them has begun (`mission_begun`), the first has ended (`mission_ended`), or they are in
            different queues (`other_queue`).
        NotFound: `mission_not_found`.
        Unavailable: The history does not answer (`history_unavailable`).
    """

    def find(missions: Mapping[str, MissionEntry]) -> Changes:
        return place(missions, mission_id, other_id, members, before=before)

    while True:
        found = await book.find(mission_id, grant)
        await book.find(other_id, grant)
        if found.status.ended:
            raise Conflict(f"the mission is {found.status.value}", code="mission_ended")
        changes = find(book.all())
        if await _make(book, changes, find):
            return changes[-1][1] if changes else found


async def _make(book: MissionBook, changes: Changes, find: Callable[[Mapping[str, MissionEntry]], Changes]) -> bool:
    """Make changes one after the other; return False as soon as one cannot be made.

    Args:
        book: The missions.
        changes: The missions with the changes.
        find: Returns the changes that are left, given what is stored.
    """
    for index, (key, after) in enumerate(changes):
        left = _places(changes[index:])

        def allow(stored: Mapping[str, MissionEntry], left: object = left) -> None:
            if _places(find(stored)) != left:
                raise Conflict("the queue was changed meanwhile")

        known = book.get(key)
        if known is None or not await book.change(key, known, after, allow):
            return False
    return True


def _places(changes: Changes) -> list[tuple[str, int, int, int]]:
    """Return where changes put missions."""
    return [(key, each.priority, each.order, each.revision) for key, each in changes]
