"""Who hears of what."""

import pytest

from dock_gateway.events import Event
from dock_gateway.interest import Interest, WithoutFeedback

ALL = frozenset({"goals", "battery", "cmd_vel", "system"})


def goal(action: str = "/dock", goal_id: str = "a") -> Event:
    return Event(b"", "goals", goal_id, action)


@pytest.mark.parametrize(
    ("interest", "event", "expected"),
    [
        (Interest(), goal(), True),
        (Interest(), Event(b"", "battery", robot="/"), False),
        (Interest(ALL), Event(b"", "battery", robot="/"), True),
        (Interest(ALL), Event(b"", "battery", robot="/robot1"), False),
        (Interest(ALL, robot="/robot1"), Event(b"", "cmd_vel", robot="/robot1"), True),
        (Interest(goal_id="a"), goal(goal_id="b"), False),
        (Interest(ALL, goal_id="a"), Event(b"", "system", action_name="/dock"), True),
        (Interest(action_name="/dock"), goal("/fibonacci"), False),
        (Interest(ALL, action_name="/dock"), Event(b"", "system", action_name="/fibonacci"), False),
        (Interest(namespace="/robot1"), goal("/robot1/dock"), True),
        (Interest(namespace="/robot1"), goal("/robot10/dock"), False),
        (Interest(namespace="/robot1"), goal("/dock"), False),
        (Interest(namespace="/robot1"), goal("/robot1/arm/move"), True),
        (Interest(), Event(b"", "robots"), False),
        (Interest(frozenset({"robots"}), goal_id="a", namespace="/robot1"), Event(b"", "robots"), True),
        (WithoutFeedback(), goal(), True),
        (WithoutFeedback(), Event(b"", "goals", "a", "/dock", droppable=True), False),
        (WithoutFeedback(goal_id="b"), goal(), False),
        (WithoutFeedback(ALL), Event(b"", "battery", droppable=True, robot="/"), True),
    ],
)
def test_what_is_covered(interest: Interest, event: Event, expected: bool) -> None:
    assert interest.covers(event) is expected
