"""Sends the goals of steps, each once, and cancels them."""

import logging
from collections.abc import Callable
from datetime import datetime

from dock_gateway.core.errors import DockOccupied, GatewayError, TooManyRequests, Unavailable, is_by_stop
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.extensions.missions import progress, waiting
from dock_gateway.extensions.missions.actions import action_of, read_goal
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.facts import has_other_goal, key_of_try
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.moves import Facts, Wait, WaitsFor
from dock_gateway.extensions.missions.step_entry import Reason
from dock_gateway.extensions.missions.step_kinds import Waypoint
from dock_gateway.goals.action import Action
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.stop.last_stops import LastStops

log = logging.getLogger(__name__)


class StepGoals:
    """Sends and cancels goals.

    Args:
        book: The missions.
        actions: All actions.
        robot_actions: Which of them dock and undock each robot.
        docks: The docks that the robots' docking servers know.
        robots: The robots.
        last_stops: When robots were last stopped.
        clock: Returns the time.

    Attributes:
        given_up: The ids of lost goals that are canceled should they return.
    """

    def __init__(
        self,
        book: MissionBook,
        *,
        actions: ActionRegistry,
        robot_actions: RobotActions,
        docks: Docks,
        robots: RobotRegistry,
        last_stops: LastStops,
        clock: Callable[[], datetime] = utc_now,
    ) -> None:
        self._book = book
        self._actions = actions
        self._robot_actions = robot_actions
        self._docks = docks
        self._robots = robots
        self._last_stops = last_stops
        self._clock = clock
        self.given_up: set[str] = set()

    async def send(self, mission_id: str, mission: MissionEntry, facts: Facts) -> Wait | None:
        """Send the goal of the present step, or find it again; return what the mission waits for.

        Raises:
            Unavailable: The history does not answer.
        """
        action = self._action_of(mission)
        if action is None:
            return Wait(WaitsFor.SERVER)
        try:
            goal = await self._submit(mission_id, mission, action, facts)
        except DockOccupied as error:
            return await self._await_dock(mission_id, mission, facts, error)
        except (Unavailable, TooManyRequests) as error:
            if error.code == "history_unavailable":
                raise
            return Wait(WaitsFor.SERVER)
        except GatewayError as error:
            await self._book.change(mission_id, mission, self._refused(mission, error))
            return None
        if isinstance(goal, Wait):
            return goal
        accepted = goal is None or await self._book.change(mission_id, mission, progress.accept(mission, goal.goal_id))
        if goal is not None and not accepted and not progress.has_try(self._book.get(mission_id), mission):
            await self.cancel(goal)  # another gateway has canceled or held it before the goal was sent here
        return None

    def _action_of(self, mission: MissionEntry) -> Action | None:
        """Return the action of the present step, if it has a server."""
        name = action_of(mission.current, mission.its_robot, self._robot_actions)
        action = None if name is None else self._actions.get(name)
        return action if action is not None and action.on_graph else None

    async def _submit(self, mission_id: str, mission: MissionEntry, action: Action, facts: Facts) -> Goal | Wait | None:
        """Send the goal of the present step; return it, what it waits for, or None: the mission has changed.

        Raises:
            GatewayError: It is refused.
        """
        step = mission.current
        message = await read_goal(step, action)
        if step.verb is not None:
            await self._docks.require(action, step.request)
        stored = (await self._book.read()).get(mission_id)
        held = self._last_stops.any_since(mission.its_robot, mission.allowed_since)
        if stored is None or stored.revision != mission.revision or held:
            return None  # such as one that another gateway holds for a stop
        # No wait from here to the submission, which notices every stop that comes later.
        own = None if facts.goal is None else facts.goal.goal_id  # which a gateway that was killed may have sent
        if has_other_goal(mission.its_robot, own, self._actions, self._robots):
            return Wait(WaitsFor.OTHER_GOAL)  # a rule, or somebody, was first
        return await action.submitter.submit(message, key_of_try(mission_id, mission), sender=None)

    def _refused(self, mission: MissionEntry, error: GatewayError) -> MissionEntry:
        """Return a mission whose goal was refused."""
        reason = Reason(code=error.code, detail=error.detail)
        known = mission.with_step(goal_id=error.extra.get("goal_id", mission.current.goal_id))
        return (progress.hold_for_stop if is_by_stop(error) else progress.fail)(known, reason, self._clock())

    async def _await_dock(
        self, mission_id: str, mission: MissionEntry, facts: Facts, occupied: DockOccupied
    ) -> Wait | None:
        """Let the robot wait for its dock, where that has a place for it, if it can drive there.

        Raises:
            Unavailable: The history does not answer.
        """
        place = occupied.extra.get("wait_at")
        after = None if place is None else waiting.drive(mission, Waypoint(**place), facts, self._clock())
        if after is None or self._action_of(after) is None:
            return Wait(WaitsFor.DOCK)
        await self._book.change(mission_id, mission, after)
        return None

    async def cancel(self, goal: Goal) -> None:
        """Cancel the goal of a step. It is asked for again until the goal has ended."""
        action = self._actions.get(goal.action_name)
        if action is not None:
            try:
                await action.canceler.cancel(goal)
            except GatewayError as error:
                log.info("while canceling the goal %s of a mission: %s", goal.goal_id, error.detail)
        if action is None or goal.status is GoalStatus.LOST:
            self.given_up.add(goal.goal_id)
