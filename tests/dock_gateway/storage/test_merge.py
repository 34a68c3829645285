"""Two accounts of one goal become one, the same one whichever comes first."""

from copy import copy
from datetime import timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.storage.merge import RANK, merge
from tests.support.history import NOW, make_goal

times = st.integers(0, 3).map(lambda seconds: NOW + timedelta(seconds=seconds))
messages = st.sampled_from([None, b'{"a":1}', b'{"a":2}'])


@st.composite
def accounts(draw: st.DrawFn) -> Goal:
    status = draw(st.sampled_from(GoalStatus))
    goal = make_goal(1, status)
    goal.origin = draw(st.sampled_from(["gateway", "external"]))
    goal.goal, goal.feedback, goal.result = draw(messages), draw(messages), draw(messages)
    goal.error = draw(st.sampled_from([None, GoalError("goal_aborted", ""), GoalError("action_server_lost", "")]))
    goal.stage, goal.retries = draw(st.sampled_from([None, "RETRY"])), draw(st.sampled_from([None, 0, 1]))
    goal.created_at, goal.updated_at = draw(times), draw(times)
    goal.finished_at = draw(times) if status.terminal else None
    goal.stalled = not status.terminal and draw(st.booleans())
    goal.feedback_count = draw(st.integers(0, 3))
    goal.last_event_id = draw(st.sampled_from([None, "1", "2"]))
    return goal


def facts(goal: Goal) -> dict[str, object]:
    return {name: getattr(goal, name) for name in Goal.__slots__}


@given(accounts())
def test_merging_twice_changes_nothing(goal: Goal) -> None:
    assert facts(merge(goal, goal)) == facts(goal)


@given(accounts(), accounts())
def test_what_was_merged_may_come_again(stored: Goal, news: Goal) -> None:
    once = merge(stored, news)
    assert facts(merge(once, news)) == facts(once)


@given(accounts(), accounts())
def test_nothing_known_is_lost(stored: Goal, news: Goal) -> None:
    merged = merge(stored, news)
    for name in ("goal", "feedback", "result", "last_event_id", "stage", "retries"):
        if getattr(stored, name) is not None or getattr(news, name) is not None:
            assert getattr(merged, name) is not None
    assert merged.feedback_count == max(stored.feedback_count, news.feedback_count)
    assert (merged.origin == "gateway") == ("gateway" in (stored.origin, news.origin))


@given(accounts(), accounts())
def test_the_status_moves_forward(stored: Goal, news: Goal) -> None:
    status = merge(stored, news).status
    if stored.status.final:
        assert status is stored.status
    elif stored.status is not GoalStatus.LOST:
        assert RANK[status] >= RANK[stored.status]
    if news.status.final:
        assert status.final


@given(accounts(), accounts())
def test_the_order_does_not_matter(one: Goal, other: Goal) -> None:
    if one.status.final and other.status.final and one.status is not other.status:
        return  # an action server never says both
    if one.updated_at == other.updated_at:
        return
    assert merge(one, other).status is merge(other, one).status
    assert merge(one, other).origin == merge(other, one).origin
    assert merge(one, other).created_at == merge(other, one).created_at
    assert merge(one, other).feedback == merge(other, one).feedback


@given(accounts(), accounts())
def test_the_accounts_themselves_stay(stored: Goal, news: Goal) -> None:
    before = facts(copy(stored)), facts(copy(news))
    merge(stored, news)
    assert (facts(stored), facts(news)) == before


@pytest.mark.parametrize(
    ("stored", "news", "seconds", "expected"),
    [
        (GoalStatus.EXECUTING, GoalStatus.ACCEPTED, 1, GoalStatus.EXECUTING),
        (GoalStatus.LOST, GoalStatus.EXECUTING, 1, GoalStatus.EXECUTING),
        (GoalStatus.LOST, GoalStatus.EXECUTING, -1, GoalStatus.LOST),
        (GoalStatus.EXECUTING, GoalStatus.LOST, 1, GoalStatus.LOST),
        (GoalStatus.EXECUTING, GoalStatus.LOST, -1, GoalStatus.EXECUTING),
        (GoalStatus.LOST, GoalStatus.SUCCEEDED, -1, GoalStatus.SUCCEEDED),
        (GoalStatus.SUCCEEDED, GoalStatus.LOST, 1, GoalStatus.SUCCEEDED),
        (GoalStatus.CANCELED, GoalStatus.ABORTED, 1, GoalStatus.CANCELED),
    ],
)
def test_states(stored: GoalStatus, news: GoalStatus, seconds: int, expected: GoalStatus) -> None:
    later = make_goal(1, news, updated_at=NOW + timedelta(seconds=seconds))
    assert merge(make_goal(1, stored, updated_at=NOW), later).status is expected


def test_the_error_of_a_lost_goal_goes_when_it_returns() -> None:
    lost = make_goal(1, GoalStatus.LOST, updated_at=NOW, error=GoalError("action_server_lost", ""))
    back = make_goal(1, GoalStatus.EXECUTING, updated_at=NOW + timedelta(seconds=1))
    assert merge(lost, back).error is None
    aborted = make_goal(1, GoalStatus.ABORTED, error=GoalError("goal_aborted", ""))
    assert merge(aborted, make_goal(1, GoalStatus.ABORTED)).error == aborted.error


def test_who_sent_the_goal_knows_when() -> None:
    seen = make_goal(1, origin="external", created_at=NOW)
    sent = make_goal(1, origin="gateway", created_at=NOW + timedelta(seconds=1))
    assert merge(seen, sent).created_at == merge(sent, seen).created_at == sent.created_at


def test_the_verb_is_kept_where_one_account_lacks_it() -> None:
    """An older gateway stores none."""
    older, newer = make_goal(1), make_goal(1, verb="dock")
    assert merge(older, newer).verb == merge(newer, older).verb == "dock"


@pytest.mark.parametrize("code", ["result_unavailable", "canceled"])
@pytest.mark.parametrize("swapped", [True, False])
def test_a_goal_that_succeeded_keeps_its_result_and_gets_no_error(code: str, swapped: bool) -> None:
    """Whoever heard less of it says less."""
    best = make_goal(1, GoalStatus.SUCCEEDED, result=b"{}")
    if code == "canceled":
        other = make_goal(1, GoalStatus.CANCELING, error=GoalError(code, "it was canceled"))
    else:
        other = make_goal(1, GoalStatus.SUCCEEDED, error=GoalError(code, "no result came"))
    merged = merge(other, best) if swapped else merge(best, other)
    assert (merged.status, merged.result, merged.error) == (GoalStatus.SUCCEEDED, b"{}", None)
