"""The break of a mission for the battery of its robot: when it begins, what ends it, and what holds it."""

from typing import Any

import pytest

from dock_gateway.core.errors import InvalidField
from dock_gateway.core.goal import GoalStatus
from dock_gateway.extensions.missions import progress, recharge
from dock_gateway.extensions.missions.mission import HoldReason, MissionEntry, MissionStatus, Recharge, RechargeStage
from dock_gateway.extensions.missions.moves import Cancel, Change, Facts, Send, Wait, WaitsFor
from dock_gateway.extensions.missions.notices import alerts_of_holds
from dock_gateway.extensions.missions.progress import next_move
from dock_gateway.extensions.missions.schema import MissionBody
from dock_gateway.extensions.missions.step_entry import StepStatus
from dock_gateway.http.bodies import read_model
from tests.extensions.missions.examples import DOCK, FIBONACCI, NOON, UNDOCK, after, begun, goal

LIMITS = {"below": 0.25, "charge_to": 0.8}
LOW, HIGH = Facts(battery=0.2, discharging=True), Facts(battery=0.8, charging=True)
WAIT = {"wait": {"seconds": 100}}


def changed(mission: MissionEntry, facts: Facts = LOW, seconds: float = 0.0) -> MissionEntry:
    move = next_move(mission, facts, after(seconds))
    assert isinstance(move, Change), move
    assert move.mission.revision > mission.revision
    return move.mission


def low(status: GoalStatus, code: str | None = None, **fields: Any) -> Facts:
    return Facts(battery=0.2, discharging=True, goal=goal(status, code), **fields)


def break_of(mission: MissionEntry) -> Recharge:
    assert mission.recharge is not None
    return mission.recharge


def at_dock(mission: MissionEntry, seconds: float = 0.0) -> MissionEntry:
    """The mission after its robot has docked for its battery, at its charging."""
    sent = changed(mission, seconds=seconds).with_step(goal_id="goal")
    charging = changed(sent, low(GoalStatus.SUCCEEDED), seconds)
    assert break_of(charging).stage is RechargeStage.CHARGING
    return changed(charging, Facts(battery=0.2, charging=True), seconds)


@pytest.mark.parametrize(
    ("limits", "path"),
    [
        ({"below": 0.5}, "battery.charge_to"),
        ({"below": 0.5, "charge_to": 0.5}, "battery.charge_to"),
        ({"below": 0.5, "charge_to": 0.54}, "battery.charge_to"),
        ({"below": 0.5, "charge_to": 1.01}, "battery.charge_to"),
        ({"below": 25, "charge_to": 80}, "battery.below"),
        ({"below": 0, "charge_to": 0.8}, "battery.below"),
        ({"below": 0.96, "charge_to": 1}, "battery.below"),
        ({"below": "0.2", "charge_to": 1}, "battery.below"),
        (0.2, "battery"),
    ],
)
def test_what_limits_cannot_be(limits: object, path: str) -> None:
    with pytest.raises(InvalidField) as refused:
        read_model(MissionBody, {"steps": [DOCK], "battery": limits})
    assert refused.value.errors[0].path == path


@pytest.mark.parametrize("step", [DOCK, UNDOCK, WAIT, {"repeat": {"steps": [FIBONACCI], "times": 2}}])
def test_only_a_goal_that_works_is_interruptible(step: dict[str, Any]) -> None:
    with pytest.raises(InvalidField) as refused:
        read_model(MissionBody, {"steps": [step | {"interruptible": True}]})
    assert refused.value.errors[0].path == "steps.0"


def test_a_mission_that_begins_with_a_low_battery_returns_first() -> None:
    mission = changed(begun(FIBONACCI, battery=LIMITS))
    assert (break_of(mission).stage, mission.step, mission.status) == ("docking", 0, "running")
    mission = changed(mission)
    assert next_move(mission, LOW, NOON) == Send()
    assert (mission.current.verb, mission.position, mission.current.attempt) == ("dock", "recharge-1", 1)


def test_a_robot_charges_undocks_and_goes_on_where_it_was() -> None:
    mission = at_dock(changed(begun(FIBONACCI, battery=LIMITS)))
    assert next_move(mission, Facts(battery=0.79, charging=True), after(9)) == Wait(WaitsFor.BATTERY, after(43_200))
    mission = changed(mission, HIGH, 10)
    assert (mission.recharge, mission.parked) == (None, True)
    mission = changed(mission, HIGH, 10)
    assert break_of(mission).stage is RechargeStage.UNDOCKING
    mission = changed(mission, HIGH, 10).with_step(goal_id="undock")
    assert (mission.current.verb, mission.position) == ("undock", "recharge-2")
    mission = changed(mission, Facts(battery=0.8, goal=goal(GoalStatus.SUCCEEDED)), 20)
    assert (mission.recharge, mission.parked, mission.current.status) == (None, False, StepStatus.WAITING)
    mission = changed(mission, Facts(battery=0.8), 20)
    assert (mission.current.action is not None, mission.current.attempt) == (True, 1)


@pytest.mark.parametrize("step", [UNDOCK, WAIT, DOCK])
def test_a_step_that_needs_none_has_no_undocking_before_it(step: dict[str, Any]) -> None:
    mission = at_dock(changed(begun({"notify": {"text": "Hello"}}, step, battery=LIMITS)))
    mission = changed(mission, HIGH, 10)
    while mission.step == 0 or mission.current.status is StepStatus.WAITING:
        mission = changed(mission, HIGH, 10)
    assert (mission.step, mission.recharge, mission.parked) == (1, None, step == WAIT)


def test_a_robot_that_was_driven_off_its_dock_is_not_undocked() -> None:
    mission = changed(at_dock(changed(begun(FIBONACCI, battery=LIMITS))), HIGH, 10)
    mission = changed(mission, Facts(battery=0.8, docked=False), 10)
    assert (mission.recharge, mission.parked, mission.current.status) == (None, False, StepStatus.RUNNING)


def test_a_step_is_finished_first() -> None:
    mission = changed(begun(FIBONACCI, UNDOCK, battery=LIMITS), HIGH).with_step(goal_id="goal")
    assert next_move(mission, low(GoalStatus.EXECUTING), after(5)) == Wait(WaitsFor.GOAL)
    mission = changed(mission, low(GoalStatus.SUCCEEDED), 9)
    assert (mission.step, mission.recharge) == (1, None)
    assert break_of(changed(mission, seconds=9)).stage is RechargeStage.DOCKING


def test_a_step_that_may_be_interrupted_begins_again_afterwards() -> None:
    step = FIBONACCI | {"interruptible": True, "tries": 2}
    mission = changed(begun(step, battery=LIMITS), HIGH).with_step(goal_id="goal")
    mission = changed(mission, low(GoalStatus.EXECUTING), 5)
    assert (mission.current.error, mission.recharge) == (recharge.LOW, None)
    running = low(GoalStatus.EXECUTING)
    assert next_move(mission, running, after(5)) == Cancel(running.goal)
    for status, code in ((GoalStatus.CANCELED, None), (GoalStatus.ABORTED, "blocked")):
        left = changed(mission, low(status, code), 6)
        assert (left.current.status, left.current.tried, left.status) == (StepStatus.WAITING, 0, "running")
        assert break_of(changed(left, seconds=6)).stage is RechargeStage.DOCKING
    arrived = changed(mission, low(GoalStatus.SUCCEEDED), 6)
    assert arrived.status is MissionStatus.SUCCEEDED
    stopped = changed(mission, low(GoalStatus.CANCELED, "stopped"), 6)
    assert stopped.held_for is HoldReason.STOP
    gone = changed(mission, low(GoalStatus.LOST, given_up=True), 6)
    assert (gone.held_for, gone.current.error) == (HoldReason.LOST, recharge.LOW)


def test_a_wait_goes_on_while_the_robot_charges() -> None:
    mission = changed(begun(WAIT, battery=LIMITS), Facts(battery=0.5))
    assert next_move(mission, Facts(battery=0.2, charging=True), after(5)) == Wait(WaitsFor.TIME, after(100))
    mission = at_dock(changed(mission, seconds=5), 5)
    mission = changed(mission, HIGH, 50)
    assert (mission.recharge, mission.current.status) == (None, StepStatus.RUNNING)
    assert next_move(mission, HIGH, after(99)) == Wait(WaitsFor.TIME, after(100))
    assert changed(mission, HIGH, 100).status is MissionStatus.SUCCEEDED


def test_a_goal_that_was_not_sent_waits_for_the_charge() -> None:
    mission = changed(begun(FIBONACCI, battery=LIMITS), HIGH)
    assert next_move(mission, HIGH, after(5)) == Send()
    left = changed(mission, seconds=5)
    assert (break_of(left).stage, left.steps[0].status) == ("docking", StepStatus.WAITING)
    assert next_move(mission, low(GoalStatus.PENDING), after(5)) == Send()  # it is known by its key: it was sent


def test_who_says_nothing_is_left_alone_and_what_is_unknown_is_not_low() -> None:
    assert changed(begun(FIBONACCI)).recharge is None
    assert changed(begun(FIBONACCI, battery=LIMITS), Facts()).recharge is None
    assert changed(begun(DOCK, battery=LIMITS)).recharge is None
    held = changed(begun({"wait": {"person": True}}, battery=LIMITS), HIGH)
    assert next_move(held, LOW, after(5)) == Wait(WaitsFor.CONTINUE)
    paused = changed(progress.pause(begun(FIBONACCI, battery=LIMITS)))
    assert (paused.held_for, paused.recharge) == (HoldReason.PAUSED, None)


def test_a_robot_that_charges_already_is_not_docked_again() -> None:
    mission = changed(begun(FIBONACCI, battery=LIMITS))
    assert next_move(mission, Facts(battery=0.2, other_goal=True), NOON) == Wait(WaitsFor.OTHER_GOAL)
    mission = changed(mission, Facts(battery=0.2, charging=True))
    assert (break_of(mission).stage, mission.current.status) == ("charging", StepStatus.WAITING)


def test_a_return_that_fails_is_tried_three_times_and_then_held() -> None:
    mission = changed(begun(FIBONACCI, battery=LIMITS))
    for number in range(1, 4):
        seconds = 100 * number
        mission = changed(mission, seconds=seconds)
        assert (mission.current.attempt, mission.current.status) == (number, StepStatus.RUNNING)
        mission = changed(mission.with_step(goal_id="goal"), low(GoalStatus.ABORTED, "no_dock"), seconds)
        if number < 3:
            wait = Wait(WaitsFor.RETRY, after(seconds + 30))
            assert next_move(mission, LOW, after(seconds)) == wait
    assert (mission.status, mission.held_for, break_of(mission).step.tried) == ("held", HoldReason.RECHARGE, 3)
    assert next_move(mission, LOW, after(1e6)) == Wait(WaitsFor.CONTINUE)
    (alert,) = alerts_of_holds([mission, begun(DOCK)])
    assert (alert.critical, alert.robot, alert.title) == (True, "/", "/ could not be charged")
    assert "as the test says" in alert.detail
    again = progress.resume(mission, after(400))
    assert (again.status, break_of(again).step.tried, break_of(again).step.retry_at) == ("running", 0, None)
    assert changed(again, seconds=400).current.attempt == 4
    skipped = progress.skip(mission, after(400))
    assert (skipped.status, skipped.recharge, skipped.recharge_skipped) == ("running", None, True)
    assert changed(skipped, seconds=400).current.action is not None
    assert not changed(skipped, Facts(battery=0.3), 400).recharge_skipped


def test_an_undocking_that_fails_holds_the_mission_too() -> None:
    mission = changed(changed(at_dock(changed(begun(FIBONACCI, battery=LIMITS))), HIGH, 10), HIGH, 10)
    for _ in range(3):
        mission = changed(changed(mission, HIGH, 1000).with_step(goal_id="goal"), low(GoalStatus.ABORTED), 1000)
        mission = mission.with_step(retry_at=None)
    assert (mission.held_for, break_of(mission).stage) == (HoldReason.RECHARGE, RechargeStage.UNDOCKING)
    (alert,) = alerts_of_holds([mission])
    assert alert.title == "/ did not leave its dock"
    skipped = progress.skip(mission, after(2000))
    assert (skipped.recharge, skipped.parked, skipped.recharge_skipped) == (None, False, False)


def test_a_robot_that_slides_off_its_charger_docks_again() -> None:
    mission = at_dock(changed(begun(FIBONACCI, battery=LIMITS)))
    off = changed(mission, LOW, 10)
    assert next_move(off, LOW, after(69)) == Wait(WaitsFor.BATTERY, after(70))
    back = changed(off, Facts(battery=0.2, charging=True), 69)
    assert break_of(back).off_since is None
    mission = changed(off, LOW, 70)
    assert (break_of(mission).stage, break_of(mission).step.error) == ("docking", recharge.NOT_CHARGING)
    mission = changed(mission, LOW, 100)
    assert (mission.current.attempt, break_of(mission).step.tried) == (3, 1)  # of docking, charging and docking


def test_a_battery_that_is_full_at_less_has_its_charge() -> None:
    mission = at_dock(changed(begun(FIBONACCI, battery=LIMITS)))
    assert isinstance(next_move(mission, Facts(battery=0.29, charging=True, full=True), after(5)), Wait)
    assert changed(mission, Facts(battery=0.3, charging=True, full=True), 5).recharge is None
    assert changed(mission, Facts(), 43_200).current.error == recharge.TOO_SLOW


@pytest.mark.parametrize("stage", ["docking", "charging"])
def test_a_stop_holds_a_return_and_somebody_has_to_continue_it(stage: str) -> None:
    mission = changed(begun(FIBONACCI, battery=LIMITS))
    mission = at_dock(mission) if stage == "charging" else changed(mission).with_step(goal_id="goal")
    held = changed(mission, low(GoalStatus.EXECUTING, stopped=True), 5)
    assert (held.held_for, break_of(held).stage) == (HoldReason.STOP, stage)
    assert next_move(held, low(GoalStatus.EXECUTING, latched=True, given_up=True), after(6)) == Wait(
        WaitsFor.STOP_RELEASED
    )
    if stage == "docking":
        held = changed(held, low(GoalStatus.CANCELED, "stopped"), 6)
    assert isinstance(next_move(held, LOW, after(1e6)), Wait)
    again = progress.resume(held, after(10))
    assert again.status is MissionStatus.RUNNING
    if stage == "docking":
        assert changed(again, seconds=10).current.attempt == 2


def test_a_goal_of_a_return_that_somebody_cancels_holds_the_mission() -> None:
    mission = changed(changed(begun(FIBONACCI, battery=LIMITS))).with_step(goal_id="goal")
    held = changed(mission, low(GoalStatus.CANCELED), 5)
    assert (held.held_for, break_of(held).stage) == (HoldReason.CANCELED, RechargeStage.DOCKING)


def test_a_mission_is_canceled_during_its_break() -> None:
    mission = changed(changed(begun(WAIT, battery=LIMITS), Facts(battery=0.5)), seconds=5)
    canceling = progress.cancel(changed(mission, seconds=5).with_step(goal_id="goal"), after(6))
    running = low(GoalStatus.EXECUTING)
    assert next_move(canceling, running, after(6)) == Cancel(running.goal)
    ended = changed(canceling, low(GoalStatus.CANCELED), 7)
    assert (ended.status, ended.recharge, ended.steps[0].status) == ("canceled", None, StepStatus.CANCELED)


def test_what_is_shown_of_a_break() -> None:
    mission = changed(changed(begun(FIBONACCI, battery=LIMITS))).with_step(goal_id="goal")
    document = mission.document("a", None)
    assert document["battery"] == LIMITS
    assert document["recharge"] == {
        "number": 1,
        "stage": "docking",
        "started_at": NOON,
        "tried": 0,
        "goal_id": "goal",
        "error": None,
    }
    assert begun(DOCK).document("a", None)["recharge"] is None
