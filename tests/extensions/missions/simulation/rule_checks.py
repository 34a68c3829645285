"""What must hold for robots that a rule docks when their battery is low."""

from collections import defaultdict
from collections.abc import Mapping
from datetime import datetime, timedelta
from typing import TYPE_CHECKING

from dock_gateway.core.goal import GoalStatus
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.fleet.fleet import Fleet
from tests.extensions.missions.simulation.drive_checks import wants_dock
from tests.extensions.missions.simulation.duration import Duration
from tests.extensions.missions.simulation.stored import decisions_of_rules, dock_waits

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.battery_checks import BatteryChecks
    from tests.extensions.missions.simulation.robot import Robot
    from tests.extensions.missions.simulation.server import CarriedOut
    from tests.extensions.missions.simulation.world import World

# What the key of a rule's goal begins with.
BY_RULE = "automatic-docking-"
# The rule: a robot with less charge that has stood idle for so many seconds is docked.
BELOW, IDLE = 0.3, 60.0
# The charge below which a rule asks a mission to let its robot charge.
ASKS_BELOW = 0.2
# Seconds between two attempts, and after a docking that has failed.
RETRY_AFTER = 300.0
# Seconds after which gateways have noticed what has changed; within which one docks a robot that it can dock; and
# within which it asks a mission.
NOTICED_AFTER, DOCKS_WITHIN, ASKS_WITHIN = 90.0, 180.0, 60.0


class RuleChecks:
    """Follows the robots that a rule docks.

    - It docks only them, below its limit, once in five minutes.
    - It docks no robot that is on a mission that is not held, has another goal, or stands on a dock.
    - After a stop it docks none until somebody continues that, or a goal that somebody has sent since has succeeded.
    - It docks a robot with a low battery that stands idle, if a dock is free and nobody comes before.
    - It asks a mission without `battery` to let its robot charge.

    Args:
        world: The run.
        batteries: Knows which docks are free.
    """

    def __init__(self, world: "World", batteries: "BatteryChecks") -> None:
        self._world = world
        self._batteries = batteries
        self._docked: dict[str, tuple[str, float]] = {}  # the last goal of a rule for each robot, and when it came
        self._continued: dict[str, float] = {}  # when somebody last continued the rule for a robot
        self._released: dict[str, float] = {}  # when somebody last released a stop of each robot
        self._person_goals: dict[str, list[CarriedOut]] = defaultdict(list)
        self._able = Duration(IDLE + DOCKS_WITHIN)  # robots that could have been docked
        self._unasked = Duration(ASKS_WITHIN)  # robots whose missions could have been asked
        self._looked_at = 0.0

    # ------------------------------------------------------------------ people

    def continued(self, robot: str, at: float) -> None:
        """Somebody lets the rule go on with a robot, or tries to, from a time on."""
        self._continued[robot] = at

    def released(self, robots: list[str]) -> None:
        """Somebody has released a stop, after which the rule waits for a person, too, if it was one."""
        self._released |= dict.fromkeys(robots, self._world.time)

    def sent_by_person(self, robot: "Robot", goal: "CarriedOut") -> None:
        """A robot accepts a goal of somebody."""
        self._person_goals[robot.name].append(goal)

    def _is_continued_since(self, robot: str, at: float) -> bool:
        done = (goal for goal in self._person_goals[robot] if goal.status is GoalStatus.SUCCEEDED)
        return self._continued.get(robot, -1.0) >= at or any(goal.at >= at for goal in done)

    # ------------------------------------------------------------------ goals

    def docks(self, robot: "Robot", goal: "CarriedOut", key: str, stop: tuple[float, float]) -> None:
        """A robot accepts a goal of the rule; `stop` is when its last stop began and had ended."""
        world, name = self._world, robot.name
        world.checks.counts["docks by a rule"] += 1
        sent = world.checks.sent_at[goal.goal_id]
        before, at = self._docked.get(name, ("", -RETRY_AFTER))
        if before != key and self._world.time - at < RETRY_AFTER - 10.0:
            self._world.fault(f"a rule docks {name} again after {self._world.time - at:.0f} s")
        self._docked[name] = (key, self._world.time)
        if name not in world.ruled:
            self._world.fault(f"a rule docks {name}, to which it does not apply")
        if robot.charge > BELOW and sent > robot.changed_at + 10.0:
            self._world.fault(f"a rule docks {name}, whose charge is {robot.charge:.2f}")
        if robot.dock is not None and robot.docked_at < sent - 1.0:
            self._world.fault(f"a rule docks {name}, which stands on {robot.dock}")
        began, ended = stop
        heard = ended + (1.0 if world.troubles.gateways > 1 else 0.0)
        if began >= 0 and heard < sent and not self._is_continued_since(name, began):
            self._world.fault(f"a rule docks {name}, which was stopped at {began:.3f}, and nobody continued")
        for other in robot.running():
            if other is not goal and other.at < sent - 1.0 and self._world.is_calm(name, other.at, 10.0):
                self._world.fault(f"a rule docks {name} while {other.goal_id} runs")
        known_after = 1.0 if world.troubles.gateways == 1 else 3 * world.troubles.look_every
        for mission_id, mission in world.checks.stored().items():
            on = mission.active and mission.its_robot == name and mission.status is MissionStatus.RUNNING
            since = max(self._world.time_of(mission.started_at), self._world.time_of(mission.allowed_at))
            if on and since < sent - known_after and world.gateways_since < sent - known_after:
                self._world.fault(f"a rule docks {name} on its mission {mission_id}: {mission.current!r:.300}")

    # ------------------------------------------------------------------ robots that it should dock

    def look(self, missions: Mapping[str, MissionEntry], stops: Mapping[str, tuple[float, float]]) -> None:
        """Look at the robots.

        Args:
            missions: The missions that have not ended.
            stops: When the last stop of each robot began and had ended.
        """
        passed, self._looked_at = self._world.time - self._looked_at, self._world.time
        on = {mission.its_robot: (key, mission) for key, mission in missions.items() if mission.active}
        for name in self._world.ruled:
            robot = self._world.robots[name]
            mission_id, mission = on.get(name, ("", None))
            at_work = mission is not None and mission.status is not MissionStatus.HELD
            latched = any(gateway.interlock.holds(name) for gateway in self._world.gateways if gateway.ready)
            unasked = not latched and mission is not None and self._is_to_be_asked(robot, mission)
            if self._unasked.exceeds(name, passed, holds=unasked):
                self._world.fault(f"{name} has {robot.charge:.2f} of its charge, and no rule has asked {mission_id}")
            began, _ = stops.get(name, (-1.0, -1.0))
            since = max(began, self._released.get(name, -1.0))
            stopped = since >= 0 and not self._is_continued_since(name, since)
            able = not at_work and not latched and not stopped and self._is_able(robot, missions)
            if self._able.exceeds(name, passed, holds=able):
                said = [gateway.rules.waits for gateway in self._world.gateways if gateway.ready]
                self._world.fault(f"{name} has {robot.charge:.2f} of its charge, and no rule docks it: {said}")

    def _is_to_be_asked(self, robot: "Robot", mission: MissionEntry) -> bool:
        """Return whether the rule asks a mission on which a robot is to let it charge."""
        asks = mission.status is MissionStatus.RUNNING and mission.limits is None and robot.charge < ASKS_BELOW
        return asks and self._world.is_calm(robot.name, 0.0, NOTICED_AFTER)

    def _is_able(self, robot: "Robot", missions: Mapping[str, MissionEntry]) -> bool:
        """Return whether the rule docks a robot that is on no mission, once it has been idle for long enough."""
        calm = self._world.is_calm(robot.name, 0.0, NOTICED_AFTER)
        if robot.charge >= BELOW or robot.running() or robot.dock is not None or not calm:
            return False
        if any(goal.status is GoalStatus.LOST for goal in self._world.goals_on(robot.name)):
            return False
        now, retry = self._world.now(), timedelta(seconds=RETRY_AFTER)
        for decision in decisions_of_rules(self._world.disk, robot.name):
            given_up = decision["open"] and decision["outcome"] == "gave_up"
            if given_up or now - datetime.fromisoformat(decision["decided_at"]) < retry:
                return False
        for gateway in self._world.gateways:
            last = gateway.parts[Fleet].state(robot.name).last_goal if gateway.ready else None  # type: ignore[union-attr]
            if last is not None and last.status is not GoalStatus.SUCCEEDED and now - last.finished_at < retry:
                return False
        others = {mission.its_robot for mission in missions.values() if wants_dock(mission)}
        for name, wait in dock_waits(self._world.disk).items():
            others |= {name} if now - datetime.fromisoformat(wait["asked_at"]) < retry else set()
        return len(self._batteries.free_docks(robot)) > len(others - {robot.name})
