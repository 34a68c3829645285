import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.admission import GoalPolicy, admit
from docking.failures import ErrorCode


@pytest.mark.parametrize("status", [0, 1, 4])
@pytest.mark.parametrize("policy", list(GoalPolicy))
def test_charging_full_and_unset_are_let_in(status: int, policy: GoalPolicy) -> None:
    assert admit(status, active_goal_id=None, policy=policy, shutting_down=False) is None


@given(st.integers(0, 255).filter(lambda status: status not in {0, 1, 4}))
def test_anything_else_is_not(status: int) -> None:
    rejection = admit(status, active_goal_id="a", policy=GoalPolicy.PREEMPT, shutting_down=False)
    assert rejection is not None
    assert rejection.error_code is ErrorCode.INVALID_GOAL
    assert str(status) in rejection.error_msg


def test_a_second_goal_is_rejected_and_told_of_the_first() -> None:
    rejection = admit(1, active_goal_id="the-first", policy=GoalPolicy.REJECT, shutting_down=False)
    assert rejection is not None
    assert rejection.error_code is ErrorCode.DOCK_BUSY
    assert "the-first" in rejection.error_msg


def test_a_second_goal_may_preempt() -> None:
    assert admit(1, active_goal_id="the-first", policy=GoalPolicy.PREEMPT, shutting_down=False) is None


@pytest.mark.parametrize("policy", list(GoalPolicy))
def test_nothing_is_let_in_at_the_end(policy: GoalPolicy) -> None:
    rejection = admit(1, active_goal_id=None, policy=policy, shutting_down=True)
    assert rejection is not None
    assert rejection.error_code is ErrorCode.SHUTTING_DOWN
