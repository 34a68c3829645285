"""Goals as the REST API has them: with their tags and notes, and with what extensions add."""

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Goal
from dock_gateway.core.grant import Grant
from dock_gateway.storage import GoalNotes, History

# Returns the value of a field for each of some goals, as far as a grant covers it; None where there is none.
ReadField = Callable[[Sequence[Goal], Grant], Awaitable[Sequence[object]]]
NOTHING = GoalNotes()
UNKNOWN = {"tags": None, "notes": None}


@dataclass(frozen=True)
class GoalField:
    """A field that an extension adds to the goals of the REST API. It is null where the extension has nothing to say.

    Attributes:
        name: The name of the field.
        model: The model of its value.
        read: Returns its value for each of some goals, given the part of the extension: None where there is none.
    """

    name: str
    model: type[BaseModel]
    read: Callable[[Any, Sequence[Goal], Grant], Awaitable[Sequence[object]]]


class GoalDocuments:
    """Makes the documents of goals.

    Args:
        history: Has their tags and notes.

    Attributes:
        fields: What reads the fields that extensions add, by name; None for that of one that could not be opened.
    """

    def __init__(self, history: History) -> None:
        self._history = history
        self.fields: dict[str, ReadField | None] = {}

    def brief(self, goal: Goal) -> dict[str, Any]:
        """Return a goal without a look at what others know of it: these fields are null."""
        return goal.document() | UNKNOWN | dict.fromkeys(self.fields)

    async def full(self, goals: Sequence[Goal], grant: Grant) -> list[dict[str, Any]]:
        """Return goals with all that is known of them. Tags and notes are null while the history does not answer."""
        documents = [self.brief(goal) for goal in goals]
        try:
            known = await self._history.notes.read([goal.goal_id for goal in goals])
        except Unavailable:  # goals that still run can be read without the history
            pass
        else:
            for goal, document in zip(goals, documents, strict=True):
                document.update(vars(known.get(goal.goal_id, NOTHING)))
        for name, read in self.fields.items():
            if read is None:
                continue
            for document, value in zip(documents, await read(goals, grant), strict=True):
                document[name] = value
        return documents
