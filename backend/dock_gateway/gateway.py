"""The gateway: its parts, as the API uses them, and what needs several of them."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

from dock_gateway.access.logins import Logins
from dock_gateway.access.quotas import Quotas
from dock_gateway.access.tickets import Tickets
from dock_gateway.audit.log import AuditLog
from dock_gateway.automation.docking import AutomaticDocking
from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, NotFound, Unavailable
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal, Verb
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.hub import Hub
from dock_gateway.core.namespace import normalize_namespace
from dock_gateway.fleet.alerts import AlertBoard
from dock_gateway.fleet.overview import Fleet
from dock_gateway.goals.action import Action
from dock_gateway.goals.cancellation import require_unfinished
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.hints import Hint, docking_hint
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.echoes import EchoRegistry
from dock_gateway.observability.metrics import Metrics
from dock_gateway.robots.calibration import Calibrations
from dock_gateway.robots.labels import Labels
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.simulator import Simulators
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import GoalFilter, History
from dock_gateway.webhooks.notifier import Notifier

# Maximum number of goals of each kind that a new subscriber gets from the history.
RECENT = 20
# The errors of a robot that is not there, or has no docking server.
NO_DOCKING_SERVER = frozenset({"action_not_found", "action_server_unavailable", "robot_not_found"})


@dataclass(frozen=True)
class Gateway:
    """The parts of the gateway, as the API uses them."""

    settings: Settings
    bridge: Bridge
    hub: Hub
    history: History
    actions: ActionRegistry
    robots: RobotRegistry
    stopper: Stopper
    simulators: Simulators
    calibrations: Calibrations
    docks: Docks
    fleet: Fleet
    labels: Labels
    alerts: AlertBoard
    automation: AutomaticDocking
    notifier: Notifier
    logins: Logins
    tickets: Tickets
    quotas: Quotas
    audit: AuditLog
    graph: GraphCache
    echoes: EchoRegistry
    metrics: Metrics

    async def docking_action(self, verb: Verb, robot: str | None = None) -> Action:
        """Return the action that docks or undocks a robot; default: the configured one.

        Raises:
            NotFound: There is no such robot, or it has no such action.
            Unavailable: Its package is not installed (`interface_not_installed`).
        """
        return await self.actions.find_docking(verb, self.robots.get(robot).namespace)

    async def goal(self, goal_id: str, grant: Grant = UNLIMITED) -> Goal:
        """Return a goal of any action.

        Raises:
            NotFound: There is no such goal, or the grant does not cover it, which is the same to who asks.
        """
        goal = self.actions.goal(goal_id)
        if goal is None or not grant.covers_action(goal.action_name):  # if the history is away, that is the same, too
            goal = await self.history.get(goal_id) or goal
        if goal is None or not grant.covers_action(goal.action_name):
            raise NotFound(f"there is no goal {goal_id}", code="goal_not_found")
        return goal

    async def page(
        self, wanted: GoalFilter, limit: int = 50, before: str | None = None
    ) -> tuple[list[Goal], str | None]:
        """Return a page of goals, newest first, and the cursor of the next page.

        Raises:
            InvalidField: There is no goal `before` on these actions.
        """
        if before is not None:
            last = self.actions.goal(before) or await self.history.get(before)
            if last is None or not wanted.includes(last.action_name):
                unknown = "there is no such goal in this list"
                raise InvalidField([FieldError("cursor", "`next_cursor` of an earlier answer", unknown)])
        goals = await self.history.page(wanted, limit=limit + 1, before=before)
        current = [self.actions.goal(goal.goal_id) or goal for goal in goals[:limit]]
        return current, goals[limit - 1].goal_id if len(goals) > limit else None

    async def cancel(self, goal_id: str) -> Goal:
        """Ask the action server to cancel a goal of any action, regardless of its sender.

        Raises:
            NotAuthenticated: The login of who cancels it has ended meanwhile (`invalid_token`).
            NotFound: There is no such goal, or its action has no server.
            Conflict: The goal has ended (`goal_terminal`), or the server refuses (`cancel_rejected`).
            Unavailable: The action server is gone.
            ServerTimeout: The server did not answer in time.
        """
        goal = await self.goal(goal_id)
        require_unfinished(goal)
        action = await self.actions.find(goal.action_name)
        goal = await self.goal(goal_id)  # it may have returned or ended meanwhile
        await action.canceler.cancel(goal)
        return goal

    async def recent_goals(self, event_filter: EventFilter) -> list[Goal]:
        """Return a new subscriber's initial goals: the running and the latest ended ones, newest first."""
        if event_filter.goal_id is not None:
            return [await self.goal(event_filter.goal_id)]
        newest: list[Goal] = []
        with suppress(Unavailable):  # a stream works without the past
            # Docking and undocking goals are queried by name, so that a busier action does not crowd them out.
            named, all_names = event_filter.action_name, self.actions.docking.all_names
            queries: list[frozenset[str]] = [frozenset() if named is None else frozenset({named})]
            if named is None:
                queries += [all_names(event_filter.robot, "dock"), all_names(event_filter.robot, "undock")]
            for names in queries:
                newest += await self.history.page(
                    GoalFilter(names, event_filter.namespace, homed=event_filter.homed), limit=RECENT
                )
        known = [*newest, *self.actions.running()]
        goals = {goal.goal_id: goal for goal in known if event_filter.covers_goal(goal.goal_id, goal.action_name)}
        return sorted(goals.values(), key=lambda goal: goal.created_at, reverse=True)

    @contextmanager
    def hinting(self, robot: str | None, grant: Grant) -> Iterator[None]:
        """Add a hint to the error that a robot is not there or has no docking server.

        Args:
            robot: The robot's namespace; None for the configured one.
            grant: Only what it covers is named.

        Raises:
            GatewayError: What was raised within, with the hint in its detail, and `settings` and `robots`.
        """
        try:
            yield
        except GatewayError as error:
            if error.code in NO_DOCKING_SERVER and (hint := self.hint(robot, grant)) is not None:
                error.detail = f"{error.detail}. {hint.detail}"
                error.extra.update(settings=hint.settings, robots=hint.robots)
            raise

    def hint(self, robot: str | None, grant: Grant) -> Hint | None:
        """Return the hint for a robot without a docking server; None if nothing on the graph helps."""
        name = self.robots.default_namespace if robot is None else normalize_namespace(robot)
        return docking_hint(name, self.fleet.sights(grant))

    def say_goodbye(self) -> None:
        """End every stream and every wait, as the gateway is about to close."""
        self.hub.close()
        self.actions.each(lambda action: action.tracker.release_all())
