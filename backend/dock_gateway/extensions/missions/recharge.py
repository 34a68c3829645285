"""The break that a mission makes for the battery of its robot: it docks, charges, and undocks before it moves on.

The break has one step at a time, which is carried out as those of the mission are. Rules over plain data.
"""

from datetime import datetime, timedelta

from dock_gateway.extensions.missions.battery import LEAST_CHARGE
from dock_gateway.extensions.missions.mission import HoldReason, MissionEntry, MissionStatus, Recharge, RechargeStage
from dock_gateway.extensions.missions.moves import Change, Facts, Move, Wait, WaitsFor
from dock_gateway.extensions.missions.step_entry import Reason, StepEntry, StepStatus
from dock_gateway.extensions.missions.step_kinds import WaitStep

# How often the robot is docked, or undocked, before a person has to see to it; and the time between two tries.
TRIES = 3
RETRY_AFTER = timedelta(seconds=30)
# Seconds that a robot has to dock, also if another one has the dock first; to undock; and for its charge.
DOCK_WITHIN, UNDOCK_WITHIN, CHARGE_WITHIN = 7200.0, 300.0, 43_200.0
# How long the battery of a docked robot has to be discharging until the robot counts as off its charger.
OFF_CHARGER = timedelta(seconds=60)
LOW = Reason(code="low_battery", detail="the robot returns to its dock first, as its battery is low")
NOT_CHARGING = Reason(code="off_charger", detail="the battery of the docked robot was discharging for a minute")
TOO_SLOW = Reason(code="step_timeout", detail="the battery did not have its charge within 12 hours")


def is_due(mission: MissionEntry, facts: Facts) -> bool:
    """Return whether the robot has to return before another step begins. A charge that is unknown is not low.

    One that waits for a dock has returned, as far as it can.
    """
    limits = mission.limits
    if limits is None or mission.recharge is not None or mission.drive is not None or mission.recharge_skipped:
        return False
    return facts.battery is not None and facts.battery < limits.below


def has_recovered(mission: MissionEntry, facts: Facts) -> bool:
    """Return whether the battery of a mission that went on without a break counts again."""
    limits = mission.limits
    charged = limits is not None and facts.battery is not None and facts.battery >= limits.below + LEAST_CHARGE
    return mission.recharge_skipped and charged


def leave_step(mission: MissionEntry, facts: Facts, now: datetime) -> Move | None:
    """Return how a mission leaves the step that is running, for its battery; None if it stays at it."""
    step = mission.current
    if not is_due(mission, facts) or step.waits_for_person:
        return None
    if step.wait is not None:
        return None if facts.charging else Change(begin(mission, now))
    if step.verb == "dock" or not step.sends_goal:
        return None
    if step.goal_id is None and facts.goal is None:
        return Change(begin(mission.with_step(**_to_begin_again(now)), now))  # nothing was sent
    if step.interruptible and step.goal_id is not None and step.error is None:
        return Change(mission.with_step(error=LOW))  # its goal is canceled for this
    return None


def _to_begin_again(now: datetime) -> dict[str, object]:
    return {"status": StepStatus.WAITING, "finished_at": now, "error": LOW}


def before_goal(mission: MissionEntry, facts: Facts, now: datetime) -> MissionEntry | None:
    """Return the mission with what comes before its step begins now; None: nothing."""
    step = mission.current
    if mission.drive is not None:
        return None
    if mission.recharge is not None:
        is_there = mission.recharge.stage is RechargeStage.DOCKING and facts.charging
        return go_on(mission, now) if is_there else None
    if mission.parked and step.sends_goal and step.verb is None and facts.docked is not False:
        return undock(mission, now)
    return None


def begin(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return the mission on its way to the dock."""
    return _at(mission.but(recharges=mission.recharges + 1), RechargeStage.DOCKING, now)


def undock(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return the mission on its way off the dock, on which a break has left the robot."""
    return _at(mission.but(recharges=mission.recharges + 1), RechargeStage.UNDOCKING, now)


def go_on(mission: MissionEntry, now: datetime) -> MissionEntry:
    """Return the mission after a step of its break has succeeded."""
    recharge = _of(mission)
    if recharge.stage is RechargeStage.DOCKING:
        return _at(mission, RechargeStage.CHARGING, now, tried=recharge.step.tried)
    return mission.but(recharge=None, parked=recharge.stage is RechargeStage.CHARGING)


def fail(mission: MissionEntry, error: Reason, now: datetime) -> MissionEntry:
    """Return the mission after a try of a step of its break has failed: once more, or held for a person."""
    recharge = _of(mission)
    stage = RechargeStage.UNDOCKING if recharge.stage is RechargeStage.UNDOCKING else RechargeStage.DOCKING
    tried = recharge.step.tried + 1
    again = _at(mission, stage, now, tried=tried, error=error, finished_at=now, retry_at=now + RETRY_AFTER)
    return again if tried < TRIES else again.but(status=MissionStatus.HELD, held_for=HoldReason.RECHARGE)


def skip(mission: MissionEntry) -> MissionEntry:
    """Return the mission without its break: the robot goes on with its battery as it is, or as it stands."""
    stays_low = _of(mission).stage is not RechargeStage.UNDOCKING
    return mission.but(recharge=None, parked=False, recharge_skipped=stays_low)


def follow_charge(mission: MissionEntry, facts: Facts, now: datetime) -> Move:
    """Return what comes next while the robot charges."""
    recharge = _of(mission)
    since = recharge.off_since
    # Whoever sends it a goal has the robot until that has ended.
    off = facts.discharging and not facts.other_goal
    if _is_charged(mission, facts):
        return Change(go_on(mission, now))
    if recharge.step.is_late(now):
        return Change(fail(mission, TOO_SLOW, now))
    if off and since is not None and now >= since + OFF_CHARGER:
        return Change(fail(mission, NOT_CHARGING, now))
    if off is (since is None):
        return Change(mission.but(recharge=recharge.model_copy(update={"off_since": now if off else None})))
    return Wait(WaitsFor.BATTERY, recharge.step.fails_at if since is None else since + OFF_CHARGER)


def _is_charged(mission: MissionEntry, facts: Facts) -> bool:
    """Return whether the battery has the charge that the mission goes on with; one that is full cannot have more."""
    limits = mission.limits
    if limits is None:
        return True
    least = limits.below + LEAST_CHARGE if facts.full else limits.charge_to
    return facts.battery is not None and facts.battery >= min(least, limits.charge_to)


def _of(mission: MissionEntry) -> Recharge:
    if mission.recharge is None:
        raise AssertionError("the mission has no break")
    return mission.recharge


def _at(mission: MissionEntry, stage: RechargeStage, now: datetime, **fields: object) -> MissionEntry:
    """Return the mission at a stage of its break. Tries are counted on: no goal has the key of another."""
    before, limits = mission.recharge, mission.limits
    what: dict[str, object] = {
        RechargeStage.DOCKING: {"dock": {}, "timeout_s": DOCK_WITHIN},
        RechargeStage.CHARGING: {
            "wait": WaitStep(battery=1.0 if limits is None else limits.charge_to),
            "timeout_s": CHARGE_WITHIN,
        },
        RechargeStage.UNDOCKING: {"undock": {}, "timeout_s": UNDOCK_WITHIN},
    }[stage]
    step = StepEntry(**what, tries=TRIES, attempt=0 if before is None else before.step.attempt, **fields)  # type: ignore[arg-type]
    began = now if before is None else before.started_at
    return mission.but(recharge=Recharge(stage=stage, number=mission.recharges, started_at=began, step=step))
