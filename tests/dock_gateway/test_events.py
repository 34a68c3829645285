"""Events are encoded once, and their ids sort as they happened."""

from datetime import UTC, datetime

import orjson
import pytest

from dock_gateway.events import (
    event_id,
    feedback_event,
    message_event,
    moment,
    nanoseconds,
    notice,
    result_event,
    status_event,
    system_event,
)
from dock_gateway.goals import Goal, GoalStatus

NOW = datetime(2026, 11, 21, tzinfo=UTC)
STAMP = 1_795_234_054_172_405_212


def make() -> Goal:
    return Goal("3f0c8a52-0000-4000-8000-000000000000", "/dock", "pkg/action/Dock", NOW)


@pytest.mark.parametrize("stamp", [0, 999, 1_795_234_054_172_405_999, 1_795_234_054_172_406_000, 4 * 10**18 + 1])
def test_a_time_is_never_after_its_stamp(stamp: int) -> None:
    assert 0 <= stamp - nanoseconds(moment(stamp)) < 1000


def test_ids_sort_by_time_and_tell_whose_they_are() -> None:
    assert event_id(9, "f", "3f0c8a52-0000") < event_id(10, "f", "3f0c8a52-0000")
    assert event_id(STAMP, "f", "3f0c8a52-0000").endswith("-f3f0c8a52")


def test_a_feedback_event() -> None:
    goal = make()
    goal.hear(b'{"n":1}', NOW)
    event = feedback_event(goal, STAMP)
    document = orjson.loads(event.data)
    assert document == {
        "type": "feedback",
        "id": goal.last_event_id,
        "time": document["time"],
        "goal_id": goal.goal_id,
        "action_name": "/dock",
        "feedback": {"n": 1},
    }
    assert event.droppable
    assert event.text == event.data.decode()
    assert moment(STAMP).isoformat() == datetime.fromisoformat(document["time"]).isoformat()


def test_status_and_result_events_must_arrive() -> None:
    goal = make()
    goal.advance(GoalStatus.SUCCEEDED, NOW)
    goal.result = b'{"n":2}'
    status, result = status_event(goal, STAMP), result_event(goal, STAMP)
    assert not status.droppable
    assert not result.droppable
    summary = orjson.loads(status.data)
    assert summary["status"] == "succeeded"
    assert "feedback" not in summary
    assert "result" not in summary
    assert orjson.loads(result.data)["result"] == {"n": 2}


def test_topics_and_surroundings() -> None:
    battery = message_event("battery", b'{"voltage":2.16}', STAMP)
    assert battery.topic == "battery"
    assert orjson.loads(battery.data)["battery"] == {"voltage": 2.16}
    system = system_event("action_server", {"available": True}, NOW)
    assert orjson.loads(system.data) == {
        "type": "action_server",
        "time": "2026-11-21T00:00:00Z",
        "action_server": {"available": True},
    }
    assert orjson.loads(notice("dropped", NOW, count=3).data)["count"] == 3
