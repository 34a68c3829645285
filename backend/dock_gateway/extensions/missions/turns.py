"""Rules over plain data: whose turn it is, which robot takes a mission of a group, and where a moved mission goes.

All missions that have not begun are in one order: the highest priority first, then the lowest `order`. The queue of a
robot is what of it the robot may take: the missions for it, and those for its groups.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from datetime import datetime

from dock_gateway.core.errors import Conflict, NotFound
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moves import WaitsFor

Missions = Mapping[str, MissionEntry]

# Between the numbers of missions that are next to each other: a second, as new ones are numbered by the time.
SPACING = 1_000_000


# Returns the robots that are in a group.
Members = Callable[[str], Collection[str]]


@dataclass(frozen=True)
class RobotFacts:
    """What is known of a robot that may take missions of its groups.

    Attributes:
        groups: The groups that it is in.
        free: Whether it can begin one now, if it is on none: it is heard, its battery is not low, and neither a stop
            nor a goal keeps it.
        charge: Of its battery, 0 to 1.
        stopped_at: When it was last stopped or released; None if never.
    """

    groups: tuple[str, ...] = ()
    free: bool = False
    charge: float = 0.0
    stopped_at: datetime | None = None


NO_ROBOTS: Mapping[str, RobotFacts] = {}


@dataclass(frozen=True)
class Turns:
    """Whose turn it is.

    Attributes:
        on: The mission that each robot is on, or begins now.
        waits: What the others wait for.
    """

    on: Mapping[str, str]
    waits: Mapping[str, WaitsFor]


def in_turn(missions: Missions) -> list[tuple[str, MissionEntry]]:
    """Return the missions that have not begun, in the order in which they do."""
    queued = (item for item in missions.items() if item[1].in_queue)
    return sorted(queued, key=lambda item: (*item[1].turn, item[0]))


def find_turns(missions: Missions, robots: Mapping[str, RobotFacts] = NO_ROBOTS) -> Turns:
    """Return which mission each robot is on, or begins now, and what the others wait for.

    Args:
        missions: The missions that have not ended.
        robots: The robots that may take missions of their groups, by name.
    """
    on = {mission.its_robot: key for key, mission in missions.items() if mission.active}
    waits: dict[str, WaitsFor] = {}
    for key, mission in in_turn(missions):
        robot = mission.robot
        if mission.status is MissionStatus.HELD:
            waits[key] = WaitsFor.CONTINUE
        elif robot is None:
            found = _choose(mission, {name: each for name, each in robots.items() if name not in on}, robots)
            if isinstance(found, WaitsFor):
                waits[key] = found
            else:
                on[found] = key
        elif robot in on:
            waits[key] = WaitsFor.TURN
        else:
            on[robot] = key
    return Turns(on, waits)


def _choose(mission: MissionEntry, idle: Mapping[str, RobotFacts], robots: Mapping[str, RobotFacts]) -> str | WaitsFor:
    """Return the robot that takes a mission of a group, the one with the most charge; else what the mission waits for.

    A robot that was stopped takes none that somebody has let begin before: a released stop starts no robot.

    Args:
        mission: The mission.
        idle: The robots that are on no mission.
        robots: All robots.
    """
    free = {name: each for name, each in idle.items() if mission.group in each.groups and each.free}
    able = [name for name, each in free.items() if each.stopped_at is None or each.stopped_at < mission.allowed_since]
    if able:
        return min(able, key=lambda name: (-free[name].charge, name))
    if free:
        return WaitsFor.CONTINUE
    return WaitsFor.ROBOT if any(mission.group in each.groups for each in robots.values()) else WaitsFor.GROUP


def require_turn(missions: Missions, mission_id: str, robot: str) -> None:
    """Refuse to begin a mission on a robot that is on another one, or has one that comes first.

    Args:
        missions: All that are stored.
        mission_id: That which is to begin.
        robot: Where.

    Raises:
        Conflict: It is not its turn.
    """
    if any(each.active and each.robot == robot for key, each in missions.items() if key != mission_id):
        raise Conflict(f"{robot} has another mission")
    own = (item for item in in_turn(missions) if item[0] == mission_id or item[1].robot == robot)
    first = next((key for key, each in own if each.status is MissionStatus.QUEUED), mission_id)
    if first != mission_id:
        raise Conflict(f"another mission of {robot} comes first")


# ---------------------------------------------------------------------- the order


def last_order(missions: Missions) -> int:
    """Return the highest number of the missions that have not begun; 0 if there are none."""
    return max((mission.order for mission in missions.values() if mission.in_queue), default=0)


def next_order(last: int, now: datetime) -> int:
    """Return the number of a new mission: behind all others, whatever the clocks of gateways say."""
    return max(int(now.timestamp() * 1e6), last + SPACING)


def find_queued(missions: Missions, mission_id: str) -> MissionEntry:
    """Return a mission that has not begun.

    Raises:
        Conflict: It has begun (`mission_begun`).
        NotFound: It has ended, or there is none (`mission_not_found`).
    """
    mission = missions.get(mission_id)
    if mission is None or mission.status.ended:
        raise NotFound(f"there is no mission {mission_id} that has not ended", code="mission_not_found")
    require_in_queue(mission_id, mission)
    return mission


def require_in_queue(mission_id: str, mission: MissionEntry) -> None:
    """Refuse a mission that has begun.

    Raises:
        Conflict: It has (`mission_begun`).
    """
    if not mission.in_queue:
        raise Conflict(f"the mission {mission_id} has begun", code="mission_begun")


def _compete(one: MissionEntry, other: MissionEntry, members: Members) -> bool:
    """Return whether there may be a robot that takes both."""
    if one.robot is None and other.robot is None and one.group == other.group:
        return True
    first, second = ({each.robot} if each.robot else {*members(each.group or "")} for each in (one, other))
    return not first.isdisjoint(second)


def place(
    missions: Missions, mission_id: str, other_id: str, members: Members, *, before: bool
) -> list[tuple[str, MissionEntry]]:
    """Return the changes that put a mission right before or behind another one, whose priority it gets.

    The last change is that of the mission; none: it is there already. Those before it make room: they keep the order of
    all others, also if only some of them are made.

    Args:
        missions: The missions that have not ended.
        mission_id: That which is moved.
        other_id: The other one.
        members: Returns the robots of a group.
        before: Whether it goes before the other one.

    Raises:
        Conflict: One of the two has begun (`mission_begun`), or they are in different queues (`other_queue`).
        NotFound: One of them has ended, or is not there (`mission_not_found`).
    """
    moved, other = find_queued(missions, mission_id), find_queued(missions, other_id)
    if not _compete(moved, other, members):
        raise Conflict(f"the missions {mission_id} and {other_id} are in different queues", code="other_queue")
    line = [item for item in in_turn(missions) if item[1].priority == other.priority]
    keys = [key for key, _ in line]
    at = keys.index(other_id) + (0 if before else 1)
    if mission_id == other_id or mission_id in keys[max(at - 1, 0) : at + 1]:
        return []
    ahead = [item for item in line[:at] if item[0] != mission_id]
    behind = [item for item in line[at:] if item[0] != mission_id]
    low = ahead[-1][1].order if ahead else None
    high = behind[0][1].order if behind else None
    changes: list[tuple[str, MissionEntry]] = []
    if low is None:
        order = (high or 0) - SPACING
    elif high is None:
        order = low + SPACING
    elif high - low > 1:
        order = (low + high) // 2
    else:
        order = low + SPACING
        changes = _make_room(behind, order + SPACING)
    edition = moved.edition + (moved.priority != other.priority)
    return [*changes, (mission_id, moved.but(order=order, priority=other.priority, edition=edition))]


def _make_room(behind: list[tuple[str, MissionEntry]], order: int) -> list[tuple[str, MissionEntry]]:
    """Return the changes after which no mission of a line has a lower number, the last of the line first."""
    changes = []
    for key, mission in behind:
        if mission.order >= order:
            break
        changes.append((key, mission.but(order=order)))
        order += SPACING
    return changes[::-1]
