"""The client takes what only a newer gateway sends."""

import orjson
import pytest

from dock_gateway.client import documents
from dock_gateway.client.documents import Event
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalStatus, encode

NOW = utc_now()


def document(**fields: object) -> dict[str, object]:
    goal = Goal("6f1c7a52-31b5-4a3a-9a0e-6f6f5b0c0001", "/dock", "docking/action/Dock", NOW)
    return orjson.loads(encode(goal.document() | {"last_event_id": None} | fields))


@pytest.mark.parametrize("status", [*GoalStatus])
def test_a_goal_has_ended_as_its_status_says(status: GoalStatus) -> None:
    goal = documents.Goal.read(document(status=status, finished_at=NOW if status.terminal else None))
    assert goal.status is status
    assert goal.ended is status.terminal


@pytest.mark.parametrize(("finished_at", "ended"), [(None, False), (NOW, True)])
def test_a_goal_in_an_unknown_state_has_ended_when_it_is_finished(finished_at: object, ended: bool) -> None:
    read = document(status="preempted", verb="clean", origin="mission", finished_at=finished_at, colour="red")
    goal = documents.Goal.read(read)
    assert (goal.status, goal.verb, goal.origin, goal.ended) == ("preempted", "clean", "mission", ended)
    snapshot = Event.read({"type": "snapshot", "time": NOW.isoformat(), "goals": [read]})
    assert snapshot.ends_goal is ended


def test_an_unknown_event_is_passed_on() -> None:
    event = Event.read({"type": "mission", "time": NOW.isoformat(), "mission_id": "a"})
    assert (event.type, event.document["mission_id"], event.ends_goal) == ("mission", "a", False)
