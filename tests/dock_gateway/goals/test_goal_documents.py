"""The documents of goals: tags, notes, and the fields of extensions."""

from collections.abc import Sequence
from typing import Any

from dock_gateway.core.goal import Goal
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.goals.goal_documents import GoalDocuments
from tests.support.history import HistoryInMemory, make_goal


async def test_a_page_is_looked_up_at_once_and_a_closed_extension_has_nothing_to_say() -> None:
    history = HistoryInMemory()
    goals = [make_goal(1), make_goal(2)]
    for goal in goals:
        history.record(goal)
    await history.notes.replace_tags("goal-0002", ["blocked"])
    documents, asked = GoalDocuments(history), []

    async def read(wanted: Sequence[Goal], grant: Grant) -> list[Any]:
        assert grant is UNLIMITED
        asked.append([goal.goal_id for goal in wanted])
        return [None, {"size": 3}]

    documents.fields |= {"picture": read, "broken": None}
    first, second = await documents.full(goals, UNLIMITED)
    assert asked == [["goal-0001", "goal-0002"]]
    assert (first["tags"], first["picture"], first["broken"]) == ((), None, None)
    assert (second["tags"], second["picture"], second["broken"]) == (("blocked",), {"size": 3}, None)
    assert documents.brief(goals[1]).items() >= dict.fromkeys(("tags", "notes", "picture", "broken")).items()
