"""What a mission does next: rules over plain data, without ROS, a clock or a database.

A step is carried out once: it is `running`, with the number of its try, before anything is sent, and its goal has a key
made of the mission, the step and the try, by which it is found again after a restart. One gateway sends it (`sender`).
"""

from datetime import datetime, timedelta

from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.extensions.missions import recharge, sender, waiting
from dock_gateway.extensions.missions.mission import HoldReason, MissionEntry, MissionStatus, Notice, RechargeStage
from dock_gateway.extensions.missions.moves import Cancel, Change, Facts, Move, Send, Wait, WaitsFor
from dock_gateway.extensions.missions.program import end, enter, fail_step, go_on, skip_step
from dock_gateway.extensions.missions.step_entry import Reason, StepEntry, StepStatus
from dock_gateway.extensions.missions.step_kinds import WaitStep

# Between two tries of a step.
RETRY_AFTER = timedelta(seconds=5)
# A step whose goal could not be sent by then has failed: its key is kept for a day, and only that tells after a restart
# whether the goal was sent.
SEND_WITHIN = timedelta(hours=23)
UNSENT = Reason(code="not_sent", detail="the goal could not be sent within 23 hours")
GONE = Reason(code="goal_not_found", detail="the history no longer has the goal")
INTERRUPTED = Reason(
    code="step_interrupted", detail="the gateway ended during the step; nobody knows whether it was carried out"
)
# A call or a message that no gateway has ended so long after its time is over: the one that sent it was killed.
ENDS_WITHIN = timedelta(seconds=60)
TIMEOUT = Reason(code="step_timeout", detail="the step took longer than its timeout_s")
# The code of a goal that a stop has ended.
STOPPED = "stopped"


def next_move(mission: MissionEntry, facts: Facts, now: datetime) -> Move:
    """Return what comes next for a mission that has begun and has not ended."""
    if mission.status is MissionStatus.CANCELING:
        return _cancel(mission, facts, now)
    if mission.status is MissionStatus.HELD:
        return _hold(mission, facts, now)
    if facts.stopped or facts.latched:
        return Change(stop(mission))
    if recharge.has_recovered(mission, facts):
        return Change(mission.but(recharge_skipped=False))
    if mission.current.status is StepStatus.RUNNING:
        others = sender.wait_for_sender(mission.current, facts, now)
        return others or recharge.leave_step(mission, facts, now) or _follow(mission, facts, now)
    return _begin(mission, facts, now)


def _begin(mission: MissionEntry, facts: Facts, now: datetime) -> Move:
    step = mission.current
    if mission.pausing:
        return Change(mission.but(status=MissionStatus.HELD, held_for=HoldReason.PAUSED, pausing=False))
    if recharge.is_due(mission, facts) and step.verb != "dock":
        return Change(recharge.begin(mission, now))
    if step.retry_at is not None and now < step.retry_at:
        return Wait(WaitsFor.RETRY if step.tried else WaitsFor.TIME, step.retry_at)
    if facts.other_goal and (step.sends_goal or step.is_message):
        return Wait(WaitsFor.OTHER_GOAL) if mission.drive is None else Change(waiting.ask_again(mission))
    if (made := recharge.before_goal(mission, facts, now)) is not None:
        return Change(made)
    begun = mission.with_step(
        status=StepStatus.RUNNING,
        attempt=step.attempt + 1,
        drives_to=facts.place,
        goal_id=None,
        started_at=now,
        finished_at=None,
        retry_at=None,
        error=None,
        **sender.taken_on(facts, now),
    )
    begun = begun.model_copy(update={"wait_at": mission.driving_to})
    if step.place is not None and facts.place is None:
        gone = Reason(code="place_not_found", detail=f"there is no place {step.place} any more")
        begun = fail(begun, gone, now)
    elif step.sends_goal:
        begun = begun.model_copy(update={"parked": False})
    elif step.waits_for_person:
        begun = begun.model_copy(update={"status": MissionStatus.HELD, "held_for": HoldReason.PERSON})
    return Change(begun)


def _follow(mission: MissionEntry, facts: Facts, now: datetime) -> Move:
    """Return what comes next while the present step is running."""
    step = mission.current
    if mission.recharge is not None and mission.recharge.stage is RechargeStage.CHARGING:
        return recharge.follow_charge(mission, facts, now)
    if step.is_message:
        return _follow_message(mission, facts, now)
    if step.notify is not None:
        notice = Notice(text=step.notify.text, critical=step.notify.critical, told_at=now)
        return Change(succeed(mission, now).model_copy(update={"notice": notice}))
    if step.wait is None:
        return _follow_goal(mission, facts, now)
    return _follow_wait(mission, step.wait, facts, now)


def _follow_wait(mission: MissionEntry, wait: WaitStep, facts: Facts, now: datetime) -> Move:
    """Return what comes next while the present step waits."""
    step = mission.current
    ends_at = wait.ends_at(step.started_at or now)
    charged = wait.battery is not None and facts.battery is not None and facts.battery >= wait.battery
    if charged or (ends_at is not None and now >= ends_at):
        return Change(succeed(mission, now))
    if step.is_late(now):
        return Change(fail(mission, TIMEOUT, now))
    if wait.battery is not None:
        return Wait(WaitsFor.BATTERY, step.fails_at)
    return Wait(WaitsFor.TIME, min(filter(None, (ends_at, step.fails_at))))


def _follow_goal(mission: MissionEntry, facts: Facts, now: datetime) -> Move:
    """Return what comes next while the goal of the present step is to be sent, or runs."""
    step, goal, late = mission.current, facts.goal, mission.current.is_late(now)
    if step.goal_id is None and not late:
        if now - (step.started_at or now) >= SEND_WITHIN:
            return Change(fail(mission, UNSENT, now))
        return sender.before_send(mission, facts, now) or Send()
    if goal is None:
        return Change(fail(mission, TIMEOUT if step.goal_id is None else GONE, now))
    if goal.status.final:
        return Change(_conclude(mission, goal, now))
    if late or step.error is not None:
        return _give_up(mission, goal, facts, now)
    return Wait(WaitsFor.LOST_GOAL if goal.status is GoalStatus.LOST else WaitsFor.GOAL, step.fails_at)


def _follow_message(mission: MissionEntry, facts: Facts, now: datetime) -> Move:
    """Return what comes next while the call or message of the present step is to be sent, or may have been sent."""
    sent = facts.sent
    if sent is None:
        if now < _message_ends_at(mission.current, now):
            return Wait(WaitsFor.ANSWER, _message_ends_at(mission.current, now))
        return Change(_again(mission, INTERRUPTED, now).but(status=MissionStatus.HELD, held_for=HoldReason.LOST))
    if not sent.over:
        return Send()
    if sent.error is None:
        return Change(succeed(mission, now))
    return Change((hold_for_stop if sent.by_stop else fail)(mission, sent.error, now))


def _message_ends_at(step: StepEntry, now: datetime) -> datetime:
    """Return when no gateway is sending the call or message of a step any more."""
    return (step.started_at or now) + timedelta(seconds=step.answer_within) + ENDS_WITHIN


def _give_up(mission: MissionEntry, goal: Goal, facts: Facts, now: datetime) -> Move:
    """Return what comes next when the goal of the present step takes too long, or the robot has to charge first."""
    error = mission.current.error
    if error is None:  # which says, also after a restart, that it is canceled for this
        return Change(mission.with_step(error=TIMEOUT))
    if not facts.given_up:
        return Cancel(goal)
    # Nobody knows what the robot does, or whether it was switched off and on: it does not move again by itself.
    return Change(_again(mission, error, now).but(status=MissionStatus.HELD, held_for=HoldReason.LOST))


def _reason_of(goal: Goal, code: str, otherwise: str) -> Reason:
    """Return why a goal ended as it did; with this code and sentence if that is not known."""
    if goal.error is None:
        return Reason(code=code, detail=otherwise)
    return Reason(code=goal.error.code, detail=goal.error.detail)


def _conclude(mission: MissionEntry, goal: Goal, now: datetime) -> MissionEntry:
    """Return the mission after the goal of its step has ended."""
    if goal.status is GoalStatus.SUCCEEDED:
        return succeed(mission, now)
    if goal.error is not None and goal.error.code == STOPPED:
        return hold_for_stop(mission, _reason_of(goal, STOPPED, ""), now)
    error = mission.current.error
    if error is not None:  # it was canceled for this
        return _again(mission, error, now) if error == recharge.LOW else fail(mission, error, now)
    if goal.status is GoalStatus.CANCELED:
        reason = _reason_of(goal, "goal_canceled", "the goal was canceled, and not by the mission")
        return _again(mission, reason, now).but(status=MissionStatus.HELD, held_for=HoldReason.CANCELED)
    return fail(mission, _reason_of(goal, "goal_aborted", "the goal was not reached"), now)


def hold_for_stop(mission: MissionEntry, error: Reason, now: datetime) -> MissionEntry:
    """Return a mission whose goal was stopped, or not sent for a stop."""
    return _again(mission, error, now).but(status=MissionStatus.HELD, held_for=HoldReason.STOP)


def _again(mission: MissionEntry, error: Reason, now: datetime) -> MissionEntry:
    """Return the mission with its step to be begun once more."""
    return mission.with_step(status=StepStatus.WAITING, finished_at=now, error=error)


def _hold(mission: MissionEntry, facts: Facts, now: datetime) -> Move:
    """Return what comes next while a mission is held.

    A goal that still runs is canceled: the stop has not ended it if another gateway sent it at that moment.
    """
    goal = facts.goal if mission.current.has_goal else None
    if goal is not None and not goal.status.final and not facts.given_up:
        return Cancel(goal)
    if goal is not None and goal.status.final:
        if goal.status is GoalStatus.SUCCEEDED:
            return Change(_held_on(mission, now))
        reason = _reason_of(goal, "goal_canceled", "the goal ended while the mission was held")
        return Change(_again(mission, reason, now))
    if mission.current.has_message and facts.sent is not None and facts.sent.over:
        if facts.sent.error is None:
            return Change(_held_on(mission, now))
        return Change(_again(mission, facts.sent.error, now))
    return Wait(WaitsFor.STOP_RELEASED if facts.latched else WaitsFor.CONTINUE)


def _held_on(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return a held mission whose step has succeeded: it is held before the next one."""
    following = succeed(mission, now)
    held = {} if following.status.ended else {"status": mission.status, "held_for": mission.held_for}
    return following.model_copy(update=held)


def _cancel(mission: MissionEntry, facts: Facts, now: datetime) -> Move:
    """Return what comes next while a mission is being canceled: its goal ends first."""
    if (others := sender.wait_for_sender(mission.current, facts, now)) is not None:
        return others
    goal = facts.goal if mission.current.has_goal else None
    if goal is not None and not goal.status.final and not facts.given_up:
        return Cancel(goal)
    sent, ends_at = facts.sent, _message_ends_at(mission.current, now)
    if mission.current.has_message and sent is None and now < ends_at:
        return Wait(WaitsFor.ANSWER, ends_at)
    arrived = goal is not None and goal.status is GoalStatus.SUCCEEDED
    arrived |= sent is not None and sent.over and sent.error is None
    own = mission.recharge is None and mission.drive is None
    status = StepStatus.SUCCEEDED if arrived and own else StepStatus.CANCELED
    mission = mission.but(recharge=None, drive=None)
    return Change(end(mission.with_step(status=status, finished_at=now), MissionStatus.CANCELED, now))


def succeed(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return the mission after its step has succeeded."""
    if mission.drive is not None:
        return mission.but(drive=None)
    if mission.recharge is not None:
        return recharge.go_on(mission, now)
    return go_on(mission.with_step(status=StepStatus.SUCCEEDED, finished_at=now, error=None), now)


def fail(mission: MissionEntry, error: Reason, now: datetime) -> MissionEntry:
    """Return the mission after a try of its step has failed."""
    if mission.drive is not None:
        return mission.but(drive=None)
    if mission.recharge is not None:
        return recharge.fail(mission, error, now)
    step = mission.current
    tried = step.tried + 1
    if tried < step.tries:
        later = {"status": StepStatus.WAITING, "tried": tried, "retry_at": now + RETRY_AFTER}
        return mission.with_step(**later, finished_at=now, error=error)
    return fail_step(mission.with_step(tried=tried), error, now)


def accept(mission: MissionEntry, goal_id: str) -> MissionEntry:
    """Return the mission after the goal of its step was accepted: its robot is on its way."""
    return mission.with_step(goal_id=goal_id).model_copy(update={"wait_at": mission.driving_to})


def begins_message(before: MissionEntry, after: MissionEntry) -> bool:
    """Return whether a change begins a try of a call or a message."""
    return after.position == before.position and after.current.has_message and not before.current.has_message


def has_try(mission: MissionEntry | None, begun: MissionEntry) -> bool:
    """Return whether a mission goes on with the try at which it was; None: it has ended."""
    if mission is None or mission.status is not MissionStatus.RUNNING or mission.position != begun.position:
        return False
    return mission.current.status is StepStatus.RUNNING and mission.current.attempt == begun.current.attempt


def start(mission: MissionEntry, now: datetime, robot: str | None = None) -> MissionEntry:
    """Return a queued mission that has its turn; `robot` is that which takes it, by default its own."""
    return enter(mission.but(robot=robot or mission.robot, status=MissionStatus.RUNNING, started_at=now), now)


def stop(mission: MissionEntry) -> MissionEntry:
    """Return a mission that is held for a stop; a goal that runs is canceled, and followed to its end."""
    return mission.but(status=MissionStatus.HELD, held_for=HoldReason.STOP)


def cancel(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return a mission that is being canceled; one that has not begun has ended."""
    if mission.started_at is None:
        return end(mission, MissionStatus.CANCELED, now)
    return mission.but(status=MissionStatus.CANCELING, held_for=None, pausing=False)


def pause(mission: MissionEntry) -> MissionEntry:
    """Return a mission that is held before its next step; one that has not begun is held at once."""
    if mission.status is MissionStatus.QUEUED:
        return mission.but(status=MissionStatus.HELD, held_for=HoldReason.PAUSED)
    return mission.but(pausing=True)


def skip(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return a held mission that goes on without its step, or without its break for the battery."""
    mission = mission.but(drive=None)
    return resume(skip_step(mission, now) if mission.recharge is None else recharge.skip(mission), now)


def resume(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return a held mission that goes on: with its step from the beginning, unless that waited for this."""
    if mission.status is not MissionStatus.HELD:
        return mission
    if mission.started_at is None:
        return mission.but(status=MissionStatus.QUEUED, held_for=None, allowed_at=now)
    # The robot may be elsewhere by now, so that it no longer counts as waiting at its place.
    going = {"status": MissionStatus.RUNNING, "held_for": None, "allowed_at": now, "wait_at": mission.driving_to}
    goes_on = waiting.ask_again(mission.but(**going))
    if mission.held_for is HoldReason.PERSON and goes_on.current.waits_for_person:
        return succeed(goes_on, now)
    if goes_on.current.status is StepStatus.WAITING:
        return goes_on.with_step(tried=0, retry_at=None)
    return goes_on
