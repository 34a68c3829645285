"""When an action server is tried through another participant. tests/dock_gateway/ros/test_action_port.py does it."""

from itertools import pairwise

from dock_gateway.goals.limits import LIMITS
from dock_gateway.goals.rejoining import (
    GIVE_UP_AFTER,
    GIVE_UP_IDLE_AFTER,
    KEEP,
    LONGEST_PAUSE,
    PAUSE,
    RejoinSchedule,
)


def test_a_server_that_answers_is_left_alone() -> None:
    schedule = RejoinSchedule()
    assert not schedule.due(100, unanswered_since=None, last_heard=100, wanted=True)
    assert not schedule.due(100, unanswered_since=100 - LIMITS.unanswered_for + 1, last_heard=100, wanted=True)


def test_a_server_that_is_heard_but_does_not_answer_is_tried_another_way() -> None:
    assert RejoinSchedule().due(100, unanswered_since=90, last_heard=99, wanted=False)


def test_a_silent_server_is_tried_another_way_for_a_while() -> None:
    schedule = RejoinSchedule()
    for wanted, seconds in ((True, GIVE_UP_AFTER), (False, GIVE_UP_IDLE_AFTER)):
        assert schedule.due(99 + seconds, unanswered_since=100, last_heard=100, wanted=wanted)
        assert not schedule.due(101 + seconds, unanswered_since=100, last_heard=100, wanted=wanted)


def test_a_server_that_never_answers_is_tried_ever_more_rarely() -> None:
    """Frozen, or lying: it sends feedback and answers nothing."""
    schedule = RejoinSchedule()
    tries = []
    now = 0.0
    while now < 24 * 3600:
        if schedule.due(now, unanswered_since=-10, last_heard=now, wanted=True):
            tries.append(now)
            now += KEEP
            schedule.ended(now, answered=False)
        now += 1
    pauses = [after - before - KEEP for before, after in pairwise(tries)]
    assert pauses[:3] == [2 * PAUSE, 4 * PAUSE, 8 * PAUSE]
    assert max(pauses) == LONGEST_PAUSE
    assert len(tries) < 24 * 3600 / (KEEP + LONGEST_PAUSE) + 10


def test_a_server_that_answered_is_tried_again_soon() -> None:
    """The robot of a bad Wi-Fi has an outage every minute."""
    schedule = RejoinSchedule()
    for number in range(5):
        now = 100.0 * number
        assert schedule.due(now, unanswered_since=now - 10, last_heard=now - 10, wanted=True)
        schedule.ended(now + 20, answered=True)
        assert not schedule.due(now + 20 + PAUSE - 1, unanswered_since=now, last_heard=now, wanted=True)


def test_an_answer_after_many_tries_makes_up_for_them() -> None:
    schedule = RejoinSchedule()
    for now in range(10):
        schedule.ended(now, answered=False)
    assert not schedule.due(9 + LONGEST_PAUSE - 1, unanswered_since=0, last_heard=9 + LONGEST_PAUSE, wanted=True)
    schedule.ended(20, answered=True)
    assert schedule.due(20 + PAUSE, unanswered_since=0, last_heard=20, wanted=True)
