"""What must hold in a run, seen from the robots: what they were really sent, and what people asked for.

A gateway's own words, which are the stored missions, are compared with that.
"""

from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from dock_gateway.core.goal import GoalStatus
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.step_entry import StepStatus
from tests.extensions.missions.simulation.battery_checks import BatteryChecks
from tests.extensions.missions.simulation.drive_checks import DriveChecks
from tests.extensions.missions.simulation.group_checks import GroupChecks
from tests.extensions.missions.simulation.rule_checks import BY_RULE, RuleChecks
from tests.extensions.missions.simulation.stored import key_of, named, robot_of, stored_missions, tag_of
from tests.extensions.missions.simulation.wait_checks import WaitChecks

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.gateway import Gateway
    from tests.extensions.missions.simulation.robot import Robot
    from tests.extensions.missions.simulation.server import CarriedOut, Server
    from tests.extensions.missions.simulation.world import World

# Seconds after which a gateway has given up a goal that its server, which was frozen, accepts at last.
GIVEN_UP_AFTER = 5.0
# Seconds after a stop in which another gateway may not have heard of it, and after which no goal of a mission runs.
HEARD_AFTER, STANDS_AFTER = 1.0, 60.0
# Seconds for which a gateway may be sending a goal, and after which those that were not disturbed know what runs.
SENDS_WITHIN, KNOWN_AFTER = 5.0, 15.0
# Looks during which a mission may have been queued unnoticed by the gateway that begins another one.
NOTICED_AFTER = 6


@dataclass(frozen=True)
class Place:
    """A step that a robot carries out: its mission, its index, and whether it is inside of a `repeat`."""

    mission_id: str
    index: int
    repeated: bool


def _turn(mission: MissionEntry) -> tuple[int, int]:
    """Return what the queue of a robot is sorted by: of two that were queued at once, the first that was stored."""
    return -mission.priority, mission.order


class Checks:
    """Follows a run, and notes what is wrong in it.

    Args:
        world: The run.

    Attributes:
        found: What is wrong.
        added: The missions that people have queued, as they were queued.
        ended: Those that have ended, as they were stored.
        counts: How often things have happened.
        sent_at: When each goal was sent last.
        groups: Follows missions for any robot of a group.
        rules: Follows robots that a rule docks.
    """

    def __init__(self, world: "World") -> None:
        self._world = world
        self.found: list[str] = []
        self.added: dict[str, MissionEntry] = {}
        self.ended: dict[str, MissionEntry] = {}
        self.counts: Counter[str] = Counter()
        self.sent_at: dict[str, float] = {}
        self.groups = GroupChecks(world)
        self._batteries = BatteryChecks(world)
        self._drives = DriveChecks(world, self._batteries)
        self.rules = RuleChecks(world, self._batteries)
        self._waits = WaitChecks(world)
        self._places: dict[str, Place] = {}
        self._goals: defaultdict[str, list[CarriedOut]] = defaultdict(list)  # by tag
        self._carried: defaultdict[str, list[CarriedOut]] = defaultdict(list)  # the same, with those accepted too late
        self._keys: dict[str, CarriedOut] = {}  # the goal that was accepted for each key
        self._calls: Counter[tuple[str, int]] = Counter()
        self._last: dict[str, int] = {}  # the index of the last step of each mission that was begun at the robot
        self._allowed: dict[str, float] = {}  # when somebody last let a robot move, or a mission begin
        self._stops: dict[str, tuple[float, float]] = {}  # when the last stop of a robot began and had ended
        self._own: dict[str, str] = {}  # the goals of missions, with what they are for
        self._parted: set[str] = set()  # goals that a gateway may have lost sight of
        self._paused: set[str] = set()  # missions that somebody has paused before they had begun

    def fault(self, what: str) -> None:
        """Note that something is wrong."""
        self._world.chance.say("CHECK", what)
        self.found.append(what)

    # ------------------------------------------------------------------ what people do

    def queued(self, mission_id: str, mission: MissionEntry, group: str | None) -> None:
        """Somebody queues a mission; `group` is that whose robots may take it."""
        self.added[mission_id] = mission
        if group is not None:
            self.groups.queued(mission_id, group)
        around = [range(at + 1, at + 1 + step.size) for at, step in enumerate(mission.steps) if step.repeat is not None]
        for index, step in enumerate(mission.steps):
            if (tag := tag_of(step)) is not None:
                self._places[tag] = Place(mission_id, index, any(index in inside for inside in around))

    def allowed(self, mission_id: str, robot: str) -> None:
        """Somebody lets a mission go on, or changes what its robot is to do."""
        self._allowed[mission_id] = self._allowed[robot] = self._world.time

    def paused(self, mission_id: str) -> None:
        """Somebody has paused a mission."""
        self._paused.add(mission_id)

    def stopped(self, robots: list[str], began: float) -> None:
        """A stop was confirmed."""
        self.counts["stops"] += 1
        for robot in robots:
            self._stops[robot] = (began, self._world.time)

    # ------------------------------------------------------------------ what robots are sent

    def sent(self, gateway: "Gateway", robot: str, message: Mapping[str, Any]) -> None:
        """A gateway sends a goal, or calls a service."""
        tag = message.get("tag")
        if tag is None:
            return
        began, ended = self._stops.get(robot, (-1.0, -1.0))
        heard = ended + (HEARD_AFTER if self._world.troubles.gateways > 1 else 0.0)
        stopped = began >= 0 and heard < self._world.time and self._allowed.get(robot, -1.0) < began
        if stopped and not self._is_queued_since(robot, tag, began):
            self.fault(f"{gateway.name} sends {tag} to {robot}, which was stopped at {began:.3f}, and nobody continued")

    def _is_queued_since(self, robot: str, tag: str, at: float) -> bool:
        """Return whether somebody, or a schedule, has queued the mission of a step after a time."""
        place, stored = self._places.get(tag), {**self.ended, **self.stored()}
        if place is not None:
            mission = stored.get(place.mission_id)
        else:  # all missions of a schedule have the same tags
            own = (each for each in stored.values() if each.schedule is not None and robot_of(each) == robot)
            mission = next((each for each in own if each.active), None)
        if place is not None and self._allowed.get(place.mission_id, -1.0) > at:
            return True
        return mission is not None and self._world.time_of(mission.created_at) > at

    def called(self, gateway: "Gateway", robot: str, message: Mapping[str, Any]) -> None:
        """A service of a robot is called."""
        self.sent(gateway, robot, message)
        tag = message["tag"]
        place, mission = self._places[tag], self.stored().get(self._places[tag].mission_id)
        if mission is None or mission.step != place.index:
            self.fault(f"{tag} is called, and its mission is not at that step")
            return
        attempt = mission.current.attempt
        self._calls[tag, attempt] += 1
        if self._calls[tag, attempt] > 1:
            self.fault(f"try {attempt} of {tag} is called twice")
        self._in_order(place, tag)

    def accepted(self, robot: "Robot", server: "Server", goal: "CarriedOut") -> None:
        """A robot has accepted a goal."""
        self.counts["goals"] += 1
        if server.kind == "dock" and self._world.shares_docks:
            self._check_dock(robot, robot.dock_of(goal.message))
        if goal.tag is None:
            self._check_untagged(robot, server, goal)
            return
        self._carried[goal.tag].append(goal)
        if self._world.time - self.sent_at[goal.goal_id] > GIVEN_UP_AFTER:  # it is canceled at once
            self._parted.add(goal.goal_id)
            return
        self.counts["steps"] += 1
        key = key_of(self._world.disk, goal.goal_id)
        if key is None:
            if not self._world.is_spooled(goal.goal_id):
                self.fault(f"{goal.goal_id} of {goal.tag} has no key")
            return
        self._note_key(key, goal)
        _, mission_id, index, _ = key.split("-")
        tag = named(goal.tag, mission_id)
        place = self._places.setdefault(tag, Place(mission_id, int(index), repeated=False))
        self.groups.carried_out(mission_id, robot.name)
        self._check_alone(robot, goal, tag)
        self._check_step(place, tag, [*self._goals[tag], goal])
        self._goals[tag].append(goal)
        self._in_order(place, tag)

    def _note_key(self, key: str, goal: "CarriedOut") -> None:
        """Check that no other goal was accepted for a key.

        The same one may be accepted again by a server that was started again meanwhile, if its gateway was killed
        before it heard that it was accepted: nobody knows that then.
        """
        known = self._keys.get(key)
        unheard = known is not None and known.at < self._world.gateways_since
        if known is not None and not (known.goal_id == goal.goal_id and unheard):
            self.fault(f"the try {key} is carried out twice, as {known.goal_id} and {goal.goal_id}")
        self._keys[key] = goal

    def _check_untagged(self, robot: "Robot", server: "Server", goal: "CarriedOut") -> None:
        """Check a goal that is of no step.

        It may be of a rule, of the break of a mission for the battery, or of a drive to where the robot waits for its
        dock.
        """
        key = key_of(self._world.disk, goal.goal_id)
        if key is None:
            self.rules.sent_by_person(robot, goal)
        if key is None or self._world.time - self.sent_at[goal.goal_id] > GIVEN_UP_AFTER:
            return
        self._note_key(key, goal)
        if key.startswith(BY_RULE):
            self._check_alone(robot, goal, key)
            self.rules.docks(robot, goal, key, self._stops.get(robot.name, (-1.0, -1.0)))
            return
        _, mission_id, kind, number, attempt = key.split("-")
        self.groups.carried_out(mission_id, robot.name)
        mission = self.stored().get(mission_id)
        self._check_alone(robot, goal, key)
        if mission is None or self._is_late(mission):
            return
        self._check_stop(robot, mission_id, mission)
        if kind == "drive":
            self._drives.begins(robot, key, mission_id, mission)
        else:
            self._check_break(server, key, mission_id, mission, (int(number), int(attempt)))

    def _check_break(
        self, server: "Server", key: str, mission_id: str, mission: MissionEntry, at: tuple[int, int]
    ) -> None:
        """Check a goal of the break of a mission for the battery; `at` is the number of the break and of the try."""
        self.counts[f"{server.kind}s for the battery"] += 1
        its_break = mission.recharge
        if its_break is None or (its_break.number, its_break.step.attempt) != at:
            self.fault(f"{key} is carried out, and {mission_id} is at {its_break!r:.300}")
        elif its_break.step.verb != server.kind:
            self.fault(f"{key} is a goal to {server.kind}, and {mission_id} is at {its_break.stage}")

    def _check_alone(self, robot: "Robot", goal: "CarriedOut", key: str) -> None:
        """Check that a robot that begins a goal of a mission or a rule has no other one."""
        sent, calm = self.sent_at[goal.goal_id], self._world.disturbed_at(robot.name)
        for other in robot.running():
            known = max(other.at + SENDS_WITHIN, calm + KNOWN_AFTER) < sent
            if known and other.goal_id not in {goal.goal_id, *self._own}:
                self.fault(f"{robot.name} begins {key} while somebody's {other.goal_id} runs")
            if other is not goal and other.goal_id in self._own and other.goal_id not in self._parted:
                self.fault(f"{robot.name} begins {key} while {self._own[other.goal_id]} ({other.goal_id}) runs")
        self._own[goal.goal_id] = key

    def _check_stop(self, robot: "Robot", mission_id: str, mission: MissionEntry) -> None:
        """Check that somebody let a robot move for a mission, if it was stopped before."""
        at = self.stopped_at(robot.name, mission_id, mission)
        if at is not None and at < self._world.time - GIVEN_UP_AFTER:
            self.fault(f"{robot.name} moves for {mission_id}, was stopped at {at:.3f}, and nobody continued")

    def stopped_at(self, robot: str, mission_id: str, mission: MissionEntry) -> float | None:
        """Return when a robot was stopped, if nobody has let a mission go on since; else None."""
        began, ended = self._stops.get(robot, (-1.0, -1.0))
        allowed = max(self._allowed.get(robot, -1.0), self._allowed.get(mission_id, -1.0))
        created = self._world.time_of(mission.created_at)
        return ended if began >= 0 and max(allowed, created) < began else None

    def _check_dock(self, robot: "Robot", dock: str) -> None:
        """Check that no other robot stands at a dock that a robot drives to, or drives there."""
        self.counts["dockings"] += 1
        standing = self._world.docks.robots.get(dock, robot.name)
        if standing != robot.name:
            self.fault(f"{robot.name} drives to {dock}, where {standing} stands")
        for other in self._world.robots.values():
            for goal in other.servers["dock"].goals.values():
                if other is not robot and goal.runs and other.dock_of(goal.message) == dock:
                    self.fault(f"{robot.name} drives to {dock}, and so does {other.name}")

    def _check_step(self, place: Place, tag: str, goals: list["CarriedOut"]) -> None:
        """Compare the goals of a step, the last of which begins now, with its mission."""
        mission = self.stored().get(place.mission_id)
        if mission is None or mission.step != place.index:
            at = "ended" if mission is None else f"at step {mission.step}"
            if not self._is_late(mission):
                self.fault(f"{tag}, step {place.index}, is carried out, and its mission is {at}")
            return
        different = len({each.goal_id for each in goals})
        if different > mission.current.attempt:
            self.fault(f"{tag} is carried out {different} times in {mission.current.attempt} tries")
        allowed = self._allowed.get(robot_of(mission), -1.0)
        done = [each for each in goals if each.status is GoalStatus.SUCCEEDED and allowed < (each.ended_at or 0.0)]
        if done and not place.repeated:
            self.fault(f"{tag} has succeeded, and is carried out again")

    @staticmethod
    def _is_late(mission: MissionEntry | None) -> bool:
        """Return whether a goal may have been on its way when its mission was changed: it is canceled then."""
        return mission is None or mission.status in (MissionStatus.CANCELING, MissionStatus.HELD)

    def _in_order(self, place: Place, tag: str) -> None:
        if not place.repeated and place.index < self._last.get(place.mission_id, 0):
            self.fault(f"{tag} is carried out after a later step")
        self._last[place.mission_id] = place.index

    def lost_sight(self, robot: "Robot") -> None:
        """Gateways no longer see what a robot does."""
        self._parted |= {goal.goal_id for goal in robot.running()}

    # ------------------------------------------------------------------ what is stored

    def stored(self, kind: str = "mission") -> dict[str, MissionEntry]:
        """Return the missions in the database."""
        return stored_missions(self._world.disk, kind)

    def look_at_robots(self) -> None:
        """Look at the batteries, and at the robots that are free."""
        missions = self.stored()
        self._batteries.look(missions)
        self._drives.look(missions)
        self.rules.look(missions, self._stops)
        for name, (began, ended) in self._stops.items():
            if self._allowed.get(name, -1.0) < began and self._world.is_calm(name, ended, STANDS_AFTER):
                self._check_stands(self._world.robots[name], ended)
        self.groups.look({mission.its_robot for mission in missions.values() if mission.active})

    def _check_stands(self, robot: "Robot", stopped: float) -> None:
        """Check that no goal of a mission runs that a robot had when it was stopped, also if it came right then."""
        for goal in robot.running():
            if goal.goal_id in self._own and goal.at < stopped + HEARD_AFTER:
                self.fault(f"{robot.name} was stopped at {stopped:.3f}, and {self._own[goal.goal_id]} runs")

    def look(self) -> None:
        """Look at all missions, as often as it pleases."""
        missions, ended = self.stored(), self.stored("ended_mission")
        self._count_scheduled({**missions, **ended})
        for mission_id, mission in ended.items():
            if mission_id not in self.ended:
                self.ended[mission_id] = mission
                self.groups.look_at(mission_id, mission)
                self._check_end(mission_id, mission)
        active = Counter(robot_of(mission) for mission in missions.values() if mission.active)
        for robot, count in active.items():
            if count > 1:
                self.fault(f"{robot} is on {count} missions")
        self._waits.look_at_robots(active)
        for mission_id, mission in missions.items():
            self.groups.look_at(mission_id, mission)
            if mission_id in self.ended and not mission.status.ended:
                self.fault(f"{mission_id} had ended, and is {mission.status.value} again")
            self._waits.look_at(mission_id, mission)

    def _count_scheduled(self, missions: Mapping[str, MissionEntry]) -> None:
        """Note which missions schedules have queued."""
        for mission_id, mission in missions.items():
            if mission.schedule is not None and mission_id not in self.added:
                self.added[mission_id] = mission
                self.counts["scheduled"] += 1

    def _check_end(self, mission_id: str, mission: MissionEntry) -> None:
        """Compare a mission that has ended with what its robot has done."""
        self.counts[mission.status.value] += 1
        for index, step in enumerate(mission.steps):
            tag = tag_of(step)
            if tag is not None and step.call is None and step.status is StepStatus.SUCCEEDED:
                done = any(goal.status is GoalStatus.SUCCEEDED for goal in self._carried[tag])
                if not done:
                    self.fault(f"{mission_id}: step {index} is said to have succeeded, and no robot has done it")
            left = step.status in (StepStatus.WAITING, StepStatus.RUNNING)
            if left and mission.status is MissionStatus.SUCCEEDED:
                self.fault(f"{mission_id} has succeeded without step {index}, which is {step.status.value}")
            if step.status is StepStatus.RUNNING and mission.status is not MissionStatus.SUCCEEDED:
                self.fault(f"{mission_id} has ended, and step {index} runs")
            failed = step.status is StepStatus.FAILED and step.on_failure == "end" and not step.size
            inside = "." in step.path
            if failed and not inside and mission.status is MissionStatus.SUCCEEDED:
                self.fault(f"{mission_id} has succeeded, though step {index} has failed")

    def check_all(self) -> None:
        """Check at the end of the run that each mission has ended, and that they began in their order."""
        self.look()
        left = self.stored()
        for mission_id in self.added:
            if mission_id not in self.ended:
                state = left.get(mission_id)
                what = "gone" if state is None else f"{state.status.value}, {state.held_for}, {state.current!r:.300}"
                self.fault(f"{mission_id} was forgotten: it is {what}")
        self._check_turns()

    def _check_turns(self) -> None:
        of_robots: defaultdict[str, list[tuple[str, MissionEntry]]] = defaultdict(list)
        for mission_id, mission in self.ended.items():
            of_robots[robot_of(mission)].append((mission_id, mission))
        for missions in of_robots.values():
            for mission_id, first in missions:
                if mission_id in self._paused or first.schedule is not None or first.group is not None:
                    continue  # those of schedules and groups wait for somebody after a stop
                for other_id, other in missions:
                    if other.started_at is None or _turn(other) <= _turn(first):
                        continue
                    waited = (other.started_at - first.created_at).total_seconds()
                    began_later = first.started_at is None or first.started_at > other.started_at
                    was_there = first.finished_at is None or first.finished_at > other.started_at
                    if waited > NOTICED_AFTER * self._world.troubles.look_every and began_later and was_there:
                        self.fault(f"{other_id} began before {mission_id}, whose turn it was")
