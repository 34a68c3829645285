import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.errors import ErrorCode
from docking.goal.admission import DOCKING, UNDOCKING, Purpose, Rejection, admit
from docking.parameters import GoalPolicy

STATUSES = {"dock": {0, 1, 4}, "undock": {0, 2, 3}}
PURPOSES = {"dock": DOCKING, "undock": UNDOCKING}


def decide(
    status: int = 0,
    purpose: Purpose = DOCKING,
    *,
    active_goal_id: str | None = None,
    policy: GoalPolicy = GoalPolicy.REJECT,
    stop_latched: bool = False,
    shutting_down: bool = False,
) -> Rejection | None:
    return admit(
        status,
        purpose,
        active_goal_id=active_goal_id,
        policy=policy,
        stop_latched=stop_latched,
        shutting_down=shutting_down,
    )


@pytest.mark.parametrize(
    ("purpose", "status"), [(name, status) for name, statuses in STATUSES.items() for status in statuses]
)
@pytest.mark.parametrize("policy", list(GoalPolicy))
def test_what_can_be_brought_about_is_let_in(purpose: str, status: int, policy: GoalPolicy) -> None:
    assert decide(status, PURPOSES[purpose], policy=policy) is None


@given(st.sampled_from(["dock", "undock"]), st.integers(0, 255))
def test_anything_else_is_not(purpose: str, status: int) -> None:
    rejection = decide(status, PURPOSES[purpose], active_goal_id="a", policy=GoalPolicy.PREEMPT)
    if status in STATUSES[purpose]:
        assert rejection is None
        return
    assert rejection is not None
    assert rejection.error_code is ErrorCode.INVALID_GOAL
    assert f"is {status} (" in rejection.error_msg
    assert f"but {purpose}ing only accepts" in rejection.error_msg


def test_a_second_goal_is_rejected_and_told_of_the_first() -> None:
    rejection = decide(active_goal_id="the-first")
    assert rejection is not None
    assert rejection.error_code is ErrorCode.DOCK_BUSY
    assert "the-first" in rejection.error_msg


def test_a_second_goal_may_preempt() -> None:
    assert decide(active_goal_id="the-first", policy=GoalPolicy.PREEMPT) is None


@pytest.mark.parametrize("policy", list(GoalPolicy))
def test_nothing_is_let_in_while_a_stop_is_latched(policy: GoalPolicy) -> None:
    rejection = decide(policy=policy, stop_latched=True)
    assert rejection is not None
    assert rejection.error_code is ErrorCode.STOP_LATCHED


@pytest.mark.parametrize("policy", list(GoalPolicy))
def test_nothing_is_let_in_at_the_end(policy: GoalPolicy) -> None:
    rejection = decide(policy=policy, shutting_down=True)
    assert rejection is not None
    assert rejection.error_code is ErrorCode.SHUTTING_DOWN
