"""What must hold for missions for any robot of a group."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import sqlalchemy as sa

from dock_gateway.extensions.missions.mission import MissionEntry
from tests.extensions.missions.simulation.stored import find_missions, robot_of

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.robot import Robot
    from tests.extensions.missions.simulation.world import World

# Charge below which a robot takes no mission of a group: the default of `low_battery`.
LOW = 0.2
# Differences of charge that do not count: a choice is stored a little later than it is made.
SAME_CHARGE = 0.02
# Seconds for which a robot must have been free until all gateways know that, and after which others have been given
# the missions that are theirs.
KNOWN_AFTER = 45.0
SETTLED_AFTER = 15.0


@dataclass(frozen=True)
class Choice:
    """A robot that has taken a mission of a group.

    Attributes:
        at: When.
        mission_id, robot: Which.
        better: The robots that were free then, and had more charge.
    """

    at: float
    mission_id: str
    robot: str
    better: tuple[str, ...]


class GroupChecks:
    """Follows the missions of groups. Each of them goes to one robot, once: to the free one with the most charge.

    *Free* is judged by the robots, not by what gateways say: one that for 45 s was on no mission and had no
    goal, was heard, was not stopped or released, and has at least the charge of `low_battery`. It has *more charge* if
    that is 0.02 more. A robot that gets a mission of its own right then was not free after all.

    Args:
        world: The run.
    """

    def __init__(self, world: "World") -> None:
        self._world = world
        self._waiting: dict[str, str] = {}  # the groups of missions that no robot has
        self._taken: dict[str, str] = {}  # the robots of the others
        self._used: dict[str, str] = {}  # the robots that have carried out steps of them
        self._free_since: dict[str, float] = {}
        self._disturbed: dict[str, float] = {}
        self._choices: list[Choice] = []

    def queued(self, mission_id: str, group: str) -> None:
        """Somebody queues a mission for a group."""
        self._waiting[mission_id] = group

    def disturbed(self, robots: list[str]) -> None:
        """Note that robots are being stopped, or released."""
        self._disturbed |= dict.fromkeys(robots, self._world.time)

    # ------------------------------------------------------------------ who takes a mission

    def on_write(self, connection: sa.Connection) -> None:
        """Look, in the transaction in which something is stored, whether a robot takes a mission."""
        if not self._waiting:
            return
        missions = find_missions(connection, self._waiting)
        for mission_id, mission in missions.items():
            if mission.robot is not None:
                self._note_choice(mission_id, mission.robot, self._waiting.pop(mission_id))

    def _note_choice(self, mission_id: str, name: str, group: str) -> None:
        world = self._world
        robot, members = world.robots[name], world.groups[group]
        world.checks.counts["taken"] += 1
        self._taken[mission_id] = name
        if name not in members:
            world.fault(f"{mission_id} for {group} goes to {name}, which is not in it")
        if robot.charge < LOW - SAME_CHARGE:
            world.fault(f"{mission_id} goes to {name}, whose charge is {robot.charge:.2f}")
        if any(self._is_known(robot, goal.at) for goal in robot.running()):
            world.fault(f"{mission_id} goes to {name}, on which a goal runs")
        better = (other for other in members if world.robots[other].charge > robot.charge + SAME_CHARGE)
        found = tuple(other for other in better if self.is_free(world.robots[other], KNOWN_AFTER))
        world.checks.counts["taken while several were free"] += any(
            self.is_free(world.robots[other], KNOWN_AFTER) for other in members if other != name
        )
        if found:
            self._choices.append(Choice(self._world.time, mission_id, name, found))

    def _is_known(self, robot: "Robot", at: float) -> bool:
        """Return whether gateways have had the time to learn of something that has happened to a robot."""
        return self._world.is_calm(robot.name, at, KNOWN_AFTER)

    def is_free(self, robot: "Robot", seconds: float) -> bool:
        """Return whether a robot has been free for so long, and is."""
        calm = max(
            self._free_since.get(robot.name, self._world.time),
            self._world.calm_since[robot.name],
            self._disturbed.get(robot.name, -1.0),
            self._world.gateways_since,
        )
        return robot.there and not robot.running() and robot.charge > LOW and self._world.time - calm > seconds

    def look(self, active: set[str]) -> None:
        """Look at the robots; `active` are those that are on a mission."""
        for name, robot in self._world.robots.items():
            if name in active or robot.running() or robot.charge <= LOW:
                self._free_since[name] = self._world.time
            self._free_since.setdefault(name, self._world.time)
        for choice in [each for each in self._choices if self._world.time - each.at > SETTLED_AFTER]:
            self._choices.remove(choice)
            left = [name for name in choice.better if self._free_since[name] < choice.at]
            if left and self._world.gateways_since < choice.at:
                charges = {name: round(self._world.robots[name].charge, 2) for name in (choice.robot, *left)}
                self._world.fault(f"{choice.mission_id} went to {choice.robot}: {charges}")

    # ------------------------------------------------------------------ who carries it out

    def carried_out(self, mission_id: str, robot: str) -> None:
        """A robot accepts a goal of a step."""
        if self._used.setdefault(mission_id, robot) != robot:
            self._world.fault(f"{mission_id} is carried out by {robot}, and by {self._used[mission_id]}")
        if self._taken.get(mission_id, robot) != robot:
            self._world.fault(f"{mission_id} is carried out by {robot}, and {self._taken[mission_id]} has it")

    def look_at(self, mission_id: str, mission: MissionEntry) -> None:
        """Check that a mission stays with its robot."""
        robot = self._taken.get(mission_id)
        if robot is not None and robot_of(mission) != robot:
            self._world.fault(f"{mission_id} was {robot}'s, and is {mission.robot}'s")

    def may_wait(self, mission: MissionEntry, seconds: float) -> bool:
        """Return whether no robot has been free for so long that may take a mission."""
        since = mission.allowed_since.timestamp() - self._world.now().timestamp() + self._world.time
        members = [self._world.robots[name] for name in self._world.groups[mission.group or ""]]
        unstopped = [each for each in members if self._disturbed.get(each.name, -1.0) < since]
        return not any(self.is_free(each, seconds) for each in unstopped)
