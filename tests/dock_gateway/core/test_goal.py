"""A goal never steps back, whatever order messages come in."""

import tracemalloc
from datetime import UTC, datetime, timedelta

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.goal import FROM_ROS, Goal, GoalError, GoalStatus, encode

NOW = datetime(2026, 11, 21, 3, 32, 40, 123456, tzinfo=UTC)
S = GoalStatus


def make(status: GoalStatus = S.PENDING) -> Goal:
    return Goal("3f0c8a52-0000-4000-8000-000000000000", "/dock", "pkg/action/Dock", NOW, status=status)


def test_the_way_of_a_goal() -> None:
    goal = make()
    for step, status in enumerate((S.ACCEPTED, S.EXECUTING, S.CANCELING, S.CANCELED), 1):
        assert goal.advance(status, NOW + timedelta(seconds=step))
    assert goal.finished_at == NOW + timedelta(seconds=4)
    assert goal.updated_at == goal.finished_at


def test_old_news_are_ignored() -> None:
    goal = make(S.EXECUTING)
    assert not goal.advance(S.ACCEPTED, NOW)
    assert not goal.advance(S.EXECUTING, NOW)
    assert goal.advance(S.SUCCEEDED, NOW)
    assert not goal.advance(S.EXECUTING, NOW)
    assert not goal.advance(S.LOST, NOW)
    assert goal.status is S.SUCCEEDED


@pytest.mark.parametrize(
    ("status", "code", "unsent"),
    [
        (S.REJECTED, "action_server_unavailable", True),
        (S.REJECTED, "ros_unavailable", True),
        (S.REJECTED, "stopped", True),
        (S.REJECTED, "stop_latched", False),
        (S.REJECTED, "goal_rejected", False),
        (S.REJECTED, "history_unavailable", False),
        (S.REJECTED, "action_server_timeout", False),
        (S.CANCELED, "stopped", False),
        (S.LOST, "action_server_unavailable", False),
    ],
)
def test_whether_it_was_never_sent(status: GoalStatus, code: str, unsent: bool) -> None:
    goal = make(status)
    assert not goal.unsent
    goal.error = GoalError(code, "a sentence")
    assert goal.unsent is unsent


def test_progress_is_news_once() -> None:
    goal, later = make(S.EXECUTING), NOW + timedelta(seconds=1)
    assert goal.progress("CONTROLLING", 0, later)
    assert (goal.stage, goal.retries, goal.updated_at) == ("CONTROLLING", 0, later)
    assert not goal.progress("CONTROLLING", 0, later)
    assert not goal.progress(None, None, later)
    assert goal.progress(None, 1, later)
    assert (goal.stage, goal.retries) == ("CONTROLLING", 1)
    assert goal.document()["retries"] == 1


def test_lost_is_left_again_and_its_error_forgotten() -> None:
    goal = make(S.EXECUTING)
    assert goal.advance(S.LOST, NOW)
    goal.error = GoalError("action_server_lost", "gone")
    assert goal.finished_at == NOW
    assert goal.advance(S.EXECUTING, NOW)
    assert goal.error is None
    assert goal.finished_at is None


@given(st.lists(st.sampled_from(list(S))))
def test_nothing_follows_a_final_state(statuses: list[GoalStatus]) -> None:
    goal = make()
    ended: GoalStatus | None = None
    for status in statuses:
        goal.advance(status, NOW)
        if ended is not None:
            assert goal.status is ended
        elif goal.status.final:
            ended = goal.status
        assert (goal.finished_at is not None) == goal.status.terminal


def test_every_state_of_ros_is_known() -> None:
    assert sorted(FROM_ROS) == [1, 2, 3, 4, 5, 6]
    assert [status for status in S if status.terminal] == [S.SUCCEEDED, S.CANCELED, S.ABORTED, S.REJECTED, S.LOST]


def test_the_document_embeds_messages_as_they_are() -> None:
    goal = make()
    goal.goal = b'{"order":10}'
    goal.hear(b'{"partial_sequence":[0,1,1]}', NOW)
    document = orjson.loads(encode(goal.document()))
    assert document["goal"] == {"order": 10}
    assert document["feedback"] == {"partial_sequence": [0, 1, 1]}
    assert document["feedback_count"] == 1
    assert document["result"] is None
    assert document["created_at"] == "2026-11-21T03:32:40.123456Z"
    assert set(document) - set(goal.summary()) == {"feedback", "result"}


def test_nan_is_null() -> None:
    assert encode({"x": float("nan")}) == b'{"x":null}'


def test_what_is_encoded_takes_no_more_memory_than_it_is_long() -> None:
    """A thousand readers and a long memory live on this: encoders keep buffers that are many times as large."""
    document = make().document()
    tracemalloc.start()
    try:
        kept = [encode(document) for _ in range(100)]
        used, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert used < 1.5 * sum(map(len, kept))
