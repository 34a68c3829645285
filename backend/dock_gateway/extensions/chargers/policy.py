"""Who gets a shared dock, and when it is free again. Pure: facts in, records out; no I/O, and no clock of its own.

Each dock has one record. A change is stored only if the record is still the one that was read, so that several
gateways cannot give a dock to two robots.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import Enum, StrEnum, auto

from dock_gateway.extensions.chargers.dock import MAX_GOALS, DockEntry, DockRecord, Hold, WaitEntry

# A robot that has not asked for so long waits no more.
ASKS_WITHIN = timedelta(seconds=30)
# But it has so long to drive to where it waits.
ARRIVES_WITHIN = timedelta(minutes=5)
# One that has waited for so long comes first, whatever its charge.
PATIENCE = timedelta(minutes=30)
# A goal that is not stored so long after its reservation was never sent: its gateway has ended.
SENT_WITHIN = timedelta(seconds=60)

FREE = DockRecord()


class GoalState(Enum):
    """What has become of a docking goal."""

    RUNS = auto()
    LOST = auto()  # it may return, and nothing has been learned of the robot since
    SUCCEEDED = auto()
    ABORTED = auto()
    ENDED = auto()  # canceled, stopped, rejected, or lost and followed by a later one
    MISSING = auto()  # it is not stored


@dataclass(frozen=True)
class Seen:
    """What is known about the robot that has a dock.

    Attributes:
        goals: What has become of the goals of the record, by their ids.
        docked: Whether it is docked, or touches a dock, and this may be the one.
        away: Whether it has been seen off any dock for a while.
        elsewhere: Whether it stands at another dock, later.
    """

    goals: Mapping[str, GoalState]
    docked: bool = False
    away: bool = False
    elsewhere: bool = False


class Obstacle(StrEnum):
    """Why a robot does not get a dock."""

    UNFIT = "dock_not_for_robot"
    OUT_OF_ORDER = "dock_out_of_order"
    OCCUPIED = "dock_occupied"
    QUEUE = "queue"  # it is free, and another robot has waited for it longer
    TOO_MANY = "too_many"  # goals of the robot itself


@dataclass(frozen=True)
class Ask:
    """A robot's request for one of several docks.

    Attributes:
        robot: Its name.
        docks: Those that it would take.
        groups: The groups that it is in.
        drives: Whether it drives to a waiting place, if it has to wait.
    """

    robot: str
    docks: Sequence[str]
    groups: tuple[str, ...] = ()
    drives: bool = True


def obstacle(ask: Ask, dock: DockEntry | None, record: DockRecord) -> Obstacle | None:
    """Return why a robot cannot have a dock now, apart from the queue; None if it can. A dock of None is not shared."""
    if dock is None:
        return None
    if not dock.robots.covers(ask.robot, ask.groups):
        return Obstacle.UNFIT
    if record.out_of_order_at is not None:
        return Obstacle.OUT_OF_ORDER
    if record.hold is None:
        return None
    if record.hold.robot != ask.robot:
        return Obstacle.OCCUPIED
    return Obstacle.TOO_MANY if len(record.hold.goal_ids) >= MAX_GOALS else None


def choices(
    ask: Ask,
    docks: Mapping[str, DockEntry],
    records: Mapping[str, DockRecord],
    waits: Mapping[str, WaitEntry],
    now: datetime,
    *,
    by_charge: bool = False,
) -> tuple[list[str], dict[str, Obstacle]]:
    """Return the docks that a robot may have now, and for each of the others the reason why not.

    Args:
        ask: Which it would take.
        docks: The shared ones.
        records: What has happened there.
        waits: The robots that wait, by their names.
        now: The time.
        by_charge: Whether the robot with the lowest charge comes first, not the one that has waited longest.
    """
    before = earlier(ask.robot, waits, now, by_charge=by_charge)
    free: list[str] = []
    obstacles: dict[str, Obstacle] = {}
    for dock_id in ask.docks:
        record = records.get(dock_id, FREE)
        reason = obstacle(ask, docks.get(dock_id), record)
        if reason is None and record.hold is None and any(dock_id in waits[robot].docks for robot in before):
            reason = Obstacle.QUEUE
        if reason is None:
            free.append(dock_id)
        else:
            obstacles[dock_id] = reason
    return free, obstacles


def best(ask: Ask, free: Sequence[str], records: Mapping[str, DockRecord], distances: Mapping[str, float]) -> str:
    """Return which of the docks of `choices` a robot gets: one that it has already, the nearest, or the first.

    Args:
        ask: What it has asked for.
        free: The docks, one at least.
        records: What has happened there.
        distances: How far the robot is from them, in metres, of those for which that is known.
    """

    def place(dock_id: str) -> tuple[bool, float]:
        hold = records.get(dock_id, FREE).hold
        return hold is None or hold.robot != ask.robot, distances.get(dock_id, math.inf)

    return min(free, key=place)


def earlier(robot: str, waits: Mapping[str, WaitEntry], now: datetime, *, by_charge: bool = False) -> list[str]:
    """Return the robots that wait and come before one, the first first. One that does not wait comes last."""
    queue = in_order({name: wait for name, wait in waits.items() if is_waiting(wait, now)}, now, by_charge=by_charge)
    return queue[: queue.index(robot)] if robot in queue else queue


def is_waiting(wait: WaitEntry, now: datetime) -> bool:
    """Return whether a robot still asks, or is driving to where it waits."""
    drives = wait.arrives_by is not None and wait.asked_at <= now < wait.arrives_by
    return drives or abs(now - wait.asked_at) < ASKS_WITHIN


def waits_for(ask: Ask, docks: Mapping[str, DockEntry], known: Mapping[str, WaitEntry], now: datetime) -> WaitEntry:
    """Return the entry of a robot that has asked, and waits.

    It waits at the first free waiting place of these docks, if it drives there, and keeps that place until it waits no
    more.

    Args:
        ask: What it would take.
        docks: The shared docks.
        known: The robots that wait, by their names.
        now: The time.
    """
    before = known.get(ask.robot)
    if before is None or before.docks != tuple(ask.docks) or not is_waiting(before, now):
        before = WaitEntry(docks=tuple(ask.docks), since_at=now, asked_at=now)
    taken = [each.wait_at for name, each in known.items() if name != ask.robot and is_waiting(each, now)]
    places = [place for dock_id in ask.docks if dock_id in docks for place in docks[dock_id].waiting_places]
    free = [place for place in places if place not in taken and ask.drives]
    place = before.wait_at if before.wait_at in free else next(iter(free), None)
    drives = place is not None and place != before.wait_at
    return before.model_copy(
        update={"asked_at": now, "wait_at": place, "arrives_by": now + ARRIVES_WITHIN if drives else None}
    )


def in_order(waits: Mapping[str, WaitEntry], now: datetime, *, by_charge: bool = False) -> list[str]:
    """Return the robots that wait, the first first."""

    def place(robot: str) -> tuple[object, ...]:
        wait = waits[robot]
        if not by_charge or now - wait.since_at >= PATIENCE:
            return 0, wait.since_at.timestamp(), robot
        return 1, 1.0 if wait.battery is None else wait.battery, wait.since_at.timestamp(), robot

    return sorted(waits, key=place)


def reserve(record: DockRecord, robot: str, goal_id: str, now: datetime) -> DockRecord:
    """Return the record of a dock after a robot that `obstacle` lets have it has got it for a goal."""
    hold = record.hold or Hold(robot=robot, since_at=now)
    goals = tuple(dict.fromkeys((*hold.goal_ids, goal_id)))
    return record.model_copy(update={"hold": hold.model_copy(update={"goal_ids": goals, "asked_at": now})})


def follow(record: DockRecord, seen: Seen, now: datetime, failures: int = 0) -> DockRecord:
    """Return the record of a dock after what was seen of the robot that has it.

    Args:
        record: The record.
        seen: What was seen.
        now: The time.
        failures: Number of failed dockings in a row after which the dock is out of order; 0: never.
    """
    hold = record.hold
    if hold is None or hold.robot is None:
        return record
    open_goals = tuple(each for each in hold.goal_ids if _may_run(seen.goals.get(each), hold, now))
    ended = [seen.goals[each] for each in hold.goal_ids if each not in open_goals and each in seen.goals]
    arrived = GoalState.SUCCEEDED in ended
    counted = _count(record, arrived=arrived, aborted=ended.count(GoalState.ABORTED), failures=failures, now=now)
    return counted.model_copy(update={"hold": _follow_hold(hold, open_goals, seen, now, arrived=arrived)})


def _may_run(state: GoalState | None, hold: Hold, now: datetime) -> bool:
    if state is GoalState.MISSING:
        return abs(now - (hold.asked_at or hold.since_at)) < SENT_WITHIN
    return state in (None, GoalState.RUNS, GoalState.LOST)


def _follow_hold(hold: Hold, open_goals: tuple[str, ...], seen: Seen, now: datetime, *, arrived: bool) -> Hold | None:
    """Return who has the dock; None if it is free."""
    standing = hold.standing or arrived
    if not open_goals and not arrived:
        if seen.elsewhere or seen.away or (not standing and not seen.docked):
            return None
        standing = True
    changed: dict[str, object] = {"goal_ids": open_goals, "standing": standing}
    if arrived or (standing and not hold.standing):
        changed |= {"since_at": now, "by": None}
    return hold.model_copy(update=changed)


def _count(record: DockRecord, *, arrived: bool, aborted: int, failures: int, now: datetime) -> DockRecord:
    """Return the record with the dockings that have failed."""
    if arrived:
        return record.model_copy(update={"failures": 0})
    if not aborted:
        return record
    count = record.failures + aborted
    changed: dict[str, object] = {"failures": count}
    if failures and count >= failures and record.out_of_order_at is None:
        changed |= {"out_of_order_at": now, "note": f"{count} dockings in a row have failed"}
    return record.model_copy(update=changed)


def stand(record: DockRecord, robot: str | None, by: str | None, now: datetime) -> DockRecord:
    """Return the record of a dock where a robot was seen to stand; None: one without a gateway."""
    goals = record.hold.goal_ids if record.hold is not None and record.hold.robot == robot else ()
    return record.model_copy(update={"hold": Hold(robot=robot, standing=True, goal_ids=goals, since_at=now, by=by)})


def left(record: DockRecord, running: Collection[str], now: datetime) -> DockRecord | None:
    """Return the record after a person reported the dock empty; None while a goal drives a robot there."""
    if record.hold is not None and any(goal_id in running for goal_id in record.hold.goal_ids):
        return None
    return record.model_copy(update={"hold": None, "cleared_at": now})
