"""Events are encoded once, and their ids sort as they happened."""

import time
from datetime import UTC, datetime

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.event import (
    Event,
    EventClock,
    event_id,
    feedback_event,
    moment,
    nanoseconds,
    notice,
    result_event,
    robot_event,
    stamp_of,
    status_event,
    system_event,
)
from dock_gateway.core.goal import Goal, GoalStatus

NOW = datetime(2026, 11, 21, tzinfo=UTC)
STAMP = 1_795_234_054_172_405_212


def make() -> Goal:
    return Goal("3f0c8a52-0000-4000-8000-000000000000", "/dock", "pkg/action/Dock", NOW)


@pytest.mark.parametrize("stamp", [0, 999, 1_795_234_054_172_405_999, 1_795_234_054_172_406_000, 4 * 10**18 + 1])
def test_a_time_is_never_after_its_stamp(stamp: int) -> None:
    assert 0 <= stamp - nanoseconds(moment(stamp)) < 1000


def test_ids_sort_by_time_and_tell_whose_they_are() -> None:
    assert event_id(9, "f", "3f0c8a52-0000") < event_id(10, "f", "3f0c8a52-0000")
    assert event_id(STAMP, "f", "3f0c8a52-0000").endswith("-f-3f0c8a52-0000")


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
    battery = robot_event("battery", {"state": {"voltage": 2.16}}, STAMP)
    assert battery.topic == "battery"
    assert orjson.loads(battery.data)["battery"] == {"state": {"voltage": 2.16}}
    system = system_event("action_server", {"available": True}, NOW)
    assert orjson.loads(system.data) == {
        "type": "action_server",
        "time": "2026-11-21T00:00:00Z",
        "action_server": {"available": True},
    }
    assert orjson.loads(notice("dropped", NOW, count=3).data)["count"] == 3


@given(st.lists(st.integers(0, 2 * 10**18), min_size=1))
def test_ids_grow_whatever_the_clocks_say(sources: list[int]) -> None:
    clock = EventClock()
    stamps = [clock.stamp(source) for source in sources]
    assert stamps == sorted(set(stamps))


def test_a_stamp_is_that_of_the_source_where_it_can_be() -> None:
    """So that it is the same at every gateway."""
    clock = EventClock()
    for _ in range(3):
        now = time.time_ns()
        assert clock.stamp(now) == now


def test_a_clock_that_is_ahead_is_not_believed() -> None:
    clock = EventClock()
    assert clock.stamp(time.time_ns() + 10**12) <= time.time_ns()
    tomorrow = event_id(time.time_ns() + 86_400 * 10**9, "s", "goal")
    assert not clock.is_past(tomorrow)
    assert EventClock(tomorrow).stamp(1) > stamp_of(tomorrow), "this machine's clock was set back"
    assert EventClock(tomorrow).is_past(tomorrow)


def test_what_happened_has_the_same_key_at_every_gateway() -> None:
    here, there = make(), make()
    for goal, stamp in ((here, STAMP), (there, STAMP + 5)):
        goal.advance(GoalStatus.SUCCEEDED, NOW)
        first, second = status_event(goal, stamp, STAMP), result_event(goal, stamp, STAMP)
        assert (first.key, second.key) == (f"s-{goal.goal_id}", f"z-{goal.goal_id}")
        assert feedback_event(goal, stamp, STAMP).key == event_id(STAMP, "f", goal.goal_id)
    one, other = (robot_event("battery", {}, STAMP, robot=robot) for robot in ("/robot1", "/robot2"))
    assert len({one.id, other.id, one.key, other.key}) == 2


def test_states_of_a_goal_at_the_same_time_are_two_events() -> None:
    goal = make()
    keys = {status_event(goal, STAMP).key}
    for status in (GoalStatus.ACCEPTED, GoalStatus.EXECUTING):
        goal.advance(status, NOW)
        keys.add(status_event(goal, STAMP).key)
    assert len(keys) == 3


def test_what_readers_resume_from_is_the_same_for_all() -> None:
    """The history cannot store what a limited reader is shown of an event about several robots."""
    with pytest.raises(ValueError, match="must have no id"):
        Event(b"{}", "robots", id=f"{1:020d}-robots-/", narrow=lambda document, _: document)
