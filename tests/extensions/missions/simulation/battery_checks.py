"""What must hold for the batteries of robots."""

from collections import defaultdict
from collections.abc import Mapping
from typing import TYPE_CHECKING

from dock_gateway.core.goal import GoalStatus
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus, RechargeStage
from dock_gateway.extensions.missions.step_entry import StepEntry
from tests.extensions.missions.simulation.drive_checks import wants_dock
from tests.extensions.missions.simulation.stored import dock_records

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.robot import Robot
    from tests.extensions.missions.simulation.world import World

# The charge below which no robot may fall, and the seconds within which one returns that can.
EMPTY, RETURNS_WITHIN = 0.05, 180.0
# Seconds after which gateways have noticed that something works again, or that a dock is free.
NOTICED_AFTER, FREE_AFTER = 90.0, 300.0


class BatteryChecks:
    """Follows the batteries. No robot falls below 5 % that could have returned to a charger for three minutes.

    Those are counted from when its charge fell below `below` of its mission, in the time in which

    - the mission is on its way: not held, also for a stop, not being canceled or paused, and nobody has skipped its
      return;
    - the robot was heard for 90 s, also its servers, and at least one gateway ran, with none killed or started;
    - no goal runs on it, but that of a step with `interruptible`, nor is one lost; no call waits for its answer;
    - it does not charge already, nor waits after a docking that has failed;
    - a charger is free: neither blocked nor out of order, no other robot stands there or drives there, and there are
      more of them than other robots that wait for one. (All docks fit all robots.)

    A robot on no mission, or on one without `battery`, is left alone.

    Args:
        world: The run.
    """

    def __init__(self, world: "World") -> None:
        self._world = world
        self._looked_at = 0.0
        self._could: defaultdict[str, float] = defaultdict(float)  # for how many seconds each robot could have returned
        self._can: set[str] = set()  # the robots that could when they were last looked at
        self._empty: set[str] = set()
        self._held_since: dict[str, tuple[str, float]] = {}  # the docks that are held for a robot that is not there

    def look(self, missions: Mapping[str, MissionEntry]) -> None:
        """Look at all robots; `missions` are those that have not ended."""
        now = self._world.time
        passed, self._looked_at = now - self._looked_at, now
        on = {mission.its_robot: (key, mission) for key, mission in missions.items() if mission.active}
        self._note_held_docks()
        can: set[str] = set()
        for name, robot in self._world.robots.items():
            mission_id, mission = on.get(name, ("", None))
            if mission is None or not _is_low(robot, mission):
                self._could[name] = 0.0
            elif self.hindrance(robot, mission, missions) is None:
                can.add(name)
                self._could[name] += passed if name in self._can else 0.0
            self._look_at(robot, mission_id, mission)
        self._can = can

    def _look_at(self, robot: "Robot", mission_id: str, mission: MissionEntry | None) -> None:
        could = self._could[robot.name]
        if robot.charge >= EMPTY:
            self._empty.discard(robot.name)
        elif robot.name not in self._empty:
            self._empty.add(robot.name)
            self._world.checks.counts["empty"] += 1
        if could <= RETURNS_WITHIN or mission is None:
            return
        said = [gateway.missions.book.waits.get(mission_id) for gateway in self._world.gateways if gateway.ready]
        self._world.fault(
            f"{robot.name} has {robot.charge:.3f} of its charge, and could have returned for {could:.0f} s: "
            f"{mission_id} {mission.limits}, {said}, {mission.current!r:.500}"
        )
        self._could[robot.name] = 0.0

    # ------------------------------------------------------------------ what keeps a robot

    def hindrance(self, robot: "Robot", mission: MissionEntry, missions: Mapping[str, MissionEntry]) -> str | None:
        """Return what keeps a robot from its return to charge; None: nothing."""
        world, step, now = self._world, mission.current, self._world.time
        calm = world.disturbed_at(robot.name)
        goals, on_break = robot.running(), mission.recharge
        reasons = {
            "a person": mission.status is not MissionStatus.RUNNING or mission.pausing or mission.recharge_skipped,
            "faults": now - calm < NOTICED_AFTER,
            "it charges": robot.dock is not None or (on_break and on_break.stage is RechargeStage.UNDOCKING),
            "a goal": any(goal.goal_id != step.goal_id or not step.interruptible for goal in goals),
            "a lost goal, a call, or a gateway": self._waits_for_others(step, {goal.goal_id for goal in goals}),
            "a docking that has failed": on_break and step.retry_at is not None and step.retry_at > world.now(),
        }
        found = next((reason for reason, is_it in reasons.items() if is_it), None)
        others = sum(wants_dock(each) for each in missions.values() if each.robot != robot.name)
        return found or (None if len(self.free_docks(robot)) > others else "the docks")

    def _waits_for_others(self, step: StepEntry, running: set[str]) -> bool:
        if step.has_goal and step.goal_id is None:
            return step.sends_until is not None and step.sends_until > self._world.now()
        return step.has_message or (step.has_goal and step.goal_id not in running and not step.interruptible)

    def free_docks(self, robot: "Robot") -> list[str]:
        """Return the docks that a robot could have."""
        docks, now = self._world.docks, self._world.time
        taken = {*docks.robots, *docks.blocked}
        for other in self._world.robots.values():
            runs = (goal for goal in other.servers["dock"].goals.values() if goal.runs and other is not robot)
            taken |= {other.dock_of(goal.message) for goal in runs}
        for dock, record in dock_records(self._world.disk).items():
            since = self._held_since.get(dock, (robot.name, now))[1]
            held = record["hold"] is not None and record["hold"]["robot"] != robot.name and now - since < FREE_AFTER
            taken |= {dock} if held or record["out_of_order_at"] is not None else set()
        return [dock for dock in docks.names if dock not in taken]

    def _note_held_docks(self) -> None:
        """Note since when docks are held for robots that neither stand there nor drive there, and are heard."""
        now, held = self._world.time, {}
        for dock, record in dock_records(self._world.disk).items():
            name = record["hold"] and record["hold"]["robot"]
            if name is None:
                continue
            robot, before = self._world.robots[name], self._held_since.get(dock, ("", now))
            at = self._world.docks.robots.get(dock) == name
            lost = any(goal.status is GoalStatus.LOST for goal in self._world.goals_on(name))
            drives = any(goal.runs for goal in robot.servers["dock"].goals.values())
            calm = self._world.disturbed_at(name)
            left_alone = at or lost or drives or now - calm < NOTICED_AFTER or before[0] != name
            held[dock] = (name, now if left_alone else before[1])
        self._held_since = held


def _is_low(robot: "Robot", mission: MissionEntry) -> bool:
    return mission.limits is not None and robot.charge < mission.limits.below
