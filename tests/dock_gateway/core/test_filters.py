"""Who hears of what."""

import pytest

from dock_gateway.core.event import Event
from dock_gateway.core.filters import EventFilter, WithoutFeedback

ALL = frozenset({"goals", "battery", "cmd_vel", "system"})


def goal(action: str = "/dock", goal_id: str = "a") -> Event:
    return Event(b"", "goals", goal_id, action)


@pytest.mark.parametrize(
    ("event_filter", "event", "expected"),
    [
        (EventFilter(), goal(), True),
        (EventFilter(), Event(b"", "battery", robot="/"), False),
        (EventFilter(ALL), Event(b"", "battery", robot="/"), True),
        (EventFilter(ALL), Event(b"", "battery", robot="/robot1"), False),
        (EventFilter(ALL, robot="/robot1"), Event(b"", "cmd_vel", robot="/robot1"), True),
        (EventFilter(goal_id="a"), goal(goal_id="b"), False),
        (EventFilter(ALL, goal_id="a"), Event(b"", "system", action_name="/dock"), True),
        (EventFilter(action_name="/dock"), goal("/fibonacci"), False),
        (EventFilter(ALL, action_name="/dock"), Event(b"", "system", action_name="/fibonacci"), False),
        (EventFilter(namespace="/robot1"), goal("/robot1/dock"), True),
        (EventFilter(namespace="/robot1"), goal("/robot10/dock"), False),
        (EventFilter(namespace="/robot1"), goal("/dock"), False),
        (EventFilter(namespace="/robot1"), goal("/robot1/arm/move"), True),
        (EventFilter(), Event(b"", "robots"), False),
        (EventFilter(frozenset({"robots"}), goal_id="a", namespace="/robot1"), Event(b"", "robots"), True),
        (WithoutFeedback(), goal(), True),
        (WithoutFeedback(), Event(b"", "goals", "a", "/dock", droppable=True), False),
        (WithoutFeedback(goal_id="b"), goal(), False),
        (WithoutFeedback(ALL), Event(b"", "battery", droppable=True, robot="/"), True),
    ],
)
def test_what_is_covered(event_filter: EventFilter, event: Event, expected: bool) -> None:
    assert event_filter.covers(event) is expected
