"""Results come early, late or never. The port is a fake; tests/system has the real one."""

import asyncio
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import time_id
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.goal_machine import GoalMachine
from tests.support.tracking import QUICK, A, B, S, Scene, scene
from tests.support.waiting import PATIENCE, until

__all__ = ["scene"]


async def test_nothing_is_asked_for_after_the_end(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.apply(GoalMachine.move, goal, S.ACCEPTED)
    await scene.tracker.close()
    await asyncio.sleep(0.03)
    scene.status((A, S.EXECUTING))
    assert scene.port.results == {}


async def test_goals_that_ended_before_we_came_get_their_result_too(scene: Scene) -> None:
    scene.status((A, S.SUCCEEDED), (B, S.ABORTED))
    await asyncio.sleep(0)
    scene.port.answer_result(A, S.SUCCEEDED, b'{"n":9}')
    async with asyncio.timeout(PATIENCE):
        while (b := await scene.history.get(B)) is None or b.error is None:  # noqa: ASYNC110 - it has no event for that
            await asyncio.sleep(0.01)
    a = await scene.history.get(A)
    assert a is not None
    assert (a.status, a.result, a.error) == (S.SUCCEEDED, b'{"n":9}', None)
    assert (b.status, b.result) == (S.ABORTED, None)
    assert b.error == GoalError("result_unavailable", b.error.detail if b.error else "")


async def test_a_result_after_the_time_still_counts(scene: Scene) -> None:
    goal = scene.send()
    scene.status((A, S.SUCCEEDED))
    await until(lambda: goal.status is S.SUCCEEDED)
    assert goal.result is None
    scene.port.answer_result(A, S.SUCCEEDED, b'{"n":1}')
    await until(lambda: goal.result == b'{"n":1}')
    assert goal.error is None
    kept = await scene.history.get(A)
    assert kept is not None
    assert (kept.result, kept.error) == (b'{"n":1}', None)
    assert (await scene.events())[-2:] == ["status:succeeded", "result:succeeded"], "a result is told once"


@pytest.mark.parametrize("status", [S.SUCCEEDED, S.ABORTED])
async def test_a_result_before_the_status_is_not_asked_for_again(status: GoalStatus) -> None:
    scene = Scene(replace(QUICK, end_stamp_wait=5.0, ask_again_after=5.0), PendingFacts(5.0))
    goal = scene.send()
    scene.status((A, S.EXECUTING))
    await asyncio.sleep(0)
    scene.port.answer_result(A, status, b'{"n":1}')
    await asyncio.sleep(0.001)
    assert goal.status is S.EXECUTING
    scene.status((A, status))
    ended_at = scene.stamp
    await asyncio.sleep(0.001)
    scene.status((A, status))
    scene.reasons.put(A, GoalError("timeout", "took too long"))
    events = await scene.documents()
    assert (goal.status, goal.result) == (status, b'{"n":1}')
    assert events[-1]["id"].startswith(time_id(ended_at))
    assert len(scene.port.results[A]) == 1
    await scene.tracker.close()


async def test_an_aborted_goal_says_why(scene: Scene) -> None:
    goal = scene.send()
    scene.reasons.put(A, GoalError("battery_lost", "no battery for 60 s"))
    scene.tracker.apply(GoalMachine.accept, goal, 1)
    await asyncio.sleep(0)
    scene.port.answer_result(A, S.ABORTED, b"{}")
    await until(lambda: goal.error == GoalError("battery_lost", "no battery for 60 s"))


async def test_a_reason_that_comes_a_moment_later() -> None:
    scene = Scene(reasons=PendingFacts(5.0))
    goal = scene.send()
    scene.tracker.apply(GoalMachine.accept, goal, 1)
    await asyncio.sleep(0)
    scene.port.answer_result(A, S.ABORTED, b"{}")
    await asyncio.sleep(0.05)
    scene.reasons.put(A, GoalError("timeout", "took too long"))
    await until(lambda: goal.status is S.ABORTED)
    assert goal.error == GoalError("timeout", "took too long")
    await scene.tracker.close()


async def test_an_unknown_goal_is_lost_only_while_it_runs(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.apply(GoalMachine.move, goal, S.EXECUTING)
    scene.tracker.ask_again(goal)
    await asyncio.sleep(0)
    scene.port.answer_result(A, None)
    await until(lambda: goal.status is S.LOST)
    assert goal.error is not None
    assert "does not know" in goal.error.detail


async def test_a_server_that_is_not_there_is_asked_again_later(scene: Scene) -> None:
    goal = scene.send()
    scene.tracker.apply(GoalMachine.accept, goal, 1)
    await asyncio.sleep(0)
    scene.port.results[A][-1].response.set_exception(Unavailable("nobody"))
    await asyncio.sleep(0.05)
    scene.tracker.apply(GoalMachine.accept, goal, 1)
    await asyncio.sleep(0)
    assert len(scene.port.results[A]) == 2


async def test_a_goal_of_before_is_asked_for_though_its_server_answered_long_ago(scene: Scene) -> None:
    """The server may have been restarted, too, and not know the goal."""
    known = Goal(B, "/dock", "pkg/action/Dock", datetime.now(UTC), status=S.EXECUTING)
    scene.tracker.take_up(known)
    scene.port.answer_result(B, None)
    assert await scene.events() == ["status:lost"]


async def test_a_result_whose_answer_was_lost_is_asked_for_again(scene: Scene) -> None:
    """As just after a start, when the server does not know our client yet."""
    goal = scene.send()
    scene.status((A, S.SUCCEEDED))
    await until(lambda: len(scene.port.results.get(A, ())) == 2)
    scene.port.answer_result(A, S.SUCCEEDED, b'{"n":1}')
    assert (await scene.events())[-1] == "result:succeeded"
    assert (goal.result, goal.error) == (b'{"n":1}', None)


async def test_an_answer_that_does_not_end_the_goal_is_not_its_end(scene: Scene) -> None:
    goal = scene.send()
    scene.status((A, S.EXECUTING))
    await asyncio.sleep(0)
    scene.port.answer_result(A, S.ACCEPTED, b'{"n":1}')
    await asyncio.sleep(0.02)
    assert goal.status is S.EXECUTING
    scene.status((A, S.SUCCEEDED))
    await until(lambda: len(scene.port.results[A]) == 2)
    scene.port.answer_result(A, S.SUCCEEDED, b'{"n":2}')
    assert (await scene.events())[-1] == "result:succeeded"
