"""The order of publication: what waits for what, alone and together with other gateways."""

import orjson

from dock_gateway.core.event import NEVER, Event, EventClock, event_id, time_id
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.line import Line

A, B = "goal-a", "goal-b"


def event(number: int, goal_id: str = A, kind: str = "f") -> Event:
    identity = event_id(number, kind, goal_id)
    data = orjson.dumps({"type": kind, "id": identity, "n": number})
    return Event(data, "goals", goal_id, "/dock", id=identity, key=f"{kind}-{goal_id}")


def end(number: int, goal_id: str = A) -> list[Event]:
    return [event(number, goal_id, "s"), event(number, goal_id, "z")]


def make() -> tuple[Line, list[str]]:
    """A line, and the ids of what it has published: number, kind and goal."""
    published: list[str] = []
    return Line(EventClock(), lambda event: published.append((event.id or "").lstrip("0"))), published


def allowed(number: int) -> str:
    return time_id(number) + NEVER


def test_what_comes_later_waits_behind_what_is_being_stored() -> None:
    fanout = Fanout(queue_limit=3)
    line, published = fanout.line, fanout.published
    fanout.publish(event(1))
    first, second = line.reserve(2), line.reserve(3)
    fanout.publish(event(4))
    fanout.publish(Event(b"stop", "system"))  # it has no place in the order
    assert (published["goals"], published["system"], len(line)) == (1, 1, 3)
    second.release([event(3)])
    assert published["goals"] == 1
    first.release([event(2)])
    assert (published["goals"], len(line)) == (4, 0)
    later = fanout.since(event(1).id or "", EventFilter()) or []
    assert [orjson.loads(each.data)["n"] for each in later] == [2, 3, 4]


def test_events_wait_until_they_are_allowed_and_ends_come_at_their_place() -> None:
    line, published = make()
    line.allow([], allowed(2))
    for number in (1, 2, 3, 5):
        line.put(event(number))
    assert published == ["1-f-goal-a", "2-f-goal-a"]
    line.allow(end(4, B), allowed(4))
    assert published[2:] == ["3-f-goal-a", "4-s-goal-b", "4-z-goal-b"]
    line.allow([], None)
    assert published[5:] == ["5-f-goal-a"]


def test_an_end_is_published_once_and_nothing_after_it() -> None:
    line, published = make()
    line.allow(end(4), allowed(9))
    line.allow(end(4), allowed(9))
    line.publish_stored(end(3), end(4))
    line.publish_stored(end(3), None)
    line.put(event(5))
    line.put(event(6, B))
    assert published == ["4-s-goal-a", "4-z-goal-a", "6-f-goal-b"]


def test_an_end_that_is_not_stored_comes_after_all_that_was_published() -> None:
    clock, published = EventClock(), list[Event]()
    line = Line(clock, published.append)
    last = clock.stamp(0)
    line.put(event(last, B))
    assert line.publish_stored(end(3), None) == published[1:]
    assert [orjson.loads(each.data)["id"] for each in published] == [each.id for each in published]
    assert (published[1].id or "") > time_id(last)


def test_events_after_an_end_from_the_future_are_stamped_later() -> None:
    clock = EventClock()
    ahead = clock.stamp(0) + 10**12
    Line(clock, lambda _: None).allow(end(ahead), allowed(ahead))
    assert clock.stamp(0) > ahead


def test_permission_is_asked_for_only_when_it_may_soon_be_needed() -> None:
    line, _ = make()
    asked: list[int] = []
    line.on_want.append(lambda: asked.append(1))
    line.put(event(1))
    line.allow([], allowed(9))
    line.put(event(2))
    line.publish_stored([], end(3))
    assert asked == [], "it was given just now"
    line.publish_stored([], end(10, B))
    assert asked == [1]
    line.put(event(11, "goal-c"))
    assert asked == [1, 1]
