"""A slower reader gets the newest of each kind, and everything that must arrive."""

from dock_gateway.core.event import Event
from dock_gateway.core.throttle import Throttle


def feedback(text: str, goal_id: str = "a") -> Event:
    return Event(text.encode(), "goals", goal_id, "/dock", droppable=True)


def status(text: str) -> Event:
    return Event(text.encode(), "goals", "a", "/dock")


def texts(events: list[Event]) -> list[str]:
    return [event.text for event in events]


def test_without_a_rate_all_pass() -> None:
    throttle = Throttle(None)
    assert texts(throttle.let_through([feedback("1"), feedback("2")], 0.0)) == ["1", "2"]
    assert throttle.next_due() == float("inf")


def test_the_newest_passes_so_often() -> None:
    throttle = Throttle(2.0)
    assert texts(throttle.let_through([feedback("1"), feedback("2")], 10.0)) == ["2"]
    assert texts(throttle.let_through([feedback("3")], 10.1)) == []
    assert throttle.next_due() == 10.5
    assert texts(throttle.let_through([feedback("4")], 10.4)) == []
    assert texts(throttle.let_through([], 10.5)) == ["4"]
    assert throttle.next_due() == float("inf")


def test_each_goal_has_its_own_rate() -> None:
    throttle = Throttle(1.0)
    assert texts(throttle.let_through([feedback("a1"), feedback("b1", "b")], 0.0)) == ["a1", "b1"]


def test_what_must_arrive_passes_at_once_after_the_last_feedback() -> None:
    throttle = Throttle(1.0)
    throttle.let_through([feedback("1")], 0.0)
    events = [feedback("2"), feedback("3"), status("succeeded")]
    assert texts(throttle.let_through(events, 0.1)) == ["3", "succeeded"]
