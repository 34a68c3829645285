"""What must hold for robots that wait for docks, and for their drives to where they wait."""

from collections.abc import Mapping
from datetime import datetime, timedelta
from typing import TYPE_CHECKING

from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.step_entry import StepEntry, StepStatus
from dock_gateway.extensions.missions.waiting import DRIVES_WITHIN
from tests.extensions.missions.simulation.duration import Duration
from tests.extensions.missions.simulation.stored import dock_waits

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.battery_checks import BatteryChecks
    from tests.extensions.missions.simulation.robot import Robot
    from tests.extensions.missions.simulation.world import World

# Seconds after which gateways have noticed what has happened, and after which a robot has a dock that is free.
NOTICED_AFTER, FREE_AFTER = 60.0, 120.0
# Seconds for which a robot waits that asks no more.
ASKS_WITHIN = timedelta(seconds=30)
# Seconds after its four minutes at which a drive has ended at the latest, also if the robot refuses that a few times.
ENDS_WITHIN = 90.0


class DriveChecks:
    """Follows robots that wait for docks.

    - A robot is sent to its waiting place once in a wait: from when its step asks for the dock, or somebody continues
      its mission, until it has the dock.
    - No other robot waits at that place, or drives there.
    - A robot on a dock stays there.
    - A drive takes no longer than four minutes, and its step no longer than its `timeout_s` with it.
    - A stop holds the mission, and the drive begins again only if somebody continues it.
    - A robot that waits has the dock two minutes after it is free, unless others may come first: those that want one,
      and those that keep their turn for the five minutes that a drive may take. A drive ends before.

    Args:
        world: The run.
        batteries: Knows which docks are free.
    """

    def __init__(self, world: "World", batteries: "BatteryChecks") -> None:
        self._world = world
        self._batteries = batteries
        self._sent: dict[tuple[object, ...], tuple[str, object]] = {}  # the last drive in each wait, and where to
        self._free = Duration(FREE_AFTER)  # the dock that a robot waits for
        self._looked_at = 0.0

    # ------------------------------------------------------------------ drives

    def begins(self, robot: "Robot", key: str, mission_id: str, mission: MissionEntry) -> None:
        """A robot begins to drive to its waiting place, for a mission that is not being held or canceled."""
        self._world.checks.counts["drives to waiting places"] += 1
        drive, place = mission.drive, mission.wait_at
        if drive is None or key != f"mission-{mission_id}-{mission.position}-{drive.attempt}":
            self._world.fault(f"{key} is carried out, and {mission_id} is at {mission.position}: {drive!r:.300}")
            return
        asks = step_of(mission)
        position = (mission.step, mission.recharge and mission.recharge.number)
        wait = (mission_id, position, asks.attempt, mission.allowed_since)
        last = self._sent.get(wait)
        if last is not None and last[0] != key and last[1] == place:
            self._world.fault(f"{mission_id} sends {robot.name} to {place} again, in one wait: {last[0]}, {key}")
        self._sent[wait] = (key, place)
        began = self._world.time_of(drive.started_at)
        if (
            robot.dock is not None
            and robot.docked_at < began
            and self._world.is_calm(robot.name, robot.docked_at, NOTICED_AFTER)
        ):
            self._world.fault(f"{robot.name} leaves {robot.dock} for where it waits")
        for name, wait_entry in self._live_waits().items():
            if name != robot.name and place is not None and wait_entry == (place.frame, place.x, place.y):
                self._world.fault(f"{robot.name} drives to {place}, where {name} waits")
        if asks.fails_at is not None and drive.fails_at is not None:
            over = (drive.fails_at - asks.fails_at).total_seconds()
            if over > 2 * self._world.troubles.look_every and self._world.is_calm(robot.name, began, NOTICED_AFTER):
                self._world.fault(f"{key} may take {over:.0f} s longer than its step")

    def _live_waits(self) -> dict[str, tuple[object, ...] | None]:
        """Return where robots wait that keep their turn, or are on their way to; None: where they are."""
        found: dict[str, tuple[object, ...] | None] = {}
        now = self._world.now()
        for name, wait in dock_waits(self._world.disk).items():
            drives = wait["arrives_by"] is not None and now < datetime.fromisoformat(wait["arrives_by"])
            asks = now - datetime.fromisoformat(wait["asked_at"]) < ASKS_WITHIN
            place = wait["wait_at"]
            if drives or asks:
                found[name] = None if place is None else tuple(place[field] for field in ("frame", "x", "y"))
        return found

    # ------------------------------------------------------------------ waits

    def look(self, missions: Mapping[str, MissionEntry]) -> None:
        """Look at all missions that have not ended."""
        passed, self._looked_at = self._world.time - self._looked_at, self._world.time
        waits = self._live_waits()
        places = [place for place in waits.values() if place is not None]
        if len(places) != len({*places}):
            self._world.fault(f"two robots wait at one place: {waits}")
        for mission_id, mission in missions.items():
            if mission.drive is not None and mission.status is MissionStatus.RUNNING:
                self._look_at_drive(mission_id, mission, mission.drive)
        waiting = {mission.its_robot: (key, mission) for key, mission in missions.items() if _waits(mission)}
        self._free.keep({*waiting})
        for name, (mission_id, mission) in waiting.items():
            others = {each.its_robot for each in missions.values() if wants_dock(each)} | {*waits}
            free = self._could_have_dock(self._world.robots[name], mission, len(others - {name}))
            if self._free.exceeds(name, passed, holds=free):
                self._world.fault(f"{mission_id} waits for a dock that is free for {name}: {mission.current!r:.300}")

    def _look_at_drive(self, mission_id: str, mission: MissionEntry, drive: StepEntry) -> None:
        robot, began = mission.its_robot, self._world.time_of(drive.started_at)
        stopped = self._world.checks.stopped_at(robot, mission_id, mission)
        if stopped is not None and self._world.is_calm(robot, stopped, NOTICED_AFTER):
            self._world.fault(f"{robot} was stopped at {stopped:.3f}, and {mission_id} is not held: it drives to wait")
        late = drive.status is StepStatus.RUNNING and self._world.time - began > DRIVES_WITHIN + ENDS_WITHIN
        if late and self._world.is_calm(robot, began, NOTICED_AFTER):
            self._world.fault(f"{robot} drives to where it waits for {self._world.time - began:.0f} s")

    def _could_have_dock(self, robot: "Robot", mission: MissionEntry, others: int) -> bool:
        """Return whether a dock is free that a robot waits for, and no other one may have it before."""
        if robot.running() or not self._world.is_calm(
            robot.name, self._world.time_of(mission.current.started_at), NOTICED_AFTER
        ):
            return False
        wait, free = dock_waits(self._world.disk).get(robot.name), self._batteries.free_docks(robot)
        return wait is not None and len(free) > others and any(dock in free for dock in wait["docks"])


def step_of(mission: MissionEntry) -> StepEntry:
    """Return the step that asks for a dock, of a mission that waits for one or is on its way to where it waits."""
    return mission.steps[mission.step] if mission.recharge is None else mission.recharge.step


def wants_dock(mission: MissionEntry) -> bool:
    """Return whether a robot waits for a dock, or drives to one, or to where it waits."""
    return mission.active and step_of(mission).verb == "dock"


def _waits(mission: MissionEntry) -> bool:
    """Return whether a mission has asked for a dock and not got it, and is not on its way to where it waits."""
    if mission.status is not MissionStatus.RUNNING:
        return False
    step = mission.current
    return step.status is StepStatus.RUNNING and step.verb == "dock" and step.goal_id is None
