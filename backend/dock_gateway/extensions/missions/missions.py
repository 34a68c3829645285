"""What people do with missions: queue, pause, continue and cancel them, within their grants."""

from collections.abc import Callable, Mapping
from typing import Any

from dock_gateway.core.errors import Conflict
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant
from dock_gateway.extensions.missions import progress
from dock_gateway.extensions.missions.book import MissionBook, missing
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.runner import MissionRunner
from dock_gateway.extensions.missions.schema import MissionBody
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import RobotRegistry


class Missions:
    """The missions of all robots.

    Args:
        book: The missions.
        runner: Carries them out.
        robots: The robots.
        actions: All actions.
        robot_actions: Which of them dock and undock each robot.
        interlock: The latched stops.
    """

    def __init__(
        self,
        book: MissionBook,
        runner: MissionRunner,
        *,
        robots: RobotRegistry,
        actions: ActionRegistry,
        robot_actions: RobotActions,
        interlock: Interlock,
    ) -> None:
        self.book = book
        self._runner = runner
        self._robots = robots
        self._actions = actions
        self._robot_actions = robot_actions
        self._interlock = interlock

    async def add(self, mission_id: str, body: MissionBody, robot: str | None, grant: Grant) -> Mapping[str, Any]:
        """Queue a mission; return it.

        Raises:
            InvalidField: A goal is not one of its action.
            NotAllowed: The grant does not cover an action (`not_allowed`).
            NotFound: `robot_not_found`.
            Conflict: There are too many (`limit_reached`), or the id is that of another one (`idempotency_key_reused`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        mission = body.entry(self._robots.get(robot).namespace)
        for name in actions_of(mission, self._robot_actions):
            grant.require_action(name)
        await self._require_goals(mission)
        await self.book.add(mission_id, mission)
        self._runner.wake()
        return await self.book.document(mission_id, grant)

    async def _require_goals(self, mission: MissionEntry) -> None:
        """Check the goals of the steps whose actions are there; the others are checked when they are sent.

        Raises:
            InvalidField: One is not a goal of its action; its path begins with that of the step.
        """
        for number, step in enumerate(mission.steps):
            if step.action is not None:
                action, path = self._actions.get(step.action.name), f"steps.{number}.action.goal"
                if action is not None:
                    await action.read_goal(step.request, path)
            elif step.verb is not None:
                action = self._actions.get(self._robot_actions.docking_name(step.verb, mission.robot))
                if action is not None:
                    action.read_docking_request(step.request, f"steps.{number}.{step.verb}")

    async def cancel(self, mission_id: str, grant: Grant) -> Mapping[str, Any]:
        """End a mission; return it.

        Raises:
            NotFound: `mission_not_found`.
            Conflict: `mission_ended`.
            Unavailable: The history does not answer (`history_unavailable`).
        """

        def revise(mission: MissionEntry) -> MissionEntry:
            canceling = mission.status is MissionStatus.CANCELING
            return mission if canceling else progress.cancel(mission, utc_now())

        return await self._amend(mission_id, grant, revise)

    async def pause(self, mission_id: str, grant: Grant) -> Mapping[str, Any]:
        """Hold a mission before its next step; return it. One that is held, or being canceled, stays as it is.

        Raises:
            NotFound, Conflict, Unavailable: As `cancel`.
        """

        def revise(mission: MissionEntry) -> MissionEntry:
            goes_on = mission.status in (MissionStatus.QUEUED, MissionStatus.RUNNING)
            return progress.pause(mission) if goes_on and not mission.pausing else mission

        return await self._amend(mission_id, grant, revise)

    async def resume(self, mission_id: str, grant: Grant) -> Mapping[str, Any]:
        """Let a mission that is held go on; return it.

        Raises:
            NotFound: `mission_not_found`.
            Conflict: It has ended (`mission_ended`), is not held (`mission_not_held`), or its robot is stopped
                (`stop_latched`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return await self._amend(mission_id, grant, lambda each: progress.resume(self._require_held(each), utc_now()))

    async def skip(self, mission_id: str, grant: Grant) -> Mapping[str, Any]:
        """Let a mission that is held go on without its step; return it.

        Raises:
            NotFound, Conflict, Unavailable: As `resume`.
        """
        return await self._amend(mission_id, grant, lambda each: progress.skip(self._require_held(each), utc_now()))

    def _require_held(self, mission: MissionEntry) -> MissionEntry:
        if mission.status is not MissionStatus.HELD:
            raise Conflict(f"the mission is {mission.status.value}, not held", code="mission_not_held")
        self._interlock.require_released(mission.robot, "missions")
        return mission

    async def _amend(
        self, mission_id: str, grant: Grant, revise: Callable[[MissionEntry], MissionEntry]
    ) -> Mapping[str, Any]:
        mission = await self.book.find(mission_id)
        if not covers(mission, grant, self._robot_actions):
            raise missing(mission_id)
        revised = await self.book.amend(mission_id, revise)
        self._runner.wake()
        return self.book.describe(mission_id, revised)


def actions_of(mission: MissionEntry, robot_actions: RobotActions) -> set[str]:
    """Return the names of the actions that a mission sends goals to."""
    named = {step.action.name for step in mission.steps if step.action is not None}
    verbs = {step.verb for step in mission.steps if step.verb is not None}
    return named | {robot_actions.docking_name(verb, mission.robot) for verb in verbs}


def covers(mission: MissionEntry, grant: Grant, robot_actions: RobotActions) -> bool:
    """Return whether a grant covers the robot of a mission, and all actions that it sends goals to."""
    return grant.covers_robot(mission.robot) and all(map(grant.covers_action, actions_of(mission, robot_actions)))
