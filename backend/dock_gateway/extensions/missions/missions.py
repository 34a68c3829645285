"""What people do with missions: queue, edit, move, pause, continue and cancel them, within their grants."""

import asyncio
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from dock_gateway.core.errors import Conflict, FieldError, InvalidField, NotFound, got, not_covered
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.core.versions import Condition
from dock_gateway.extensions.missions import progress
from dock_gateway.extensions.missions.actions import action_of, actions_of, covers, read_goal, robots_of
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.messages import Messages
from dock_gateway.extensions.missions.mission import HoldReason, MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moving import move
from dock_gateway.extensions.missions.places.places import Places
from dock_gateway.extensions.missions.runner import MissionRunner
from dock_gateway.extensions.missions.schema import MissionBody, MissionContent
from dock_gateway.extensions.missions.templates.parameters import at_arguments
from dock_gateway.extensions.missions.templates.templates import Filled, Templates
from dock_gateway.extensions.missions.turns import Members, require_in_queue
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.stop.last_stops import LastStops


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
        members: Returns the robots that are in a group.
        approvals: Which goals of agents a person has to allow.
        last_stops: When robots were last stopped.
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
        members: Members,
        approvals: Approvals,
        last_stops: LastStops,
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
        self._members = members
        self._approvals = approvals
        self._last_stops = last_stops

    async def add(self, mission_id: str, body: MissionBody, robot: str | None, grant: Grant) -> Mapping[str, Any]:
        """Queue a mission for a robot, or for one of a group; return it.

        Raises:
            InvalidField, NotAllowed: As `make`; or it is for both.
            NotFound: `robot_not_found`, `template_not_found`.
            Conflict: There are too many (`limit_reached`), or the id is that of another one (`idempotency_key_reused`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        if body.group is not None and robot is not None:
            raise InvalidField([FieldError("group", "a group, or a robot in the query", "got both")])
        namespace = None if body.group is not None else self._find_robot(robot, grant)
        return await self.queue(mission_id, await self.make(body, namespace, grant, body.by, body.group))

    def _find_robot(self, robot: str | None, grant: Grant) -> str:
        """Return the namespace of a robot; default: the configured one.

        Raises:
            InvalidField: It is not one.
            NotAllowed: The grant does not cover it (`not_allowed`).
            NotFound, ServedElsewhere: There is none (`robot_not_found`), or another gateway serves it.
        """
        name = self._robots.default_namespace if robot is None else read_namespace(robot)
        if not grant.own.covers_robot(name):
            hint = "; name one of yours with `robot`" if robot is None else ""
            raise not_covered(f"the robot {name[:100]}{hint}")
        return self._robots.get(robot).namespace

    async def queue(self, mission_id: str, mission: MissionEntry) -> Mapping[str, Any]:
        """Queue a mission that was made; return it.

        Raises:
            Conflict, Unavailable: As `add`.
        """
        added = await self.book.add(mission_id, mission)
        self._runner.wake()
        return self.book.describe(mission_id, added)

    async def replace(
        self, mission_id: str, body: MissionBody, grant: Grant, condition: Condition
    ) -> Mapping[str, Any]:
        """Replace what a mission is to do that has not begun; return it. It keeps its robot and its place in the queue.

        Raises:
            ChangedMeanwhile: The condition is not true.
            Conflict: It has begun (`mission_begun`) or ended (`mission_ended`).
            NotFound: `mission_not_found`, `template_not_found`.
            InvalidField, NotAllowed, Unavailable: As `make`.
        """
        found = await self.book.find(mission_id, grant)
        if body.group not in (None, found.group):
            raise InvalidField([FieldError("group", "that which it is for, or none", got(body.group))])
        mission = await self.make(body, found.robot, grant, body.by, found.group)

        def revise(before: MissionEntry) -> MissionEntry:
            require_in_queue(mission_id, before)
            condition.require(before.etag)
            return before.edited(mission)

        return await self._amend(mission_id, grant, revise)

    async def move(self, mission_id: str, other_id: str, grant: Grant, *, before: bool) -> Mapping[str, Any]:
        """Put a mission right before or behind another one of its queue, whose priority it gets; return it.

        Raises:
            Conflict, NotFound, Unavailable: As `moving.move`.
        """
        moved = await move(self.book, mission_id, other_id, grant, self._members, before=before)
        self._runner.wake()
        return self.book.describe(mission_id, moved)

    async def make(
        self, content: MissionContent, robot: str | None, grant: Grant, by: str | None, group: str | None = None
    ) -> MissionEntry:
        """Return a mission that may be queued.

        Args:
            content: What it is.
            robot: The namespace of its robot; None if it is for one of a group.
            grant: What it may use.
            by: Who queues it.
            group: That group.

        Raises:
            InvalidField: A place is not there, a goal is not one of its action, or a message not of its type.
            NotAllowed: The grant does not cover a robot of the group or an action, or the settings do not name a
                service or a topic (`not_allowed`).
            NotFound: `template_not_found`.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        filled = await self._fill(content, grant)
        with at_arguments({} if filled is None else filled.places):
            mission = content.entry(robot, filled, by, group)
            await self._require(mission, grant)
        if grant.role is Role.AGENT:
            mission = mission.but(by_agent=True)
            if self._needs_approval(mission, grant):
                mission = mission.but(status=MissionStatus.HELD, held_for=HoldReason.APPROVAL)
        return mission

    async def covers(self, content: MissionContent, robot: str | None, grant: Grant, group: str | None = None) -> bool:
        """Return whether a grant covers all that a mission would use, and its robot or those of its group.

        Not so if it could not be made.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        try:
            mission = content.entry(robot, await self._fill(content, grant), group=group)
        except (InvalidField, NotFound):
            return False
        return covers(mission, grant, self._robot_actions, self._members)

    async def _fill(self, content: MissionContent, grant: Grant) -> Filled | None:
        if content.template is None:
            return None
        return await self._templates.fill(content.template, content.arguments or {}, grant)

    async def _require(self, mission: MissionEntry, grant: Grant) -> None:
        robots = robots_of(mission, self._members)
        if mission.robot is None:
            grant = grant.own  # its robots may be served by several gateways
            if not all(map(grant.covers_robot, robots)) or (grant.limited and not robots):
                raise not_covered(f"every robot of the group {mission.group}")
        for name in actions_of(mission, robots, self._robot_actions):
            grant.require_action(name)
        for step in mission.steps:
            self._messages.require(step, grant)
        await self._require_goals(mission, robots)

    def _needs_approval(self, mission: MissionEntry, grant: Grant) -> bool:
        """Return whether a person has to see the mission of an agent first: it has or moves a real robot."""
        robots = robots_of(mission, self._members)
        goals = actions_of(mission, robots, self._robot_actions)
        goals |= {self._robot_actions.docking_name("dock", robot) for robot in robots}
        return (
            mission.robot is None
            or any(step.is_message for step in mission.steps)
            or any(self._approvals.needs(grant, name) for name in goals)
        )

    async def _require_goals(self, mission: MissionEntry, robots: Iterable[str]) -> None:
        """Check the places, and the goals and messages of the steps whose servers are there, as far as that goes now.

        Args:
            mission: The mission.
            robots: Those that may take it. A goal is checked with the action of one of them.

        Raises:
            InvalidField: A place is not there, or one is not a goal of its action or a message of its type; its path
                begins with the step's.
        """
        for each in mission.steps:
            step = await self._places.require(each, f"steps.{each.path}")
            names = filter(None, (action_of(step, robot, self._robot_actions) for robot in robots))
            action = next(filter(None, map(self._actions.get, names)), None)
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
        """Let a mission that is held go on, or a robot that was stopped begin one of its group; return it.

        Raises:
            NotFound: `mission_not_found`.
            Conflict: It has ended (`mission_ended`), is not held (`mission_not_held`), or its robot is stopped
                (`stop_latched`).
            Unavailable: The history does not answer (`history_unavailable`).
        """

        def revise(mission: MissionEntry) -> MissionEntry:
            if mission.robot is None and mission.status is MissionStatus.QUEUED:
                return mission.but(allowed_at=utc_now())
            return progress.resume(self._require_held(mission), utc_now())

        return await self._let_go_on(mission_id, grant, revise)

    async def skip(self, mission_id: str, grant: Grant) -> Mapping[str, Any]:
        """Let a mission that is held go on without its step; return it.

        Raises:
            NotFound, Conflict, Unavailable: As `resume`.
        """
        return await self._let_go_on(mission_id, grant, lambda each: progress.skip(self._require_held(each), utc_now()))

    async def _let_go_on(
        self, mission_id: str, grant: Grant, revise: Callable[[MissionEntry], MissionEntry]
    ) -> Mapping[str, Any]:
        since = utc_now()
        document = await self._amend(mission_id, grant, revise)
        if document["robot"] is not None:
            await self._last_stops.allow(document["robot"], since)
            self._runner.wake()
        return document

    def _require_held(self, mission: MissionEntry) -> MissionEntry:
        if mission.status is not MissionStatus.HELD:
            raise Conflict(f"the mission is {mission.status.value}, not held", code="mission_not_held")
        if mission.robot is not None:
            self._interlock.require_released(mission.robot, "missions")
        return mission

    async def _amend(
        self, mission_id: str, grant: Grant, revise: Callable[[MissionEntry], MissionEntry]
    ) -> Mapping[str, Any]:
        revised = await self.book.amend(mission_id, grant, revise)
        self._runner.wake()
        return self.book.describe(mission_id, revised)
