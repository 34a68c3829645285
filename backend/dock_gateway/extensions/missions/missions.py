"""What people do with missions: queue, pause, continue and cancel them, within their grants."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from dock_gateway.core.errors import Conflict, InvalidField, NotFound
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant
from dock_gateway.extensions.missions import progress
from dock_gateway.extensions.missions.actions import action_of, actions_of, covers, read_goal
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.messages import Messages
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.places.places import Places
from dock_gateway.extensions.missions.runner import MissionRunner
from dock_gateway.extensions.missions.schema import MissionBody, MissionContent
from dock_gateway.extensions.missions.templates.parameters import at_arguments
from dock_gateway.extensions.missions.templates.templates import Filled, Templates
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
        messages: Checks calls and messages.
        places: The places that steps drive to.
        templates: The templates that missions are made of.
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
        messages: Messages,
        places: Places,
        templates: Templates,
        interlock: Interlock,
    ) -> None:
        self.book = book
        self._runner = runner
        self._robots = robots
        self._actions = actions
        self._robot_actions = robot_actions
        self._messages = messages
        self._places = places
        self._templates = templates
        self._interlock = interlock

    async def add(self, mission_id: str, body: MissionBody, robot: str | None, grant: Grant) -> Mapping[str, Any]:
        """Queue a mission; return it.

        Raises:
            InvalidField, NotAllowed: As `make`.
            NotFound: `robot_not_found`, `template_not_found`.
            Conflict: There are too many (`limit_reached`), or the id is that of another one (`idempotency_key_reused`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return await self.queue(mission_id, await self.make(body, self._robots.get(robot).namespace, grant, body.by))

    async def queue(self, mission_id: str, mission: MissionEntry) -> Mapping[str, Any]:
        """Queue a mission that was made; return it.

        Raises:
            Conflict, Unavailable: As `add`.
        """
        added = await self.book.add(mission_id, mission)
        self._runner.wake()
        return self.book.describe(mission_id, added)

    async def make(self, content: MissionContent, robot: str, grant: Grant, by: str | None) -> MissionEntry:
        """Return a mission that may be queued.

        Args:
            content: What it is.
            robot: The namespace of its robot.
            grant: What it may use.
            by: Who queues it.

        Raises:
            InvalidField: A place is not there, a goal is not one of its action, or a message not of its type.
            NotAllowed: The grant does not cover an action, or the settings do not name a service or a topic
                (`not_allowed`).
            NotFound: `template_not_found`.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        filled = await self._fill(content, grant)
        with at_arguments({} if filled is None else filled.places):
            mission = content.entry(robot, filled, by)
            await self._require(mission, grant)
        return mission

    async def covers(self, content: MissionContent, robot: str, grant: Grant) -> bool:
        """Return whether a grant covers all that a mission would use; not so if it could not be made.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        try:
            mission = content.entry(robot, await self._fill(content, grant))
        except (InvalidField, NotFound):
            return False
        return covers(mission, grant, self._robot_actions)

    async def _fill(self, content: MissionContent, grant: Grant) -> Filled | None:
        if content.template is None:
            return None
        return await self._templates.fill(content.template, content.arguments or {}, grant)

    async def _require(self, mission: MissionEntry, grant: Grant) -> None:
        for name in actions_of(mission, self._robot_actions):
            grant.require_action(name)
        for step in mission.steps:
            self._messages.require(step, grant)
        await self._require_goals(mission)

    async def _require_goals(self, mission: MissionEntry) -> None:
        """Check the places, and the goals and messages of the steps whose servers are there, as far as that goes now.

        Raises:
            InvalidField: A place is not there, or one is not a goal of its action or a message of its type; its path
                begins with the step's.
        """
        for each in mission.steps:
            step = await self._places.require(each, f"steps.{each.path}")
            name = action_of(step, mission.robot, self._robot_actions)
            action = None if name is None else self._actions.get(name)
            if action is not None:
                await read_goal(step, action, f"steps.{step.path}")
        await asyncio.gather(*(self._messages.check(step, f"steps.{step.path}") for step in mission.steps))

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
        revised = await self.book.amend(mission_id, grant, revise)
        self._runner.wake()
        return self.book.describe(mission_id, revised)
