"""A goal that must not run is canceled whenever it turns up. The port is a fake; tests/system has the real one."""

import asyncio
from collections.abc import AsyncIterator
from datetime import UTC, datetime
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.errors import Conflict, GatewayError, ServerTimeout, Unavailable
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalError, GoalStatus, ResultAnswer
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.cancellation import CANCELED, STOP_TIMEOUT, STOPPED, TOO_LATE, Canceler
from dock_gateway.goals.goal_machine import GoalChange, GoalMachine
from dock_gateway.goals.limits import GoalLimits
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.ros.action_port import CancelAnswer
from dock_gateway.ros.status import StatusReport
from dock_gateway.settings import Settings
from tests.support.action_port import FakeActionPort
from tests.support.history import HistoryInMemory
from tests.support.waiting import until

A = "aaaaaaaa-0000-4000-8000-000000000000"
S = GoalStatus
LOST = GoalError("action_server_lost", "silent")


class Scene:
    def __init__(self) -> None:
        self.port = FakeActionPort()
        self.port.cancel_answers = [CancelAnswer(frozenset({A}), 0)]
        self.port.no_results = Unavailable("requested again later")
        fanout = Fanout(queue_limit=10)
        self.tracker = GoalTracker(self.port, fanout, HistoryInMemory(), PendingFacts(0.01))  # type: ignore[arg-type]
        self.held = False
        self.by: str | None = None
        interlock: Any = SimpleNamespace(
            holds=lambda _: self.held, requested_by=lambda name: self.by if name == "/dock" else None
        )
        self.canceler = Canceler(
            Settings(cancel_timeout=0.7), self.tracker, interlock, GoalLimits(cancel_retry=0.01, unwanted=2)
        )

    async def stop(self) -> list[str]:
        self.canceler.stop()
        return await self.canceler.cancel_all()

    def goal(self, status: GoalStatus, goal_id: str = A) -> Goal:
        goal = Goal(goal_id, "/dock", "pkg/action/Dock", datetime.now(UTC))
        self.tracker.apply(GoalMachine.add, goal)
        if status is S.LOST:
            self.tracker.apply(GoalMachine.move, goal, S.EXECUTING)
            self.tracker.lose(goal, LOST)
        elif status is not S.PENDING:
            self.tracker.apply(GoalMachine.move, goal, status)
        return goal


@pytest.fixture
async def scene() -> AsyncIterator[Scene]:
    scene = Scene()
    yield scene
    await scene.tracker.close()


async def test_a_running_goal(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    await scene.canceler.cancel(goal)
    assert goal.status is S.CANCELING
    assert goal.error is None
    await scene.canceler.cancel(goal)  # once more does no harm
    assert scene.port.canceled == [A, A]
    assert scene.port.cancel_timeouts == [0.7, 0.7]


async def test_a_refusal(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 1)]
    with pytest.raises(Conflict) as refused:
        await scene.canceler.cancel(goal)
    assert (refused.value.code, refused.value.extra) == ("cancel_rejected", {"goal_id": A})
    assert "refuses" in refused.value.detail
    assert goal.status is S.EXECUTING
    assert scene.port.canceled == [A]


async def test_a_goal_that_the_server_does_not_know_yet_is_asked_for_once_more(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 2)]
    with pytest.raises(Conflict) as refused:
        await scene.canceler.cancel(goal)
    assert refused.value.code == "cancel_rejected"
    assert scene.port.canceled == [A, A]


@pytest.mark.parametrize("return_code", [0, 2])
async def test_a_goal_that_ends_while_the_server_is_asked(scene: Scene, return_code: int) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), return_code)]
    scene.port.on_cancel = lambda: scene.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
    with pytest.raises(Conflict) as refused:
        await scene.canceler.cancel(goal)
    assert (refused.value.code, refused.value.extra) == ("goal_terminal", {"goal_id": A})
    assert "succeeded" in refused.value.detail
    assert scene.port.canceled == [A]


async def test_a_refusal_ends_all_wishes_to_cancel(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.canceler.mark_unwanted(goal, TOO_LATE)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 1)]
    with pytest.raises(Conflict):
        await scene.canceler.cancel(goal)
    assert (scene.canceler.unwanted, goal.error) == ({}, None)


async def test_an_ended_goal(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.tracker.apply(GoalMachine.end, goal, S.SUCCEEDED, result=b"{}")
    with pytest.raises(Conflict) as refused:
        await scene.canceler.cancel(goal)
    assert (refused.value.code, refused.value.extra) == ("goal_terminal", {"goal_id": A})
    assert "succeeded" in refused.value.detail
    assert scene.port.canceled == []


async def test_a_goal_on_its_way_is_canceled_once_it_is_accepted(scene: Scene) -> None:
    goal = scene.goal(S.PENDING)
    scene.port.cancel_answers = [
        CancelAnswer(frozenset(), 2),
        CancelAnswer(frozenset(), 2),
        CancelAnswer(frozenset({A}), 0),
    ]
    await scene.canceler.cancel(goal)
    scene.tracker.apply(GoalMachine.move, goal, S.ACCEPTED)
    scene.canceler.seen_again(goal)
    await until(lambda: goal.status is S.CANCELING)


async def test_a_lost_goal_is_canceled_when_it_is_back(scene: Scene) -> None:
    goal = scene.goal(S.LOST)
    await scene.canceler.cancel(goal)
    assert scene.port.canceled == []
    scene.tracker.apply(GoalMachine.move, goal, S.EXECUTING)
    await until(lambda: goal.status is S.CANCELING)
    assert goal.error is not None


@pytest.mark.parametrize("failure", [TimeoutError(), Unavailable("gone")])
async def test_a_server_that_cannot_be_reached_is_asked_again(scene: Scene, failure: Exception) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [failure, failure, failure, CancelAnswer(frozenset({A}), 0)]
    with pytest.raises((ServerTimeout, Unavailable)) as refused:
        await scene.canceler.cancel(goal)
    if isinstance(failure, TimeoutError):
        assert "0.7 s" in refused.value.detail
        assert refused.value.extra == {"goal_id": A}
    await until(lambda: goal.status is S.CANCELING)
    assert scene.port.canceled == [A] * 4
    assert goal.error == CANCELED


async def test_a_goal_that_was_given_up(scene: Scene) -> None:
    goal = scene.goal(S.PENDING)
    scene.canceler.mark_unwanted(goal, TOO_LATE)
    scene.tracker.lose(goal, LOST)
    scene.port.cancel_answers = [TimeoutError(), CancelAnswer(frozenset({A}), 0)]
    scene.tracker.apply(GoalMachine.move, goal, S.ACCEPTED)  # late
    await until(lambda: goal.status is S.CANCELING)
    assert goal.error == TOO_LATE


@pytest.mark.parametrize("reported", [[S.CANCELING], [S.CANCELING, S.CANCELED], [S.CANCELED]])
async def test_a_goal_that_was_given_up_and_is_canceled_before_its_answer_comes_says_why(
    scene: Scene, reported: list[GoalStatus]
) -> None:
    """A server that wakes takes the goal, then the stop's request: its status overtakes the answer to the goal."""
    goal = scene.goal(S.PENDING)
    scene.canceler.stop()
    scene.tracker.lose(goal, GoalError(TOO_LATE.code, "no answer"))
    for status in reported:
        scene.tracker.on_status([StatusReport(A, status, 1)], 1)
    if S.CANCELED in reported:
        scene.tracker.apply(GoalMachine.answered, goal, ResultAnswer(S.CANCELED, b"{}"), 1)
    assert (goal.status, goal.error) == (reported[-1], STOPPED)
    scene.tracker.apply(GoalMachine.accept, goal, 1)
    assert (goal.status, goal.error) == (reported[-1], STOPPED)
    assert scene.port.canceled == []


async def test_a_stop_reaches_goals_that_run_are_on_their_way_or_lost(scene: Scene) -> None:
    goal = scene.goal(S.LOST)
    scene.port.cancel_answers = [Unavailable("gone"), CancelAnswer(frozenset({A}), 0)]
    with pytest.raises(Unavailable):
        await scene.stop()
    scene.tracker.apply(GoalMachine.move, goal, S.EXECUTING)
    await until(lambda: goal.status is S.CANCELING)
    assert scene.port.canceled == [None, A]


async def test_a_stop_tells_which_goals_the_server_refuses_to_cancel(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 1)]
    with pytest.raises(GatewayError) as refused:
        await scene.stop()
    assert (refused.value.code, refused.value.extra) == ("cancel_rejected", {"canceling": []})
    assert A in refused.value.detail
    assert goal.status is S.EXECUTING
    assert goal.error is None
    assert scene.canceler.uncanceled
    assert scene.port.canceled == [None, A]
    assert scene.port.cancel_timeouts == [STOP_TIMEOUT, STOP_TIMEOUT]


@pytest.mark.parametrize("status", [S.SUCCEEDED, S.CANCELING])
async def test_a_goal_that_has_just_ended_or_is_being_canceled_is_not_refused(scene: Scene, status: S) -> None:
    scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 0), CancelAnswer(frozenset(), 3)]

    def its_status_comes() -> None:
        if len(scene.port.canceled) == 3:
            scene.tracker.on_status([StatusReport(A, status, 1)], 1)

    scene.port.on_cancel = its_status_comes
    assert await scene.stop() == ([A] if status is S.CANCELING else [])
    assert scene.port.canceled == [None, A, A]


async def test_a_server_that_cannot_cancel_a_goal_is_asked_until_its_status_says_why(scene: Scene) -> None:
    goal, scene.held = scene.goal(S.EXECUTING), True
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 3)]
    await scene.canceler.cancel(goal)
    assert goal.status is S.EXECUTING
    scene.canceler.seen_again(goal)
    await until(lambda: len(scene.port.canceled) > 6)
    scene.tracker.on_status([StatusReport(A, S.CANCELING, 1)], 1)
    await until(lambda: not scene.canceler.retrying)


async def test_a_goal_that_a_server_forgot_to_name_is_being_canceled(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 0), CancelAnswer(frozenset({A}), 0)]
    assert await scene.stop() == [A]
    assert goal.status is S.CANCELING


async def test_a_server_that_falls_silent_after_it_named_no_goal_is_asked_again(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 0), TimeoutError(), CancelAnswer(frozenset({A}), 0)]
    with pytest.raises(ServerTimeout):
        await scene.stop()
    await until(lambda: goal.status is S.CANCELING)
    assert goal.error == STOPPED
    assert scene.port.cancel_timeouts[:2] == [STOP_TIMEOUT, STOP_TIMEOUT]


async def test_a_stop_cancels_what_the_server_does_not_refuse(scene: Scene) -> None:
    goals = {goal_id: scene.goal(S.EXECUTING, goal_id) for goal_id in (A, "b", "c", "d")}
    scene.port.cancel_answers = [CancelAnswer(frozenset({"d", "b", "unknown"}), 0)]
    with pytest.raises(Conflict) as refused:
        await scene.stop()
    assert f"{A}, c" in refused.value.detail
    assert refused.value.extra == {"canceling": ["b", "d", "unknown"]}
    assert [goal.status for goal in goals.values()] == [S.EXECUTING, S.CANCELING, S.EXECUTING, S.CANCELING]
    assert [goal.error for goal in goals.values()] == [None, STOPPED, None, STOPPED]


async def test_a_stop_that_is_not_answered_goes_on(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    lost = scene.goal(S.LOST, "b")
    scene.port.cancel_answers = [TimeoutError(), CancelAnswer(frozenset({A}), 0)]
    with pytest.raises(ServerTimeout) as refused:
        await scene.stop()
    assert "does not answer" in refused.value.detail
    await until(lambda: goal.status is S.CANCELING)
    assert scene.port.canceled == [None, A], "a lost goal is canceled when it is seen"
    assert (goal.error, lost.error) == (STOPPED, LOST)


async def test_a_server_that_answers_lives(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    for ask in (lambda: scene.canceler.cancel(goal), scene.canceler.cancel_all):
        scene.tracker.last_heard = 0.0
        await ask()
        assert scene.tracker.last_heard > 0.0


async def test_only_so_many_unwanted_goals_are_remembered(scene: Scene) -> None:
    known = scene.goal(S.EXECUTING)
    scene.canceler.mark_unwanted(known, TOO_LATE)
    scene.canceler.mark_unwanted(known, STOPPED)
    others = [Goal(f"{n}", "/dock", "pkg/action/Dock", datetime.now(UTC)) for n in range(4)]
    for goal in others[:2]:
        scene.canceler.mark_unwanted(goal, STOPPED)
    assert list(scene.canceler.unwanted) == [A, "0", "1"]
    for goal in others[2:]:
        scene.canceler.mark_unwanted(goal, STOPPED)
    assert scene.canceler.unwanted == {A: TOO_LATE, "2": STOPPED, "3": STOPPED}


async def test_a_refusal_while_a_stop_holds_is_logged_once(scene: Scene, caplog: pytest.LogCaptureFixture) -> None:
    scene.held = True
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 1)]
    scene.canceler.seen_again(goal)
    scene.canceler.seen_again(goal)  # it is asked for already
    await until(lambda: len(scene.port.canceled) >= 4)
    refusals = [record for record in caplog.records if "could not be canceled: " in record.getMessage()]
    assert len(refusals) == 1
    assert len(scene.canceler.retrying) == 1


async def test_a_stop_without_goals_and_server_is_fine(scene: Scene) -> None:
    scene.port.cancel_answers = [Unavailable("nobody")]
    assert await scene.stop() == []


async def test_nothing_is_remembered_of_ended_goals(scene: Scene) -> None:
    goal = scene.goal(S.PENDING)
    scene.canceler.mark_unwanted(goal, TOO_LATE)
    scene.tracker.apply(GoalMachine.end, goal, S.REJECTED, error=LOST)
    assert scene.canceler.unwanted == {}


async def test_a_goal_that_turns_up_while_a_stop_holds_is_canceled_and_says_why(scene: Scene) -> None:
    scene.held = True
    scene.tracker.on[GoalChange.SEEN](goal := scene.goal(S.EXECUTING))
    await until(lambda: goal.status is S.CANCELING)
    assert goal.error is not None
    assert goal.error.code == "stopped"
    assert scene.port.canceled == [A]


async def test_a_goal_canceled_by_a_stop_names_who_requested_it(scene: Scene) -> None:
    goal, scene.by = scene.goal(S.EXECUTING), "Ada"
    await scene.stop()
    assert (goal.status, goal.error) == (S.CANCELING, GoalError("stopped", "a stop was requested by Ada"))


async def test_a_goal_of_another_client_is_canceled_as_soon_as_it_is_heard_of(scene: Scene) -> None:
    scene.held = True
    scene.tracker.on_status([StatusReport(A, S.EXECUTING, 1)], 1)
    await until(lambda: scene.port.canceled == [A])
    await until(lambda: scene.tracker.live[A].status is S.CANCELING)
    error = scene.tracker.live[A].error
    assert error is not None
    assert error.code == "stopped"


async def test_a_goal_that_is_taken_up_while_a_stop_holds_is_canceled(scene: Scene) -> None:
    scene.held = True
    goal = Goal(A, "/dock", "pkg/action/Dock", datetime.now(UTC), status=S.EXECUTING)
    scene.tracker.take_up(goal)
    await until(lambda: goal.status is S.CANCELING)


async def test_one_that_had_ended_when_it_turned_up_is_left_alone(scene: Scene) -> None:
    scene.held = True
    scene.tracker.on_status([StatusReport(A, S.ABORTED, 1)], 1)
    await until(lambda: A in scene.tracker.live)
    await asyncio.sleep(0.05)
    assert scene.port.canceled == []
    assert scene.tracker.live[A].error is None


async def test_a_refusal_is_not_taken_while_a_stop_holds(scene: Scene) -> None:
    scene.held = True
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 1)]
    with pytest.raises(Conflict):
        await scene.stop()
    await until(lambda: len(scene.port.canceled) >= 4)
    assert goal.status is S.EXECUTING
    scene.port.cancel_answers = [CancelAnswer(frozenset({A}), 0)]
    await until(lambda: goal.status is S.CANCELING)
    assert goal.error == STOPPED


async def test_a_refusal_is_taken_once_the_stop_is_released(scene: Scene) -> None:
    scene.held = True
    goal = scene.goal(S.EXECUTING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 1)]
    scene.canceler.seen_again(goal)
    await until(lambda: len(scene.port.canceled) >= 2)
    scene.held = False
    await until(lambda: not scene.canceler.retrying)
    asked = len(scene.port.canceled)
    await asyncio.sleep(0.05)
    assert len(scene.port.canceled) == asked
    assert goal.error is None


async def test_what_a_stop_of_another_gateway_left_running_is_canceled(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.held = True
    scene.canceler.cancel_unwanted()
    await until(lambda: goal.status is S.CANCELING)


async def test_goals_that_a_stop_cancels_say_why(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    assert await scene.stop() == [A]
    assert goal.error == STOPPED
    assert not scene.canceler.uncanceled


async def test_a_goal_that_is_sent_while_the_server_is_asked_to_cancel_all_says_why(scene: Scene) -> None:
    scene.canceler.stop()
    scene.port.on_cancel = partial(scene.goal, S.EXECUTING)
    assert await scene.canceler.cancel_all() == [A]
    goal = scene.tracker.live[A]
    assert (goal.status, goal.error) == (S.CANCELING, STOPPED)


# ------------------------------------------------------------------ on their way when a stop comes


async def test_a_goal_on_its_way_is_canceled_as_soon_as_its_status_shows_that_it_runs(scene: Scene) -> None:
    """Whether the answer to its request is late, or lost."""
    goal = scene.goal(S.PENDING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 0), CancelAnswer(frozenset({A}), 0)]
    assert await scene.stop() == []
    assert scene.port.canceled == [None]
    scene.tracker.on_status([StatusReport(A, S.EXECUTING, 1)], 1)
    await until(lambda: goal.status is S.CANCELING)
    assert (goal.error, scene.port.canceled) == (STOPPED, [None, A])


async def test_a_server_that_does_not_know_a_goal_has_not_refused(scene: Scene) -> None:
    goal = scene.goal(S.EXECUTING)
    scene.canceler.mark_unwanted(goal, STOPPED)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 2)] * 5 + [CancelAnswer(frozenset({A}), 0)]
    scene.canceler.seen_again(goal)
    await until(lambda: goal.status is S.CANCELING)


async def test_a_goal_that_is_sent_again_may_run(scene: Scene) -> None:
    goal = scene.goal(S.PENDING)
    scene.port.cancel_answers = [CancelAnswer(frozenset(), 0)]
    await scene.stop()
    scene.canceler.allow(goal)
    scene.tracker.apply(GoalMachine.accept, goal, 1)
    await asyncio.sleep(0.02)
    assert (goal.status, scene.port.canceled) == (S.ACCEPTED, [None])


@pytest.mark.parametrize(
    ("status", "error", "unwanted"),
    [
        (S.PENDING, STOPPED, True),
        (S.EXECUTING, CANCELED, True),
        (S.LOST, TOO_LATE, True),
        (S.LOST, LOST, False),
        (S.EXECUTING, None, False),
    ],
)
async def test_a_goal_that_was_unwanted_before_a_restart_is_canceled(
    scene: Scene, status: GoalStatus, error: GoalError | None, unwanted: bool
) -> None:
    goal = Goal(A, "/dock", "pkg/action/Dock", datetime.now(UTC), status=status, error=error)
    scene.tracker.take_up(goal)
    scene.tracker.on_status([StatusReport(A, S.EXECUTING, 1)], 1)
    if unwanted:
        await until(lambda: goal.status is S.CANCELING)
    else:
        await asyncio.sleep(0.03)
        assert (goal.status, scene.port.canceled) == (S.EXECUTING, [])
