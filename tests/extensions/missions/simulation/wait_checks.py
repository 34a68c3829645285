"""What must hold for missions that wait: each goes on once nothing is in its way, and says what it waits for."""

from collections.abc import Mapping
from datetime import timedelta
from typing import TYPE_CHECKING

from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moves import WaitsFor
from dock_gateway.extensions.missions.step_entry import StepStatus
from tests.extensions.missions.simulation.stored import robot_of

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.world import World

# Seconds within which a mission goes on once nothing is in its way, at least, and in looks of the gateways.
GOES_ON_AFTER, LOOKS = 300.0, 40


class WaitChecks:
    """Follows missions that do not change.

    Args:
        world: The run.
    """

    def __init__(self, world: "World") -> None:
        self._world = world
        self._goes_on_after = max(GOES_ON_AFTER, LOOKS * world.troubles.look_every)
        self._changed: dict[str, tuple[int, float]] = {}  # the revision of each mission, and since when
        self._stuck: dict[str, int] = {}  # the revisions of missions that had no reason to wait at the last look
        self._idle_since: dict[str, float] = {}  # robots
        self._docks_free_since = 0.0

    def look_at(self, mission_id: str, mission: MissionEntry) -> None:
        """Look at a mission that has not ended."""
        revision, since = self._changed.get(mission_id, (-1, 0.0))
        if revision != mission.revision:
            self._changed[mission_id] = (mission.revision, self._world.time)
        elif self._world.time - since > self._goes_on_after and not mission.status.ended:
            self._check_wait(mission_id, mission, idle=self._is_idle(robot_of(mission)))

    def look_at_robots(self, active: Mapping[str, int]) -> None:
        """Note since when robots are on no mission, and nobody stands at a dock, drives to one, or to wait for one."""
        for robot in self._world.names:
            if active.get(robot):
                self._idle_since[robot] = self._world.time
        robots = self._world.robots.values()
        servers = (each.servers[kind] for each in robots for kind in ("dock", "navigate") if kind in each.servers)
        drives = any(goal.runs for server in servers for goal in server.goals.values())
        if self._world.docks.robots or drives:
            self._docks_free_since = self._world.time

    def _is_idle(self, robot: str) -> bool:
        return self._world.time - self._idle_since.get(robot, 0.0) > self._goes_on_after

    def _check_wait(self, mission_id: str, mission: MissionEntry, *, idle: bool) -> None:
        """Check that a mission that has not changed for long has a reason for that, and says it."""
        gateways = [gateway for gateway in self._world.gateways if gateway.ready and not gateway.dead]
        if not gateways or any(self._world.time - gateway.ready_at < self._goes_on_after for gateway in gateways):
            return
        if mission.status is MissionStatus.HELD:
            if mission.held_for is None:
                self._world.fault(f"{mission_id} is held, and does not say why")
            return
        said = [gateway.missions.book.waits.get(mission_id) for gateway in gateways]
        if not all(said):
            self._world.fault(f"{mission_id} does not say what it waits for")
        if mission.robot is None:
            if not self._world.checks.groups.may_wait(mission, self._goes_on_after):
                self._world.fault(f"{mission_id} for {mission.group} does not begin: {said}")
            return
        if self._world.time - self._world.calm_since[robot_of(mission)] < self._goes_on_after:
            return
        if WaitsFor.DOCK in said and self._world.time - self._docks_free_since < self._goes_on_after:
            return
        if self._may_wait(mission, idle=idle):
            self._stuck.pop(mission_id, None)
        else:
            self._note_stuck(mission_id, mission, said)

    def _note_stuck(self, mission_id: str, mission: MissionEntry, said: object) -> None:
        """Note that a mission has no reason to wait. It may just have come: one look later, that is wrong."""
        if self._stuck.get(mission_id) != mission.revision:
            self._stuck[mission_id] = mission.revision
            return
        self._world.fault(f"{mission_id} does not go on: {said}, {mission.status.value}, step {mission.current!r:.400}")
        self._changed[mission_id] = (mission.revision, self._world.time)

    def _may_wait(self, mission: MissionEntry, *, idle: bool) -> bool:
        robot = self._world.robots[robot_of(mission)]
        if mission.status is MissionStatus.QUEUED or robot.running():  # its own goal, or that of somebody else
            return not idle
        step, now = mission.current, self._world.now()
        if step.has_message:  # one that was killed may have sent it: as long as the answer could come
            waited = (now - (step.started_at or now)).total_seconds()
            return waited < step.answer_within + self._goes_on_after
        if step.status is StepStatus.WAITING or step.wait is None:
            late = step.is_late(now - timedelta(seconds=self._goes_on_after))
            return step.has_goal and step.goal_id is not None and not late  # its goal is lost, and may return
        if step.wait.battery is not None and not step.is_late(now):
            return robot.charge < step.wait.battery
        ends_at = step.wait.ends_at(step.started_at or now)
        return ends_at is not None and now < ends_at and not step.is_late(now)
