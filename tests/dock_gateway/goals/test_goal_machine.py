"""What each input changes, and what it wants done: exactly that, in that order."""

from datetime import timedelta
from typing import Any

import orjson
import pytest

from dock_gateway.core.dock_adapters import nav2
from dock_gateway.core.dock_adapters.adapter import NO_REASON, DockAdapter
from dock_gateway.core.event import Now, moment
from dock_gateway.core.goal import Goal, GoalError, GoalStatus, ResultAnswer
from dock_gateway.goals.goal_machine import (
    AwaitResult,
    GoalChange,
    GoalMachine,
    Notify,
    PublishEnd,
    PublishEvent,
    Store,
)
from dock_gateway.goals.limits import GoalLimits
from tests.support.tracking import A, B, S

WHY = GoalError("why", "because")
START, NOW = Now(1_000_000_000, 1.0), Now(5_000_000_000, 5.0)


class Bench:
    """A machine whose stamps are those of the source, and what it wanted done since the last look."""

    def __init__(self, adapter: DockAdapter | None = None, **limits: int) -> None:
        self.machine = GoalMachine(
            "/dock", "pkg/action/Dock", lambda source_ns: source_ns, START, adapter, limits=GoalLimits(**limits)
        )

    def done(self) -> list[Any]:
        """Everything that is to be done; an event as its type, its detail, and its source's stamp."""
        done: list[Any] = []
        while self.machine.outputs:
            output = self.machine.outputs.popleft()
            if isinstance(output, PublishEvent):
                document = orjson.loads(output.event.data)
                assert output.event.id is not None
                detail = document.get("status") or document["feedback"]
                done.append((document["type"], detail, int(output.event.id[:20])))
                assert document["time"] == orjson.loads(orjson.dumps(moment(done[-1][2]), option=orjson.OPT_UTC_Z))
            else:
                done.append(output)
        return done

    def goal(self, status: GoalStatus = S.PENDING, goal_id: str = A, **more: Any) -> Goal:
        goal = Goal(goal_id, "/dock", "pkg/action/Dock", moment(2_000_000_000), status=status, **more)
        self.machine.live[goal_id] = goal
        return goal

    def adopt(self, goal_id: str = B, known: Goal | None = None) -> Goal | None:
        self.machine.adopt(NOW, goal_id, known)
        return self.machine.live.get(goal_id)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_goal_that_is_sent_is_told_with_the_time_of_its_creation(bench: Bench) -> None:
    goal = Goal(A, "/dock", "pkg/action/Dock", moment(2_000_000_000))
    bench.machine.taken_up.add(A)
    bench.machine.add(NOW, goal)
    assert bench.done() == [("status", "pending", 2_000_000_000), Notify(GoalChange.SENT, goal)]
    assert (bench.machine.live, bench.machine.taken_up) == ({A: goal}, set())
    assert bench.machine.running() == [goal]
    assert not bench.machine.ended(A)


def test_a_lost_goal_that_is_sent_again_is_pending(bench: Bench) -> None:
    goal = bench.goal(S.LOST, error=WHY)
    bench.machine.add(NOW, goal)
    assert bench.done() == [
        ("status", "pending", NOW.ns),
        Store(goal),
        Notify(GoalChange.RETURNED, goal),
        Notify(GoalChange.SENT, goal),
    ]
    assert goal.error is None


def test_an_acceptance_has_the_stamp_of_the_server_and_its_result_is_awaited(bench: Bench) -> None:
    goal = bench.goal()
    bench.machine.accept(NOW, goal, 3_000_000_000)
    assert bench.done() == [
        ("status", "accepted", 3_000_000_000),
        Store(goal),
        Notify(GoalChange.SEEN, goal),
        AwaitResult(goal),
    ]
    bench.machine.report(NOW, A, S.EXECUTING, 3_000_000_000, 4_000_000_000)
    assert Notify(GoalChange.SEEN, goal) not in bench.done(), "that it runs is known"
    assert goal.updated_at == moment(NOW.ns)
    assert bench.machine.heard_at(goal) == NOW.monotonic


@pytest.mark.parametrize(
    ("status", "stamp_ns"), [(S.ACCEPTED, 3_000_000_000), (S.EXECUTING, 4_000_000_000), (S.CANCELING, 4_000_000_000)]
)
def test_a_report_of_a_running_goal(bench: Bench, status: GoalStatus, stamp_ns: int) -> None:
    """Its acceptance has the server's stamp of that; the rest has the message's."""
    goal = bench.goal()
    bench.machine.report(NOW, A, status, 3_000_000_000, 4_000_000_000)
    assert bench.done() == [
        ("status", status.value, stamp_ns),
        Store(goal),
        Notify(GoalChange.SEEN, goal),
        AwaitResult(goal),
    ]
    later = Now(6_000_000_000, 6.0)
    bench.machine.report(later, A, status, 3_000_000_000, 4_500_000_000)
    assert bench.done() == [AwaitResult(goal)], "nothing changed"
    assert bench.machine.heard_at(goal) == 6.0
    assert goal.updated_at == moment(NOW.ns)


def test_a_report_of_an_end_waits_for_the_result(bench: Bench) -> None:
    goal = bench.goal(S.EXECUTING)
    bench.machine.report(NOW, A, S.SUCCEEDED, 3_000_000_000, 4_000_000_000)
    assert bench.done() == [AwaitResult(goal, (S.SUCCEEDED, 4_000_000_000))]
    assert goal.status is S.EXECUTING


@pytest.mark.parametrize(("status", "origin"), [(S.LOST, "gateway"), (S.LOST, "external"), (S.PENDING, "external")])
def test_feedback_shows_that_a_goal_runs(bench: Bench, status: GoalStatus, origin: Any) -> None:
    goal = bench.goal(status, origin=origin)
    bench.machine.feedback(NOW, A, b"1", 4_000_000_000)
    back = Notify(GoalChange.RETURNED if status is S.LOST else GoalChange.SEEN, goal)
    moved = ("status", "executing", 4_000_000_000)
    assert bench.done() == [moved, Store(goal), back, ("feedback", 1, 4_000_000_000)]
    assert (goal.status, goal.feedback, goal.feedback_count) == (S.EXECUTING, b"1", 1)


@pytest.mark.parametrize("status", [S.PENDING, S.ACCEPTED, S.CANCELING])
def test_feedback_of_a_goal_of_ours_changes_no_state(bench: Bench, status: GoalStatus) -> None:
    goal = bench.goal(status)
    bench.machine.feedback(NOW, A, b"1", 4_000_000_000)
    assert bench.done() == [("feedback", 1, 4_000_000_000)]
    assert (goal.status, goal.updated_at) == (status, moment(NOW.ns))
    assert bench.machine.heard_at(goal) == NOW.monotonic


def test_progress(bench: Bench) -> None:
    goal = bench.goal(S.EXECUTING)
    bench.machine.progress(NOW, goal, "DRIVING", 1, 4_000_000_000)
    assert bench.done() == [("status", "executing", 4_000_000_000), Store(goal)]
    assert (goal.stage, goal.retries, goal.updated_at) == ("DRIVING", 1, moment(NOW.ns))
    bench.machine.progress(NOW, goal, "DRIVING", 1, 4_500_000_000)
    assert bench.done() == []
    bench.machine.lose(NOW, goal, WHY)
    bench.done()
    bench.machine.progress(NOW, goal, "BACKING_OUT", 2, 4_500_000_000)
    assert bench.done() == [], "a goal that has ended has no progress"


def test_a_goal_is_lost_once_and_stays_tracked(bench: Bench) -> None:
    goal = bench.goal(S.EXECUTING)
    bench.machine.lose(NOW, goal, WHY)
    assert bench.done() == [("status", "lost", NOW.ns), Store(goal), Notify(GoalChange.LOST, goal)]
    assert (goal.error, goal.finished_at) == (WHY, moment(NOW.ns))
    assert bench.machine.live == {A: goal}
    assert bench.machine.running() == []
    bench.machine.lose(NOW, goal, GoalError("why", "for another reason"))
    assert bench.done() == []
    assert goal.error == WHY


def test_an_answer_ends_a_goal_with_all_that_it_says(bench: Bench) -> None:
    goal = bench.goal(S.EXECUTING)
    bench.machine.taken_up.add(A)
    bench.machine.report(NOW, A, S.EXECUTING, 1, 1)
    bench.done()
    bench.machine.answered(NOW, goal, ResultAnswer(S.ABORTED, b"{}", WHY), 4_000_000_000)
    assert bench.done() == [PublishEnd(goal, 4_000_000_000), Notify(GoalChange.RETIRED, goal)]
    assert (goal.status, goal.result, goal.error, goal.finished_at) == (S.ABORTED, b"{}", WHY, moment(NOW.ns))
    assert (bench.machine.live, bench.machine.taken_up, bench.machine.heard_at(goal)) == ({}, set(), None)
    assert bench.machine.ended(A)
    bench.machine.report(NOW, A, S.EXECUTING, 1, 1)
    bench.machine.feedback(NOW, A, b"1", 1)
    assert (bench.done(), list(bench.machine.newcomers)) == ([], [])


def test_an_answer_that_is_no_end_is_none(bench: Bench, caplog: pytest.LogCaptureFixture) -> None:
    goal = bench.goal(S.EXECUTING)
    bench.machine.answered(NOW, goal, ResultAnswer(S.ACCEPTED, b"{}"), None)
    assert (bench.done(), goal.status, goal.result) == ([], S.EXECUTING, None)
    assert A in caplog.text


def test_an_end_that_only_this_gateway_knows_of_happens_now(bench: Bench) -> None:
    goal = bench.goal()
    bench.machine.end(NOW, goal, S.REJECTED, error=WHY)
    assert bench.done() == [PublishEnd(goal, NOW.ns), Notify(GoalChange.RETIRED, goal)]


@pytest.mark.parametrize(
    ("status", "error", "kept"), [(S.SUCCEEDED, None, None), (S.CANCELED, None, WHY), (S.SUCCEEDED, WHY, WHY)]
)
def test_why_a_goal_was_canceled_stays_unless_it_succeeds(
    bench: Bench, status: GoalStatus, error: GoalError | None, kept: GoalError | None
) -> None:
    goal = bench.goal(S.CANCELING)
    bench.machine.explain(NOW, goal, WHY)
    bench.machine.end(NOW, goal, status, result=b"{}", error=error)
    assert goal.error == kept
    bench.machine.explain(NOW, goal, GoalError("later", "too late"))
    assert goal.error == kept


# What nav2's server answers: it aborts by its `success`, with a code, and counts its retries.
NOT_SEEN = {"success": False, "error_code": 904, "error_msg": "", "num_retries": 2}
SEEN = {"success": True, "error_code": 0, "error_msg": "", "num_retries": 1}


def judged(answer: ResultAnswer, adapter: DockAdapter | None = nav2.DOCK) -> Goal:
    """Return a goal that ran and has got this answer."""
    bench = Bench(adapter)
    goal = bench.goal(S.EXECUTING)
    bench.machine.answered(NOW, goal, answer, None)
    assert bench.machine.ended(A)
    return goal


def test_a_result_says_how_the_goal_ended_and_after_how_many_retries() -> None:
    failed = judged(ResultAnswer(S.SUCCEEDED, orjson.dumps(NOT_SEEN)))
    assert (failed.status, failed.retries) == (S.ABORTED, 2)
    assert failed.error == GoalError("failed_to_detect_dock", "the dock was not detected")
    docked = judged(ResultAnswer(S.SUCCEEDED, orjson.dumps(SEEN)))
    assert (docked.status, docked.retries, docked.error) == (S.SUCCEEDED, 1, None)


def test_a_result_that_counts_no_retries_leaves_those_that_are_known() -> None:
    bench = Bench(nav2.UNDOCK)
    goal = bench.goal(S.EXECUTING, retries=3)
    bench.machine.answered(NOW, goal, ResultAnswer(S.SUCCEEDED, orjson.dumps(SEEN)), None)
    assert (goal.status, goal.retries) == (S.SUCCEEDED, 3)


def test_a_late_result_changes_no_retries() -> None:
    bench = Bench(nav2.DOCK)
    goal = bench.goal(S.EXECUTING)
    bench.machine.end(NOW, goal, S.SUCCEEDED)
    bench.machine.answered(NOW, goal, ResultAnswer(S.SUCCEEDED, orjson.dumps(SEEN)), None)
    assert (goal.status, goal.retries, goal.result) == (S.SUCCEEDED, None, orjson.dumps(SEEN))


@pytest.mark.parametrize(
    ("said", "kept"),
    [(WHY, "why"), (GoalError(NO_REASON, "nothing"), "failed_to_detect_dock"), (None, "failed_to_detect_dock")],
)
def test_a_reason_that_the_server_gave_counts_more_than_the_code_of_its_result(
    said: GoalError | None, kept: str
) -> None:
    goal = judged(ResultAnswer(S.ABORTED, orjson.dumps(NOT_SEEN), said))
    assert goal.error is not None
    assert goal.error.code == kept


@pytest.mark.parametrize("adapter", [None, nav2.DOCK])
def test_without_a_result_what_the_server_says_counts(adapter: DockAdapter | None) -> None:
    goal = judged(ResultAnswer(S.ABORTED, None, GoalError(NO_REASON, "nothing")), adapter)
    assert (goal.status, goal.error, goal.retries) == (S.ABORTED, GoalError(NO_REASON, "nothing"), None)


def test_without_an_adapter_a_result_says_nothing_about_the_end() -> None:
    goal = judged(ResultAnswer(S.SUCCEEDED, orjson.dumps(NOT_SEEN), WHY), None)
    assert (goal.status, goal.error, goal.retries) == (S.SUCCEEDED, WHY, None)


@pytest.mark.parametrize("detail", ["because", "because."])
@pytest.mark.parametrize(("status", "remarked"), [(S.ABORTED, True), (S.CANCELED, False)])
def test_what_is_wrong_around_the_robot_is_added_to_why_a_goal_was_aborted(
    detail: str, status: GoalStatus, *, remarked: bool
) -> None:
    goal = judged(ResultAnswer(status, b"{}", GoalError("why", detail), "Two nodes publish cmd_vel."), None)
    assert goal.error == GoalError("why", "because. Two nodes publish cmd_vel." if remarked else detail)
    assert judged(ResultAnswer(S.ABORTED, b"{}", None, "Two nodes publish cmd_vel."), None).error is None


def test_feedback_tells_the_stage_and_the_retries() -> None:
    bench = Bench(nav2.DOCK)
    goal = bench.goal(S.EXECUTING)
    for retries in (1, 1, 2):
        feedback = orjson.dumps({"state": 3, "num_retries": retries})
        bench.machine.feedback(NOW, A, feedback, 4_000_000_000)
        assert (goal.stage, goal.retries, goal.updated_at) == ("CONTROLLING", retries, moment(NOW.ns))
    told = [done if isinstance(done, Store) else done[0] for done in bench.done()]
    news = ["status", Store(goal), "feedback"]
    assert told == [*news, "feedback", *news], "the second message says nothing new"


@pytest.mark.parametrize("adapter", [None, nav2.UNDOCK])
def test_feedback_of_an_action_without_stages_is_not_read(adapter: DockAdapter | None) -> None:
    bench = Bench(adapter)
    goal = bench.goal(S.EXECUTING)
    bench.machine.feedback(NOW, A, orjson.dumps({"state": 3, "num_retries": 1}), 4_000_000_000)
    assert [kind for kind, *_ in bench.done()] == ["feedback"]
    assert (goal.stage, goal.retries) == (None, None)


@pytest.mark.parametrize(
    ("status", "first", "then"),
    [(S.CANCELED, "why", "why"), (S.ABORTED, "result_unavailable", "later"), (S.SUCCEEDED, "result_unavailable", None)],
)
def test_a_canceled_goal_whose_result_is_missing_or_late_says_why_it_was_canceled(
    bench: Bench, status: GoalStatus, first: str, then: str | None
) -> None:
    goal = bench.goal(S.CANCELING, error=WHY)
    missing = GoalError("result_unavailable", "no result")
    bench.machine.answered(NOW, goal, ResultAnswer(status, None, missing), None)
    assert (goal.status, goal.error and goal.error.code) == (status, first)
    error = GoalError("later", "because") if status is S.ABORTED else None
    bench.machine.answered(NOW, goal, ResultAnswer(status, b"{}", error), None)
    assert (goal.result, goal.error and goal.error.code) == (b"{}", then)


def test_a_late_result_completes_the_end(bench: Bench) -> None:
    goal = bench.goal(S.EXECUTING)
    bench.machine.end(NOW, goal, S.SUCCEEDED, error=WHY)
    bench.done()
    bench.machine.end(NOW, goal, S.SUCCEEDED)
    bench.machine.end(NOW, goal, S.ABORTED, result=b"{}")
    assert (bench.done(), goal.result, goal.error) == ([], None, WHY)
    bench.machine.end(NOW, goal, S.SUCCEEDED, result=b"1")
    assert (bench.done(), goal.result, goal.error) == ([Store(goal)], b"1", None)
    bench.machine.end(NOW, goal, S.SUCCEEDED, result=b"2")
    assert (bench.done(), goal.result) == ([], b"1")


def test_a_goal_that_is_stalled(bench: Bench) -> None:
    goal = bench.goal(S.EXECUTING)
    for stalled in (True, False):
        for _ in range(2):
            bench.machine.stall(NOW, goal, stalled=stalled)
        assert bench.done() == [("status", "executing", NOW.ns)]
        assert goal.stalled is stalled


def test_only_so_many_lost_goals_are_kept() -> None:
    bench = Bench(lost=2)
    running = bench.goal(S.EXECUTING, "running")
    goals = [bench.goal(S.EXECUTING, f"{number}") for number in range(3)]
    for goal in goals:
        bench.machine.lose(NOW, goal, WHY)
    assert bench.done()[-2:] == [Notify(GoalChange.LOST, goals[2]), Notify(GoalChange.RETIRED, goals[0])]
    assert list(bench.machine.live.values()) == [running, *goals[1:]]
    assert not bench.machine.ended("0"), "it may still return, as one that is unknown"


def test_only_so_many_ended_goals_are_remembered() -> None:
    bench = Bench(ended=2)
    for number in range(3):
        bench.machine.end(NOW, bench.goal(S.EXECUTING, f"{number}"), S.SUCCEEDED)
    assert [bench.machine.ended(f"{number}") for number in range(3)] == [False, True, True]


# ------------------------------------------------------------------ goals that this process did not send


def test_an_unknown_goal_is_another_clients(bench: Bench) -> None:
    bench.machine.report(NOW, B, S.EXECUTING, 3_000_000_000, 4_000_000_000)
    bench.machine.feedback(NOW, B, b"1", 4_100_000_000)
    assert (bench.done(), list(bench.machine.newcomers)) == ([], [B]), "it is looked up first"
    goal = bench.adopt()
    assert goal is not None
    assert bench.done() == [
        ("status", "executing", 4_000_000_000),
        Store(goal),
        Notify(GoalChange.SEEN, goal),
        AwaitResult(goal),
        ("feedback", 1, 4_100_000_000),
        AwaitResult(goal),
    ]
    assert (goal.origin, goal.action_name, goal.action_type) == ("external", "/dock", "pkg/action/Dock")
    assert (goal.created_at, list(bench.machine.newcomers)) == (moment(3_000_000_000), [])
    assert bench.machine.taken_up == set()
    bench.adopt()
    assert bench.done() == [], "it is known already"


def test_every_goal_has_the_verb_of_the_action() -> None:
    """Also one that an older gateway stored without it."""
    machine = GoalMachine("/dock", "pkg/action/Dock", lambda source_ns: source_ns, START, DockAdapter("dock"))
    assert machine.new_goal(A, moment(2), "automation").verb == "dock"
    machine.feedback(NOW, A, b"1", 4_000_000_000)
    machine.adopt(NOW, A, None)
    machine.take_up(NOW, Goal(B, "/dock", "pkg/action/Dock", moment(2)))
    assert [goal.verb for goal in machine.live.values()] == ["dock", "dock"]


@pytest.mark.parametrize(("accepted_ns", "created_ns"), [(0, 4_000_000_000), (3_000_000_000, 3_000_000_000)])
def test_an_unknown_goal_that_has_ended_is_not_seen_running(bench: Bench, accepted_ns: int, created_ns: int) -> None:
    bench.machine.report(NOW, B, S.SUCCEEDED, accepted_ns, 4_000_000_000)
    goal = bench.adopt()
    assert goal is not None
    assert bench.done() == [AwaitResult(goal, (S.SUCCEEDED, 4_000_000_000)), AwaitResult(goal)]
    assert goal.created_at == moment(created_ns)


def test_an_unknown_goal_first_seen_by_its_feedback(bench: Bench) -> None:
    bench.machine.feedback(NOW, B, b"1", 4_000_000_000)
    goal = bench.adopt()
    assert goal is not None
    assert (goal.created_at, goal.status) == (moment(4_000_000_000), S.EXECUTING)
    assert bench.done().count(Notify(GoalChange.SEEN, goal)) == 1


def test_a_goal_that_the_history_knows_goes_on(bench: Bench) -> None:
    known = Goal(B, "/dock", "pkg/action/Dock", moment(2), status=S.EXECUTING, feedback_count=7)
    bench.machine.report(NOW, B, S.EXECUTING, 3_000_000_000, 4_000_000_000)
    assert bench.adopt(known=known) is known
    assert bench.done() == [AwaitResult(known), AwaitResult(known), Notify(GoalChange.SEEN, known)]


@pytest.mark.parametrize(("later", "told"), [(None, False), (0, False), (1, True)])
def test_a_goal_that_has_ended_stays_as_it_is(bench: Bench, later: int | None, told: bool) -> None:
    """It is told only if it ended since this gateway started, as only another gateway's readers know of it."""
    known = Goal(B, "/dock", "pkg/action/Dock", moment(2), status=S.SUCCEEDED)
    known.finished_at = None if later is None else moment(START.ns) + timedelta(seconds=later)
    bench.machine.report(NOW, B, S.SUCCEEDED, 3_000_000_000, 4_000_000_000)
    assert bench.adopt(known=known) is None
    assert bench.done() == ([PublishEnd(known, NOW.ns)] if told else [])
    assert bench.machine.ended(B)


@pytest.mark.parametrize("status", [S.EXECUTING, S.LOST])
def test_a_goal_of_before_is_taken_up(bench: Bench, status: GoalStatus) -> None:
    goal = Goal(A, "/dock", "pkg/action/Dock", moment(2), status=status)
    bench.machine.take_up(NOW, goal)
    seen = [Notify(GoalChange.SEEN, goal)] if status is S.EXECUTING else []
    assert bench.done() == [AwaitResult(goal), *seen]
    assert (bench.machine.live, bench.machine.taken_up) == ({A: goal}, {A})
    bench.machine.take_up(NOW, Goal(A, "/dock", "pkg/action/Dock", moment(2), status=status))
    assert bench.done() == []
    assert bench.machine.live == {A: goal}


def test_a_goal_that_is_taken_up_gets_the_messages_that_waited(bench: Bench) -> None:
    goal = Goal(A, "/dock", "pkg/action/Dock", moment(2), status=S.ACCEPTED)
    bench.machine.report(NOW, A, S.CANCELING, 3_000_000_000, 4_000_000_000)
    bench.machine.take_up(NOW, goal)
    assert bench.done()[0] == ("status", "canceling", 4_000_000_000)
    assert list(bench.machine.newcomers) == []


def test_a_goal_that_has_ended_is_not_taken_up(bench: Bench) -> None:
    bench.machine.end(NOW, bench.goal(S.EXECUTING), S.SUCCEEDED)
    bench.done()
    bench.machine.take_up(NOW, Goal(A, "/dock", "pkg/action/Dock", moment(2), status=S.EXECUTING))
    assert (bench.done(), bench.machine.live, bench.machine.taken_up) == ([], {}, set())


def test_a_goal_of_another_client_turns_out_to_be_ours(bench: Bench) -> None:
    goal = bench.goal(S.EXECUTING, origin="external")
    bench.machine.take_up(NOW, Goal(A, "/dock", "pkg/action/Dock", moment(2), status=S.EXECUTING, feedback_count=3))
    assert bench.done() == [("status", "executing", NOW.ns), Store(goal)]
    assert (goal.origin, goal.feedback_count) == ("gateway", 3)
