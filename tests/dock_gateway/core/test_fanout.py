"""Fan-out: who gets what, and what a slow reader loses."""

import asyncio
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import Event, event_id, position_of
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter

A, B = "goal-a", "goal-b"


def feedback(number: int, goal_id: str = A) -> Event:
    return Event(f"f{number}".encode(), "goals", goal_id, "/dock", droppable=True)


def status(text: str, goal_id: str = A) -> Event:
    return Event(text.encode(), "goals", goal_id, "/dock")


def make(limit: int = 3) -> Fanout:
    return Fanout(queue_limit=limit)


async def texts(subscriber: Subscriber) -> tuple[list[str], int]:
    events, dropped = await subscriber.take(0.01)
    return [event.text for event in events], dropped


async def test_everyone_gets_what_was_asked_for() -> None:
    fanout = make()
    everything = fanout.subscribe(EventFilter(frozenset({"goals", "battery"})))
    of_b = fanout.subscribe(EventFilter(goal_id=B))
    of_fibonacci = fanout.subscribe(EventFilter(action_name="/fibonacci"))
    for event in (feedback(1), feedback(2, B), Event(b"battery", "battery", droppable=True, robot="/")):
        fanout.publish(event)
    assert await texts(everything) == (["f1", "f2", "battery"], 0)
    assert await texts(of_b) == (["f2"], 0)
    assert await texts(of_fibonacci) == ([], 0)


async def test_a_slow_reader_loses_the_oldest_feedback_and_is_told() -> None:
    fanout = make(limit=3)
    slow = fanout.subscribe(EventFilter())
    for event in (
        feedback(1),
        status("executing"),
        feedback(2),
        feedback(3),
        feedback(4),
        status("succeeded"),
        feedback(5),
    ):
        fanout.publish(event)
    assert await texts(slow) == (["executing", "f3", "f4", "succeeded", "f5"], 2)
    fanout.publish(feedback(6))
    assert await texts(slow) == (["f6"], 0)


async def test_of_scenes_only_the_newest_waits() -> None:
    fanout = make(limit=3)
    slow = fanout.subscribe(EventFilter(frozenset({"goals", "scene"})))
    for number in range(5):
        fanout.publish(Event(f"scene{number}".encode(), "scene", droppable=True, robot="/", supersedes=True))
        fanout.publish(status(f"s{number}"))
    assert await texts(slow) == (["scene4", "s0", "s1", "s2", "s3", "s4"], 0)


async def test_what_is_wished_for_is_told() -> None:
    fanout, changes = make(), []
    fanout.on_watch("scene", lambda: changes.append(fanout.watched("scene")))
    fanout.subscribe(EventFilter())
    reader = fanout.subscribe(EventFilter(frozenset({"goals", "scene"}), robot="/robot1"))
    fanout.unsubscribe(reader)
    assert changes == [{"/robot1"}, set()]


async def test_what_must_arrive_is_never_dropped_and_memory_stays_bounded() -> None:
    fanout = make(limit=1)
    stuck = fanout.subscribe(EventFilter())
    for number in range(20):
        fanout.publish(feedback(number))
    for _ in range(Subscriber.HARD_LIMIT):
        fanout.publish(status("s"))
    assert not stuck.overrun
    fanout.publish(status("one too many"))
    assert stuck.overrun
    received, dropped = await texts(stuck)
    assert received == ["f19", *["s"] * Subscriber.HARD_LIMIT]
    assert dropped == 19


async def test_after_clear_only_what_is_new_arrives() -> None:
    fanout = make()
    subscriber = fanout.subscribe(EventFilter())
    fanout.publish(feedback(1))
    subscriber.clear()
    fanout.publish(feedback(2))
    assert await texts(subscriber) == (["f2"], 0)


async def test_a_closing_fanout() -> None:
    fanout = make()
    subscriber = fanout.subscribe(EventFilter())
    fanout.unsubscribe(subscriber)
    fanout.unsubscribe(subscriber)
    waiting = fanout.subscribe(EventFilter())
    fanout.close()
    assert await waiting.take(5) == ([], 0)
    with pytest.raises(Unavailable) as refused:
        fanout.subscribe(EventFilter())
    assert refused.value.code == "shutting_down"


async def test_what_was_published_since_an_event() -> None:
    kept: list[Event] = []
    fanout = Fanout(queue_limit=3, keep=kept.append)
    events = [Event(b"", "goals", goal_id, "/dock", id=f"{number}") for number, goal_id in enumerate([A, B, A, A])]
    for event in (*events, events[1]):
        fanout.publish(event)
    assert fanout.since("0", EventFilter()) == events[1:]
    assert fanout.since("0", EventFilter(goal_id=A)) == events[2:]
    assert fanout.since("3", EventFilter()) == []
    assert fanout.since("unknown", EventFilter()) is None
    assert kept == events  # the double was not published again


async def test_the_past_is_bounded() -> None:
    fanout = Fanout(queue_limit=3, recent=5)
    for number in range(10):
        fanout.publish(Event(b"", "goals", A, "/dock", id=f"{number}"))
    assert fanout.since("4", EventFilter()) is None
    assert len(fanout.since("5", EventFilter()) or []) == 4


async def test_events_that_come_another_way_leave_the_queue() -> None:
    fanout = make()
    subscriber = fanout.subscribe(EventFilter())
    for number in range(3):
        fanout.publish(Event(f"{number}".encode(), "goals", A, "/dock", droppable=True, id=f"{number}"))
    subscriber.catch_up("1")
    assert await texts(subscriber) == (["2"], 0)


async def test_events_go_out_at_once_only_while_the_reader_waits_and_nothing_is_queued() -> None:
    fanout = make(limit=10)
    reader = fanout.subscribe(EventFilter())
    sent: list[bytes] = []
    writable = True

    class Writer:
        def write_frame(self, frame: bytes) -> bool:
            if writable:
                sent.append(frame)
            return writable

    reader.writer = Writer()
    fanout.publish(feedback(1))  # nobody waits yet: the snapshot comes first
    assert sent == []
    assert await texts(reader) == (["f1"], 0)

    taking = asyncio.create_task(reader.take(5))
    await asyncio.sleep(0)
    fanout.publish(feedback(2))
    assert sent == [feedback(2).frame]
    writable = False  # the reader's buffer is full
    fanout.publish(feedback(3))
    writable = True
    fanout.publish(feedback(4))  # must not overtake
    assert sent == [feedback(2).frame]
    events, _ = await taking
    assert [event.text for event in events] == ["f3", "f4"]
    fanout.publish(feedback(5))  # the taken ones are being sent
    assert sent == [feedback(2).frame]


def stored(number: int) -> Event:
    return Event(f"e{number}".encode(), "goals", A, "/dock", id=event_id(number, "s", A))


async def test_a_reader_that_resumes_is_not_sent_what_it_has_had_elsewhere() -> None:
    """This gateway may be a moment behind the one that the reader was at before."""
    fanout = make()
    reader = fanout.subscribe(EventFilter())
    reader.after = stored(2).id or ""
    for number in range(1, 4):
        fanout.publish(stored(number))
    assert await texts(reader) == (["e3"], 0)


async def test_an_event_of_one_robot_is_offered_only_to_those_who_want_that_robot(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fanout = make()
    one, two = (fanout.subscribe(EventFilter(frozenset({"system"}), robot=robot)) for robot in ("/robot1", "/robot2"))
    asked: list[str] = []
    covers = EventFilter.covers
    monkeypatch.setattr(EventFilter, "covers", lambda self, event: asked.append(self.robot) or covers(self, event))
    fanout.publish(Event(b"stop", "system", robot="/robot1"))
    assert asked == ["/robot1"]
    fanout.publish(Event(b"all", "system"))
    assert await texts(one) == (["stop", "all"], 0)
    assert await texts(two) == (["all"], 0)
    fanout.unsubscribe(one)
    fanout.unsubscribe(one)
    fanout.publish(Event(b"stop", "system", robot="/robot1"))
    assert await texts(one) == ([], 0)
    assert fanout.watched("system") == {"/robot2"}


async def test_events_are_counted_by_kind() -> None:
    fanout = make(limit=2)
    slow, gone = fanout.subscribe(EventFilter()), fanout.subscribe(EventFilter(goal_id=A))
    for event in (status("executing"), *(feedback(number) for number in range(4)), feedback(4, B)):
        fanout.publish(event)
    assert fanout.published == {"goals": 1, "feedback": 5}
    assert fanout.sent == {"goals": 2, "feedback": 9}
    assert fanout.dropped == 3 + 2
    fanout.unsubscribe(gone)
    fanout.unsubscribe(gone)
    assert (await texts(slow))[1] == 3
    assert fanout.dropped == 5


STATUS, FEEDBACK, SCENE, STATE = "status", "feedback", "scene", "state"


def made(kind: str, number: int) -> Event:
    text = f"{kind}{number}".encode()
    match kind:
        case "status" | "feedback":
            return Event(text, "goals", A, "/dock", droppable=kind == FEEDBACK, id=f"{number:03}")
        case _:
            return Event(text, kind, droppable=kind == SCENE, supersedes=True)


@given(
    st.lists(st.one_of(st.sampled_from([STATUS, FEEDBACK, SCENE, STATE]), st.just("take"), st.integers(0, 60))),
    st.integers(1, 4),
)
async def test_what_a_slow_reader_gets_is_what_a_plain_list_would_have(steps: list[str | int], limit: int) -> None:
    """The oldest droppable event goes, a superseded one changes in its place, an id cuts off what is before it."""
    fanout = Fanout(queue_limit=limit)
    reader = fanout.subscribe(EventFilter(frozenset({"goals", SCENE, STATE})))
    waiting: list[Event] = []
    lost = 0
    for number, step in enumerate(steps):
        if step == "take":
            assert await reader.take(0.01) == (waiting, lost)
            waiting, lost = [], 0
        elif isinstance(step, int):
            reader.catch_up(f"{step:03}")
            waiting = [each for each in waiting if each.id is None or each.id > reader.after]
        else:
            event = made(step, number)
            reader.put(event)
            if event.id is not None and event.id <= reader.after:
                continue
            same = [each for each in waiting if each.supersedes and each.topic == event.topic]
            if event.supersedes and same:
                waiting[waiting.index(same[0])] = event
                continue
            droppable = [each for each in waiting if each.droppable]
            if event.droppable and len(droppable) >= limit:
                waiting.remove(droppable[0])
                lost += 1
            waiting.append(event)
    reader.wake()
    assert await reader.take(0.01) == (waiting, lost)


def test_what_an_event_costs_does_not_depend_on_how_many_wait() -> None:
    """A hundred readers that read nothing, each with thousands of events: they slow no one down."""

    def cost(waiting: int, kind: str) -> float:
        reader = Subscriber(100, EventFilter(frozenset({"goals", SCENE})))
        for number in range(waiting):
            reader.put(status(f"{number}"))
        for number in range(100):
            reader.put(feedback(number))
        reader.put(made(SCENE, 0))
        events = [feedback(number) if kind == FEEDBACK else made(kind, number) for number in range(200)]
        began = time.thread_time()
        for event in events:
            reader.put(event)
        return time.thread_time() - began

    for kind in (FEEDBACK, SCENE):
        few, many = (min(cost(waiting, kind) for _ in range(5)) for waiting in (0, 9_000))
        assert many < 10 * few + 0.002, kind


def stamped_now(number: int) -> Event:
    identity = event_id(time.time_ns() + number, "s", A)
    return Event(b"%d" % number, "goals", A, "/dock", id=identity)


@given(before=st.integers(0, 9), after=st.integers(0, 9), kept=st.integers(1, 12))
def test_who_goes_on_from_a_position_misses_nothing_and_reads_nothing_twice(before: int, after: int, kept: int) -> None:
    """What is no longer held is read from the history, which has it under the same ids."""
    history: list[Event] = []
    fanout = Fanout(queue_limit=3, recent=kept, keep=history.append)
    for number in range(before):
        fanout.publish(stamped_now(number))
    position = fanout.position
    for number in range(before, before + after):
        fanout.publish(stamped_now(number))
    known = fanout.resolve(position)
    later = fanout.since(known, EventFilter())
    if later is None:
        assert before + after > kept
        later = [event for event in history if (event.id or "") > known]
        later = [event for event in later if position_of(event.id or "") != position]  # it may come once more
    assert [event.text for event in later] == [str(number) for number in range(before, before + after)]
