"""Assembles the gateway: makes its parts in order and closes them in reverse order."""

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeVar

from dock_gateway.access.logins import Logins
from dock_gateway.access.quotas import Quotas
from dock_gateway.access.tickets import Tickets
from dock_gateway.actions.cancellation import require_unfinished
from dock_gateway.actions.liveness import ServerState
from dock_gateway.actions.registry import Action, ActionRegistry
from dock_gateway.actions.unfinished import store_unfinished, take_over_unfinished
from dock_gateway.audit.log import AuditLog
from dock_gateway.automation.activity import Activity
from dock_gateway.automation.decisions import DecisionLog
from dock_gateway.automation.docking import MAX_RULES, AutomaticDocking
from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, NotFound, Unavailable
from dock_gateway.core.event import message_event
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal, GoalError, Json
from dock_gateway.core.hub import Hub
from dock_gateway.core.tasks import PendingFacts, Tasks
from dock_gateway.fleet.alerts import AlertBoard
from dock_gateway.fleet.departures import Departures
from dock_gateway.fleet.labels import Labels
from dock_gateway.fleet.overview import Fleet
from dock_gateway.fleet.pose_recorder import PoseRecorder
from dock_gateway.fleet.scene_board import SceneBoard
from dock_gateway.fleet.shared_book import SharedBook
from dock_gateway.fleet.shared_entries import SharedEntries
from dock_gateway.fleet.stop import Stopper
from dock_gateway.history import GoalFilter, History, open_history
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.notifications.notifier import MAX_WEBHOOKS, Notifier
from dock_gateway.notifications.outbox import Outbox
from dock_gateway.observability.metrics import Metrics
from dock_gateway.observability.parts import Parts
from dock_gateway.observability.traces import open_traces
from dock_gateway.robots.last_goals import LastGoals
from dock_gateway.robots.on_demand import OnDemand
from dock_gateway.robots.registry import RobotRegistry, normalize_namespace
from dock_gateway.robots.simulator import Simulators
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import Scan, scan
from dock_gateway.ros.robot_ports import DiagnosticsPort, VelocityListener
from dock_gateway.ros.scene_port import MapPort, PosePort, ScenePort
from dock_gateway.settings import DockingActions, Settings
from dock_gateway.topics.graph_cache import GraphCache
from dock_gateway.topics.registry import EchoRegistry

log = logging.getLogger(__name__)

# Seconds between two scans of the graph, and between two scans while something on it is still to be registered.
SCAN_INTERVAL, PAUSE = 1.0, 0.1
# Seconds that a rejected or aborted goal waits for the server's reason.
REASON_WAIT = 0.3
# Maximum number of goals of each kind that a new subscriber gets from the history.
RECENT = 20


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
    dock: Action
    undock: Action

    async def dock_of(self, robot: str | None) -> Action:
        """Return the docking action of a robot; default: the configured one.

        Raises:
            NotFound: There is no such robot, or it has no docking action.
        """
        return self.dock if robot is None else await self.actions.find(self._names_of(robot).dock)

    async def undock_of(self, robot: str | None) -> Action:
        """Return the undocking action of a robot; default: the configured one.

        Raises:
            NotFound: There is no such robot, or it has no undocking action.
        """
        return self.undock if robot is None else await self.actions.find(self._names_of(robot).undock)

    def _names_of(self, robot: str) -> DockingActions:
        return self.settings.docking_actions(self.robots.get(robot).namespace)

    def servers_of(self, namespace: str) -> tuple[ServerState, ServerState]:
        """Return the states of a robot's docking and undocking servers, even if they have never been seen."""
        names = self.settings.docking_actions(namespace)
        return self._server(names.dock), self._server(names.undock)

    def _server(self, action_name: str) -> ServerState:
        action = self.actions.get(action_name)
        return ServerState(action_name, available=False, answering=False) if action is None else action.watch.state

    async def goal(self, goal_id: str) -> Goal:
        """Return a goal of any action.

        Raises:
            NotFound: There is no such goal.
        """
        goal = self.actions.goal(goal_id) or await self.history.get(goal_id)
        if goal is None:
            raise NotFound(f"there is no goal {goal_id}", code="goal_not_found")
        return goal

    async def page(
        self, wanted: GoalFilter, limit: int = 50, before: str | None = None
    ) -> tuple[list[Goal], str | None]:
        """Return a page of goals, newest first, and the cursor of the next page.

        Raises:
            InvalidField: There is no goal `before`.
        """
        goals = await self.history.page(wanted, limit=limit + 1, before=before)
        unknown = not goals and before is not None and self.actions.goal(before) is None
        if unknown and await self.history.get(before or "") is None:
            raise InvalidField([FieldError("cursor", "`next_cursor` of an earlier answer", "there is no such goal")])
        current = [self.actions.goal(goal.goal_id) or goal for goal in goals[:limit]]
        return current, goals[limit - 1].goal_id if len(goals) > limit else None

    async def cancel(self, goal_id: str) -> Goal:
        """Ask the action server to cancel a goal of any action, regardless of its sender.

        Raises:
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
            named = event_filter.action_name
            dock, undock = (server.action_name for server in self.servers_of(event_filter.robot))
            for name in dict.fromkeys((named, named or dock, named or undock)):
                wanted = GoalFilter(frozenset() if name is None else frozenset({name}), event_filter.namespace)
                newest += await self.history.page(wanted, limit=RECENT)
        known = [*newest, *self.actions.running()]
        goals = {goal.goal_id: goal for goal in known if event_filter.covers_goal(goal.goal_id, goal.action_name)}
        return sorted(goals.values(), key=lambda goal: goal.created_at, reverse=True)

    def say_goodbye(self) -> None:
        """End every stream and every wait, as the gateway is about to close."""
        self.hub.close()
        self.actions.each(lambda action: action.tracker.release_all())


@asynccontextmanager
async def open_gateway(settings: Settings) -> AsyncIterator[Gateway]:
    """Open the history, join the ROS graph and run the gateway until the block ends."""
    async with AsyncExitStack() as stack:
        history = await stack.enter_async_context(open_history(settings))
        audit = _closed_by(stack, AuditLog(history.audit))
        audit.open()
        yield await _open(settings, history, audit, stack)


async def _open(settings: Settings, history: History, audit: AuditLog, stack: AsyncExitStack) -> Gateway:
    """Make every part, and register it with the stack for closing."""
    hub = Hub(
        queue_limit=settings.subscriber_queue,
        max_subscribers=settings.max_subscribers,
        keep=history.record_event,
        newest=history.newest,
    )
    reasons: PendingFacts[GoalError] = PendingFacts(REASON_WAIT)
    bridge = Bridge(settings.node_name, settings.namespace, settings.max_message_bytes)
    bridge.start()
    stack.push_async_callback(asyncio.to_thread, bridge.close)
    interlock = _closed_by(
        stack, Interlock(hub, LatchFile(settings.stop_file), normalize_namespace(settings.namespace))
    )
    last_goals = _closed_by(stack, LastGoals(history))
    actions = _closed_by(stack, ActionRegistry(settings, bridge, hub, history, reasons, interlock=interlock))
    actions.on_end.append(last_goals.take)
    history.on_loss = lambda: store_unfinished(actions, history)
    robots = _closed_by(stack, RobotRegistry(settings, bridge, hub, interlock, last_goals))
    stopper = _closed_by(stack, Stopper(robots, actions, interlock))
    simulators = _closed_by(stack, Simulators(settings, bridge, hub))
    activity = Activity(robots)
    actions.on_end.append(activity.on_end)
    stopper.on_stop.append(activity.intervened)
    interlock.on_release.append(activity.intervened)
    _subscribe_on_demand(settings, bridge, hub, activity, stack)
    board = _closed_by(stack, SceneBoard(hub, lambda: [robot.namespace for robot in robots.all()]))
    _listen_to_poses(settings, bridge, MapPort, board, stack)
    if settings.store_poses:
        recorder = _closed_by(stack, PoseRecorder(actions.running, robots.owner, history.record_event))
        _listen_to_poses(settings, bridge, PosePort, recorder, stack)
    graph = _closed_by(stack, GraphCache(bridge))
    echoes = _closed_by(stack, EchoRegistry(bridge, graph))
    await bridge.call(
        lambda: DiagnosticsPort(
            bridge,
            settings.diagnostics_topic,
            on_reason=reasons.put,
            on_progress=actions.on_progress,
            on_simulator=simulators.on_report,
        )
    )
    await robots.open(robots.default_namespace)
    names = settings.docking_actions()
    dock = await actions.open(names.dock, settings.dock_action_type, pinned=True)
    undock = await actions.open(names.undock, settings.undock_action_type, pinned=True)
    labels = _closed_by(stack, Labels(history.labels, lambda: [robot.namespace for robot in robots.all()]))
    await labels.open()
    decisions = DecisionLog(hub, history.automation_decisions)
    alerts = _closed_by(
        stack,
        AlertBoard(
            hub,
            SharedEntries(history.acknowledgements),
            low_battery=settings.low_battery,
            incident=lambda: history.incident,
            given_up=decisions.given_up,
        ),
    )
    fleet = _closed_by(
        stack,
        Fleet(
            settings,
            hub,
            robots=robots,
            actions=actions,
            interlock=interlock,
            simulators=simulators,
            last_goals=last_goals,
            labels=labels,
            alerts=alerts,
        ),
    )
    automation = _closed_by(
        stack,
        AutomaticDocking(
            settings,
            fleet,
            actions,
            history,
            activity=activity,
            rules=SharedBook(history.automation_rules, "rule", MAX_RULES),
            decisions=decisions,
        ),
    )
    webhooks = SharedBook(history.webhooks, "webhook", MAX_WEBHOOKS)
    outbox = Outbox(webhooks, SharedEntries(history.webhook_deliveries))
    notifier = _closed_by(stack, Notifier(alerts, labels, webhooks=webhooks, outbox=outbox))
    logins = _closed_by(stack, Logins(history))
    if settings.authentication:
        await logins.open()
    parts = Parts(settings, bridge, hub, history, actions, robots, stopper, alerts, notifier)
    metrics = _observe(parts, stack)
    departures = Departures(robots, actions, interlock, forget_after=settings.forget_robot_after)
    tasks = _closed_by(stack, Tasks("running the gateway"))
    tasks.spawn(_watch_graph(bridge, actions, robots, departures))
    tasks.spawn(take_over_unfinished(actions, history))
    stack.callback(hub.close)
    return Gateway(
        settings,
        bridge,
        hub,
        history,
        actions,
        robots,
        stopper,
        simulators,
        fleet,
        labels,
        alerts,
        automation,
        notifier,
        logins,
        Tickets(),
        Quotas(settings),
        audit,
        graph,
        echoes,
        metrics,
        dock,
        undock,
    )


class _Part(Protocol):
    async def close(self) -> None: ...


PartT = TypeVar("PartT", bound=_Part)


def _closed_by(stack: AsyncExitStack, part: PartT) -> PartT:
    stack.push_async_callback(part.close)
    return part


def _observe(parts: Parts, stack: AsyncExitStack) -> Metrics:
    """Measure the parts, and trace their goals if that is configured."""
    if traces := open_traces(parts):
        _closed_by(stack, traces)
    return _closed_by(stack, Metrics(parts))


def _subscribe_on_demand(
    settings: Settings, bridge: Bridge, hub: Hub, activity: Activity, stack: AsyncExitStack
) -> None:
    """Set up the topics that are subscribed to only on demand."""

    def scene(robot: str) -> ScenePort:
        return ScenePort(bridge, robot, partial(settings.resolve, namespace=robot), hub.publish)

    def velocity(robot: str) -> VelocityListener:
        def hear(message: Json, stamp_ns: int) -> None:
            hub.publish(message_event("cmd_vel", message, hub.clock.stamp(stamp_ns), stamp_ns, robot=robot))

        return VelocityListener(bridge, settings.resolve(settings.cmd_vel_topic, robot), hear)

    def motion(robot: str) -> ExitStack:
        topic = settings.resolve(settings.cmd_vel_topic, robot)
        listener = VelocityListener(bridge, topic, lambda message, _: activity.on_velocity(robot, message))
        activity.subscribed(robot)
        port = ExitStack()
        port.callback(listener.close)
        port.callback(activity.unsubscribed, robot)
        return port

    _closed_by(stack, OnDemand(bridge, hub, "scene", scene))
    _closed_by(stack, OnDemand(bridge, hub, "cmd_vel", velocity))
    _closed_by(stack, OnDemand(bridge, activity, "motion", motion))


def _listen_to_poses(
    settings: Settings, bridge: Bridge, kind: type[PosePort], ears: PoseRecorder | SceneBoard, stack: AsyncExitStack
) -> None:
    """Subscribe to the poses of the robots that are wanted."""

    def port(robot: str) -> PosePort:
        return kind(bridge, robot, partial(settings.resolve, namespace=robot), ears.hear)

    _closed_by(stack, OnDemand(bridge, ears, "poses", port))


async def _watch_graph(bridge: Bridge, actions: ActionRegistry, robots: RobotRegistry, departures: Departures) -> None:
    """Scan the graph periodically and update actions and robots."""
    steps: tuple[Callable[[Scan], Awaitable[bool | None]], ...] = (
        actions.update,
        robots.update,
        lambda found: departures.look(found, time.monotonic()),
    )
    while True:
        more = False
        with _logged():
            found = await bridge.call(lambda: scan(bridge.node))
            for step in steps:
                with _logged():
                    more = bool(await step(found)) or more
        await asyncio.sleep(PAUSE if more else SCAN_INTERVAL)


@contextmanager
def _logged() -> Iterator[None]:
    """Log an exception instead of raising it, so that a failure does not affect the rest."""
    try:
        yield
    except GatewayError as error:
        log.warning("cannot read the ROS graph: %s", error.detail)
    except Exception:
        log.exception("while reading the ROS graph")
