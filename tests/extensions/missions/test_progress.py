"""What a mission does next, step by step."""

from typing import Any

import pytest

from dock_gateway.core.goal import GoalStatus
from dock_gateway.extensions.missions import progress, waiting
from dock_gateway.extensions.missions.mission import HoldReason, MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moves import Cancel, Change, Facts, Send, Sent, Wait, WaitsFor
from dock_gateway.extensions.missions.progress import next_move
from dock_gateway.extensions.missions.step_entry import Reason, StepStatus
from dock_gateway.extensions.missions.step_kinds import Waypoint
from tests.extensions.missions.examples import CALL, DOCK, FIBONACCI, NOON, PUBLISH, UNDOCK, after, begun, goal, queued


def changed(mission: MissionEntry, facts: Facts = Facts(), seconds: float = 0.0) -> MissionEntry:  # noqa: B008 - frozen
    move = next_move(mission, facts, after(seconds))
    assert isinstance(move, Change), move
    assert move.mission.revision > mission.revision
    return move.mission


def sent(*steps: dict[str, Any]) -> MissionEntry:
    """A mission whose first step is a goal that was accepted at noon."""
    mission = changed(begun(*steps))
    assert next_move(mission, Facts(), NOON) == Send()
    return mission.with_step(goal_id="goal")


def ended(status: GoalStatus, code: str | None = None) -> Facts:
    return Facts(goal=goal(status, code))


def test_one_step_after_the_other() -> None:
    mission = sent(DOCK, {"wait": {"seconds": 10}}, UNDOCK)
    assert next_move(mission, ended(GoalStatus.EXECUTING), after(5)) == Wait(WaitsFor.GOAL)
    mission = changed(mission, ended(GoalStatus.SUCCEEDED), 60)
    assert (mission.step, mission.steps[0].status, mission.current.status) == (1, StepStatus.SUCCEEDED, "waiting")
    mission = changed(mission, seconds=60)
    assert next_move(mission, Facts(), after(61)) == Wait(WaitsFor.TIME, after(70))
    mission = changed(mission, seconds=70)
    mission = changed(mission, seconds=70).with_step(goal_id="other")
    mission = changed(mission, ended(GoalStatus.SUCCEEDED), 90)
    assert (mission.status, mission.step, mission.finished_at) == (MissionStatus.SUCCEEDED, 3, after(90))
    assert [step.attempt for step in mission.steps] == [1, 1, 1]


@pytest.mark.parametrize(
    ("wait", "facts", "seconds"),
    [
        ({"seconds": 0}, Facts(), 0),
        ({"until": "2026-11-30T13:00:30+01:00"}, Facts(), 30),
        ({"battery": 0.8}, Facts(battery=0.8), 1),
    ],
)
def test_what_ends_a_wait(wait: dict[str, Any], facts: Facts, seconds: float) -> None:
    mission = changed(begun({"wait": wait}))
    if seconds:
        assert isinstance(next_move(mission, Facts(battery=0.79), after(seconds - 1)), Wait)
    assert changed(mission, facts, seconds).status is MissionStatus.SUCCEEDED


def test_a_charge_that_is_unknown_is_waited_for() -> None:
    assert next_move(changed(begun({"wait": {"battery": 0.1}})), Facts(), after(1e6)) == Wait(WaitsFor.BATTERY)


def test_a_person_is_waited_for() -> None:
    held = changed(begun({"wait": {"person": True}}, DOCK))
    assert (held.status, held.held_for) == (MissionStatus.HELD, HoldReason.PERSON)
    assert next_move(held, Facts(), after(1e6)) == Wait(WaitsFor.CONTINUE)
    mission = progress.resume(held, after(9))
    assert (mission.status, mission.step) == (MissionStatus.RUNNING, 1)


def test_somebody_elses_goal_comes_first() -> None:
    mission = begun(DOCK)
    assert next_move(mission, Facts(other_goal=True), NOON) == Wait(WaitsFor.OTHER_GOAL)
    assert isinstance(next_move(begun({"wait": {"seconds": 1}}), Facts(other_goal=True), NOON), Change)


def test_a_step_is_tried_again_and_then_fails() -> None:
    mission = sent(DOCK | {"tries": 2}, UNDOCK)
    mission = changed(mission, ended(GoalStatus.ABORTED, "failed_to_charge"), 10)
    assert next_move(mission, Facts(), after(11)) == Wait(WaitsFor.RETRY, after(15))
    mission = changed(mission, seconds=15)
    assert (mission.current.attempt, mission.current.goal_id) == (2, None)
    mission = changed(mission.with_step(goal_id="other"), ended(GoalStatus.REJECTED), 20)
    assert mission.error is not None
    assert (mission.status, mission.error.code, mission.step) == (MissionStatus.FAILED, "goal_aborted", 0)


def test_a_failure_that_does_not_matter() -> None:
    mission = changed(sent(DOCK | {"on_failure": "next"}, UNDOCK), ended(GoalStatus.ABORTED, "no_dock"), 10)
    assert (mission.status, mission.step, mission.steps[0].status) == (MissionStatus.RUNNING, 1, StepStatus.FAILED)


def test_a_goal_that_takes_too_long_is_canceled_first() -> None:
    mission = sent(FIBONACCI | {"timeout_s": 30})
    assert next_move(mission, ended(GoalStatus.EXECUTING), after(29)) == Wait(WaitsFor.GOAL, after(30))
    mission = changed(mission, ended(GoalStatus.EXECUTING), 30)
    assert mission.current.status is StepStatus.RUNNING
    running = ended(GoalStatus.EXECUTING)
    assert next_move(mission, running, after(30)) == Cancel(running.goal)
    failed = changed(mission, ended(GoalStatus.CANCELED), 31)
    assert failed.error == progress.TIMEOUT
    late = changed(mission, ended(GoalStatus.SUCCEEDED), 31)
    assert late.status is MissionStatus.SUCCEEDED
    lost = Facts(goal=goal(GoalStatus.LOST), given_up=True)
    held = changed(mission, lost, 40)
    assert (held.held_for, held.current.status) == (HoldReason.LOST, StepStatus.WAITING)


def test_a_server_that_never_comes() -> None:
    mission = changed(begun(DOCK | {"timeout_s": 60}))
    assert next_move(mission, Facts(), after(59)) == Send()
    assert changed(mission, seconds=60).error == progress.TIMEOUT
    forever = changed(begun(DOCK))
    assert next_move(forever, Facts(), after(82_000)) == Send()
    assert changed(forever, seconds=83_000).error == progress.UNSENT


def test_a_goal_that_the_history_no_longer_has_is_not_sent_again() -> None:
    assert changed(sent(DOCK)).error == progress.GONE


def test_a_lost_goal_may_return() -> None:
    mission = sent(DOCK)
    assert next_move(mission, ended(GoalStatus.LOST), after(1e5)) == Wait(WaitsFor.LOST_GOAL)


@pytest.mark.parametrize(
    ("status", "code", "reason"),
    [
        (GoalStatus.CANCELED, "stopped", HoldReason.STOP),
        (GoalStatus.ABORTED, "stopped", HoldReason.STOP),
        (GoalStatus.REJECTED, "stopped", HoldReason.STOP),
        (GoalStatus.CANCELED, None, HoldReason.CANCELED),
    ],
)
def test_whoever_ends_a_goal_holds_the_mission(status: GoalStatus, code: str | None, reason: HoldReason) -> None:
    held = changed(sent(DOCK), ended(status, code), 10)
    assert (held.status, held.held_for, held.current.status) == (MissionStatus.HELD, reason, StepStatus.WAITING)
    assert next_move(held, Facts(), after(1e6)) == Wait(WaitsFor.CONTINUE)
    mission = changed(progress.resume(held, after(20)), seconds=20)
    assert (mission.current.status, mission.current.attempt) == (StepStatus.RUNNING, 2)


def test_a_stop_holds_a_mission_wherever_it_is() -> None:
    for mission in (begun(DOCK), changed(begun({"wait": {"seconds": 9}})), sent(DOCK)):
        held = changed(mission, Facts(stopped=True, goal=goal(GoalStatus.EXECUTING)), 1)
        assert (held.status, held.held_for) == (MissionStatus.HELD, HoldReason.STOP)
        assert next_move(held, Facts(stopped=True, latched=True), after(2)) == Wait(WaitsFor.STOP_RELEASED)
        assert next_move(held, Facts(stopped=True), after(3)) == Wait(WaitsFor.CONTINUE)


def test_a_goal_that_ends_while_its_mission_is_held() -> None:
    held = changed(sent(DOCK, UNDOCK), Facts(stopped=True, goal=goal(GoalStatus.EXECUTING)), 1)
    move = next_move(held, Facts(stopped=True, goal=goal(GoalStatus.EXECUTING)), after(1))
    assert isinstance(move, Cancel), "another gateway sent it when the robot was stopped"
    lost = Facts(stopped=True, goal=goal(GoalStatus.LOST), given_up=True)
    assert next_move(held, lost, after(1)) == Wait(WaitsFor.CONTINUE)
    again = changed(held, ended(GoalStatus.CANCELED, "stopped"), 2)
    assert (again.status, again.current.status, again.step) == (MissionStatus.HELD, StepStatus.WAITING, 0)
    arrived = changed(held, ended(GoalStatus.SUCCEEDED), 2)
    assert (arrived.status, arrived.held_for, arrived.step) == (MissionStatus.HELD, HoldReason.STOP, 1)


def test_a_pause_comes_before_the_next_step() -> None:
    paused = progress.pause(sent(DOCK, UNDOCK))
    assert next_move(paused, ended(GoalStatus.EXECUTING), NOON) == Wait(WaitsFor.GOAL)
    held = changed(changed(paused, ended(GoalStatus.SUCCEEDED), 5), seconds=5)
    assert (held.status, held.held_for, held.step) == (MissionStatus.HELD, HoldReason.PAUSED, 1)
    assert progress.resume(held, NOON).status is MissionStatus.RUNNING
    waiting = progress.pause(queued(DOCK))
    assert (waiting.status, waiting.active) == (MissionStatus.HELD, False)
    assert progress.resume(waiting, NOON).status is MissionStatus.QUEUED


def test_a_step_is_left_out() -> None:
    held = changed(sent(DOCK, UNDOCK), ended(GoalStatus.CANCELED), 5)
    mission = progress.skip(held, after(6))
    assert (mission.status, mission.step, mission.steps[0].status) == (MissionStatus.RUNNING, 1, StepStatus.SKIPPED)
    assert progress.skip(held.model_copy(update={"steps": held.steps[:1]}), NOON).status is MissionStatus.SUCCEEDED


def test_a_mission_is_canceled_with_its_goal() -> None:
    canceling = progress.cancel(sent(DOCK, UNDOCK), after(5))
    for facts in (ended(GoalStatus.EXECUTING), ended(GoalStatus.LOST)):
        assert next_move(canceling, facts, after(5)) == Cancel(facts.goal)
    for facts in (ended(GoalStatus.CANCELED), Facts(), Facts(goal=goal(GoalStatus.LOST), given_up=True)):
        mission = changed(canceling, facts, 6)
        assert (mission.status, mission.steps[0].status) == (MissionStatus.CANCELED, StepStatus.CANCELED)
    arrived = changed(canceling, ended(GoalStatus.SUCCEEDED), 6)
    assert (arrived.status, arrived.steps[0].status) == (MissionStatus.CANCELED, StepStatus.SUCCEEDED)
    assert progress.cancel(queued(DOCK), NOON).status is MissionStatus.CANCELED


NO = Reason(code="service_timeout", detail="no answer")


@pytest.mark.parametrize("step", [CALL, PUBLISH])
def test_a_message_is_sent_once_by_the_gateway_that_began_its_try(step: dict[str, Any]) -> None:
    assert next_move(begun(step), Facts(other_goal=True), NOON) == Wait(WaitsFor.OTHER_GOAL)
    mission = changed(begun(step))
    assert next_move(mission, Facts(sent=Sent()), after(1)) == Send()
    assert next_move(mission, Facts(sent=None), after(1)) == Wait(WaitsFor.ANSWER, after(65))
    assert changed(mission, Facts(sent=Sent(over=True)), 1).status is MissionStatus.SUCCEEDED
    failed = changed(mission, Facts(sent=Sent(over=True, error=NO)), 1)
    assert (failed.status, failed.error) == (MissionStatus.FAILED, NO)
    stopped = changed(mission, Facts(sent=Sent(over=True, error=NO, by_stop=True)), 1)
    assert (stopped.held_for, stopped.current.status, stopped.current.error) == (HoldReason.STOP, "waiting", NO)


def test_nobody_knows_of_a_message_whose_gateway_was_killed() -> None:
    mission = changed(begun(CALL | {"timeout_s": 20, "tries": 3}))
    assert next_move(mission, Facts(), after(79)) == Wait(WaitsFor.ANSWER, after(80))
    held = changed(mission, seconds=80)
    assert (held.held_for, held.current.error) == (HoldReason.LOST, progress.INTERRUPTED)
    again = changed(progress.resume(held, after(90)), seconds=90)
    assert (again.current.status, again.current.attempt) == (StepStatus.RUNNING, 2)


def test_a_message_that_ends_while_its_mission_is_held_or_canceled() -> None:
    mission = changed(begun(CALL, DOCK))
    held = changed(mission, Facts(stopped=True, sent=Sent()), 1)
    assert next_move(held, Facts(sent=Sent()), after(2)) == Wait(WaitsFor.CONTINUE)
    arrived = changed(held, Facts(sent=Sent(over=True)), 2)
    assert (arrived.status, arrived.held_for, arrived.step) == (MissionStatus.HELD, HoldReason.STOP, 1)
    again = changed(held, Facts(sent=Sent(over=True, error=NO)), 2)
    assert (again.status, again.current.status, again.step) == (MissionStatus.HELD, StepStatus.WAITING, 0)
    canceling = progress.cancel(mission, after(3))
    assert next_move(canceling, Facts(), after(3)) == Wait(WaitsFor.ANSWER, after(65))
    for facts, seconds, status in (
        (Facts(sent=Sent(over=True)), 4, StepStatus.SUCCEEDED),
        (Facts(sent=Sent(over=True, error=NO)), 4, StepStatus.CANCELED),
        (Facts(sent=Sent()), 4, StepStatus.CANCELED),
        (Facts(), 65, StepStatus.CANCELED),
    ):
        ended_mission = changed(canceling, facts, seconds)
        assert (ended_mission.status, ended_mission.steps[0].status) == (MissionStatus.CANCELED, status)


def test_a_notice_stands_until_the_step_after_it_has_ended() -> None:
    mission = changed(changed(begun({"notify": {"text": "Load me", "critical": True}}, {"wait": {"seconds": 9}}, DOCK)))
    assert (mission.step, mission.steps[0].status) == (1, StepStatus.SUCCEEDED)
    notice = mission.notice
    assert notice is not None
    assert (notice.text, notice.critical, notice.told_at, notice.standing) == ("Load me", True, NOON, True)
    assert notice.is_active(after(1e6))
    mission = changed(changed(mission, seconds=20), seconds=29)
    assert mission.step == 2
    assert mission.notice is not None
    assert [mission.notice.is_active(after(seconds)) for seconds in (59.9, 60)] == [True, False]


def test_a_drive_that_another_goal_keeps_from_beginning_is_dropped_and_the_dock_is_asked_for_again() -> None:
    asks = next_move(begun(DOCK), Facts(), NOON)
    assert isinstance(asks, Change)
    drives = waiting.drive(asks.mission, Waypoint(x=1, y=2), Facts(), NOON)
    assert drives is not None
    move = next_move(drives, Facts(other_goal=True), NOON)
    assert isinstance(move, Change)
    assert (move.mission.drive, move.mission.wait_at, move.mission.current) == (None, None, asks.mission.current)
    assert isinstance(next_move(move.mission, Facts(other_goal=True), NOON), Send)
    begins = next_move(drives, Facts(), NOON)
    assert isinstance(begins, Change)
    assert waiting.ask_again(begins.mission) == begins.mission, "its goal may have been sent"
