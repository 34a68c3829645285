"""The goals of all actions: found and listed, whichever action they are on."""

from contextlib import suppress
from typing import Protocol

from dock_gateway.core.cursor import Cursor
from dock_gateway.core.dock_adapters.catalog import ADAPTERS
from dock_gateway.core.errors import NotFound, Unavailable
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.storage import GoalFilter, History
from dock_gateway.storage.queries import cursor_of

# Maximum number of goals of each kind that a new subscriber gets from the history.
RECENT = 20


class LiveGoals(Protocol):
    """The goals that may still change, which are known better than the history has them."""

    def goal(self, goal_id: str) -> Goal | None:
        """Return a running or lost goal of any action."""

    def running(self) -> list[Goal]:
        """Return the running goals of all actions."""


class Goals:
    """The goals that are running, and those of the history.

    Args:
        live: Those that are running.
        robot_actions: Which actions dock and undock robots.
        history: Has all of them, as they were when they were last stored.
    """

    def __init__(self, live: LiveGoals, robot_actions: RobotActions, history: History) -> None:
        self._live = live
        self._robot_actions = robot_actions
        self._history = history

    async def get(self, goal_id: str, grant: Grant = UNLIMITED) -> Goal:
        """Return a goal of any action.

        Raises:
            NotFound: There is no such goal, or the grant does not cover it: the client gets the same answer.
        """
        goal = self._live.goal(goal_id)
        # The answer is the same while the history cannot be read.
        if goal is None or not grant.covers_action(goal.action_name):
            goal = await self._history.get(goal_id) or goal
        if goal is None or not grant.covers_action(goal.action_name):
            raise NotFound(f"there is no goal {goal_id}", code="goal_not_found")
        return goal

    async def page(
        self, wanted: GoalFilter, limit: int = 50, before: Cursor | None = None
    ) -> tuple[list[Goal], Cursor | None]:
        """Return a page of goals, newest first, and where it ends if there are more.

        Args:
            wanted: Which goals.
            limit: Maximum number of goals.
            before: Where the page before ended. The goal that was there need not be any more.
        """
        goals = await self._history.page(wanted, limit=limit + 1, before=before)
        current = [self._live.goal(goal.goal_id) or goal for goal in goals[:limit]]
        return current, cursor_of(goals[limit - 1]) if len(goals) > limit else None

    async def recent(self, event_filter: EventFilter) -> list[Goal]:
        """Return a new subscriber's initial goals: the running and the latest ended ones, newest first."""
        if event_filter.goal_id is not None:
            return [await self.get(event_filter.goal_id)]
        newest: list[Goal] = []
        with suppress(Unavailable):  # a stream works without the past
            # Docking and undocking goals are queried by name, so that a busier action does not crowd them out.
            named, robot = event_filter.action_name, event_filter.robot
            queries: list[frozenset[str]] = [frozenset() if named is None else frozenset({named})]
            if named is None:
                queries += [self._robot_actions.docking_names(robot, verb) for verb in ADAPTERS]
            for names in queries:
                newest += await self._history.page(
                    GoalFilter(names, event_filter.namespace, homed=event_filter.homed), limit=RECENT
                )
        known = [*newest, *self._live.running()]
        goals = {goal.goal_id: goal for goal in known if event_filter.covers_goal(goal.goal_id, goal.action_name)}
        return sorted(goals.values(), key=lambda goal: goal.created_at, reverse=True)
