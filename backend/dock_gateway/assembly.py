"""Assembles the gateway: makes its parts in order and closes them in reverse order."""

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Sequence
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager, contextmanager
from functools import partial

from prometheus_client import CollectorRegistry

from dock_gateway.access.logins import Logins
from dock_gateway.access.single_sign_on import open_single_sign_on
from dock_gateway.access.tickets import Tickets
from dock_gateway.audit.log import AuditLog
from dock_gateway.audit.subjects import Subjects
from dock_gateway.core.alerts import Alerts
from dock_gateway.core.dock_adapters.catalog import DockingCatalog
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import message_event, system_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import GoalError, Json
from dock_gateway.core.own_topics import OwnTopics
from dock_gateway.core.share import Claim, Share
from dock_gateway.core.tasks import PendingFacts, Tasks, closed_by
from dock_gateway.core.work import Work, in_turn
from dock_gateway.extension import Extension, GatewayCore, extensions, open_extensions
from dock_gateway.fleet.alert import Acknowledgement
from dock_gateway.fleet.alerts import AlertBoard
from dock_gateway.fleet.departures import Departures
from dock_gateway.fleet.findings import claimed_twice
from dock_gateway.fleet.graph_watch import GraphWatch
from dock_gateway.fleet.overview import Fleet
from dock_gateway.fleet.pose_recorder import PoseRecorder
from dock_gateway.fleet.scene_board import SceneBoard
from dock_gateway.fleet.wheels_watch import WheelsWatch
from dock_gateway.gateways.claims import Gateways
from dock_gateway.gateways.machine import own_address
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.goals.unfinished import store_unfinished, take_over_unfinished
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.parameters import Parameters
from dock_gateway.graph.publishing import Publishing
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.service_calls import ServiceCalls
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Limit, Quotas
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.observability.collector import Further
from dock_gateway.observability.gateway_collector import GatewayCollector
from dock_gateway.observability.goal_metrics import GoalMetrics
from dock_gateway.observability.metrics import Metrics
from dock_gateway.robots.calibration import Calibrations
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.robots.last_goals import LastGoals
from dock_gateway.robots.on_demand import OnDemand
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.robots import RobotLabels, Robots
from dock_gateway.robots.simulator import Simulators
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import Scan, read_topic, scan
from dock_gateway.ros.robot_ports import DiagnosticsPort
from dock_gateway.ros.scene_port import MapPort, PosePort, ScenePort
from dock_gateway.ros.velocity import VelocityListener
from dock_gateway.settings import Settings
from dock_gateway.stop.stop_of_all import StopOfAll
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import AuditSpool, History, open_history
from dock_gateway.storage.database import display
from dock_gateway.storage.shared_entries import SharedEntries
from dock_gateway.streams.gateway_present import GatewayPresent
from dock_gateway.streams.present import Present
from dock_gateway.streams.queries import Includes

log = logging.getLogger(__name__)

# Seconds between two scans of the graph, and between two scans while something on it is still to be registered.
SCAN_INTERVAL, PAUSE = 1.0, 0.1
# Seconds that a rejected or aborted goal waits for the server's reason.
REASON_WAIT = 0.3


@asynccontextmanager
async def open_gateway(
    settings: Settings, installed: Sequence[Extension[GatewayCore]] | None = None, limits: GoalLimits = LIMITS
) -> AsyncIterator[Parts]:
    """Open the history, join the ROS graph and run the gateway until the block ends.

    Args:
        settings: The settings.
        installed: The extensions; default: all.
        limits: How long goals wait.
    """
    async with AsyncExitStack() as stack:
        history = await stack.enter_async_context(open_history(settings))
        spool = None if settings.database_url == "memory:" else AuditSpool(settings.spool_folder / "audit")
        audit = closed_by(stack, AuditLog(history.audit, spool))
        await audit.open()
        yield await _open(settings, extensions() if installed is None else installed, history, audit, stack, limits)


async def _open(  # noqa: PLR0917 - one after another
    settings: Settings,
    installed: Sequence[Extension[GatewayCore]],
    history: History,
    audit: AuditLog,
    stack: AsyncExitStack,
    limits: GoalLimits,
) -> Parts:
    """Make every part, and register it with the stack for closing."""
    share, gateways = await _claim_robots(settings, history, stack)  # before anything of a robot is touched
    fanout = _make_fanout(settings, history)
    reasons: PendingFacts[GoalError] = PendingFacts(REASON_WAIT)
    bridge = Bridge(settings.node_name, settings.namespace, settings.max_message_bytes, own_topics=OwnTopics(settings))
    bridge.start()
    stack.push_async_callback(asyncio.to_thread, bridge.close)
    interlock = closed_by(stack, _make_interlock(settings, fanout))
    last_goals = closed_by(stack, LastGoals(history))
    robots = closed_by(stack, RobotRegistry(settings, bridge, fanout, interlock, last_goals, share=share))
    gateways.robots = robots.namespaces
    labels, robot_actions = await _map_actions(settings, history, robots, stack)
    actions = closed_by(
        stack,
        ActionRegistry(
            settings,
            bridge,
            fanout,
            history,
            reasons,
            interlock=interlock,
            robots=robots,
            robot_actions=robot_actions,
            share=share,
            limits=limits,
        ),
    )
    history.on_loss = lambda: store_unfinished(actions, history)
    _follow_docking(actions, robot_actions, last_goals, fanout)
    stopper = closed_by(stack, Stopper(robots, actions, interlock, share=share))
    simulators = closed_by(stack, Simulators(settings, bridge, fanout, robots))
    approvals = closed_by(stack, _make_approvals(settings, fanout, actions, simulators))
    stopper.on_stop.append(approvals.drop)
    interlock.on_latch.append(approvals.drop)
    _subscribe_on_demand(settings, bridge, fanout, robots, stack)
    wheels_watch = closed_by(stack, _watch_wheels(settings, bridge, actions, robots, stack))
    board = closed_by(stack, SceneBoard(fanout, robots.namespaces))
    _listen_to_poses(settings, robots, MapPort, board, stack)
    if settings.store_poses:
        recorder = closed_by(stack, PoseRecorder(actions.running, robots.owner, history.record_event))
        _listen_to_poses(settings, robots, PosePort, recorder, stack)
    graph, relays, work = _read_topics(bridge, stack)
    publishing = closed_by(stack, _make_publishing(settings, bridge, interlock, stopper))
    await bridge.call(
        lambda: DiagnosticsPort(
            robots.topics,
            settings.diagnostics_topic,
            stop_topic=settings.resolve(settings.stop_topic),
            on_reason=reasons.put,
            on_progress=actions.on_progress,
            on_simulator=simulators.on_report,
        )
    )
    stop_of_all = closed_by(stack, StopOfAll(settings, robots, interlock, stopper))
    graph_watch = _make_graph_watch(settings, bridge, robots, actions, robot_actions)
    alerts = closed_by(
        stack,
        AlertBoard(
            fanout,
            SharedEntries(history.documents("acknowledgement", Acknowledgement)),
            low_battery=settings.low_battery,
            incident=lambda: history.incident,
            findings=lambda: [*graph_watch.findings, *claimed_twice(gateways.conflict), *wheels_watch.findings],
            only=robots.namespaces if share.limited else None,
        ),
    )
    hints = DockingHints(settings, actions, robots)
    fleet = closed_by(
        stack,
        Fleet(
            settings,
            fanout,
            robots=robots,
            actions=actions,
            robot_actions=robot_actions,
            hints=hints,
            interlock=interlock,
            simulators=simulators,
            last_goals=last_goals,
            labels=labels,
            alerts=alerts,
        ),
    )
    logins = closed_by(stack, Logins(history, open_single_sign_on(settings), display(settings.database)))
    if settings.authentication:
        await logins.open()
    parts = Parts(
        {
            Settings: settings,
            Bridge: bridge,
            Fanout: fanout,
            History: history,
            ActionRegistry: actions,
            RobotActions: robot_actions,
            Approvals: approvals,
            DockingHints: hints,
            Goals: Goals(actions, robot_actions, history),
            Docks: closed_by(stack, Docks(settings, bridge)),
            Share: share,
            Gateways: gateways,
            Robots: robots,
            RobotRegistry: robots,
            Labels: labels,
            RobotLabels: labels,
            Simulators: simulators,
            Calibrations: Calibrations(settings, bridge),
            Stopper: stopper,
            Fleet: fleet,
            Alerts: alerts,
            AlertBoard: alerts,
            Logins: logins,
            Tickets: Tickets(),
            Quotas: Quotas(settings, _limits(settings, installed)),
            Includes: Includes(topic for extension in installed for topic in extension.includes),
            Interlock: interlock,
            GraphWatch: graph_watch,
            AuditLog: audit,
            Subjects: Subjects(settings, actions.action_of, robots.namespaces),
            GraphCache: graph,
            Relays: relays,
            Work: work,
            ServiceCalls: closed_by(stack, ServiceCalls(settings, bridge, interlock)),
            Parameters: closed_by(stack, Parameters(settings, bridge)),
            Publishing: publishing,
        }
    )
    parts.add(Present, GatewayPresent(parts))
    core = GatewayCore(settings, history, fanout, alerts, parts, robots, actions, graph, relays, stopper)
    opened = await open_extensions(installed, core, stack)
    alerts.sources.append(lambda: opened.failed)
    alerts.kinds.update(kind for extension in installed for kind in extension.alerts)
    _observe(parts, opened.metrics, stack)
    await _open_robots(robots, actions, share, stop_of_all)
    tasks = closed_by(stack, Tasks("running the gateway"))
    tasks.spawn(
        _watch_graph(
            bridge,
            actions.update,
            robots.update,
            lambda found: robots.velocities.update(found.topics),
            lambda found: robots.topics.update(found.topics),
            graph_watch.update,
            robots.scanned,
            _following(
                Departures(
                    robots,
                    actions,
                    robot_actions,
                    interlock,
                    last_goals,
                    forget_after=settings.forget_robot_after,
                )
            ),
        )
    )
    tasks.spawn(take_over_unfinished(actions, history))
    stack.callback(fanout.close)
    return parts


def _limits(settings: Settings, installed: Sequence[Extension[GatewayCore]]) -> dict[str, Limit]:
    """Return what users share of extensions."""
    return {name: limit for extension in installed for name, limit in extension.limits(settings).items()}


def _watch_wheels(
    settings: Settings, bridge: Bridge, actions: ActionRegistry, robots: RobotRegistry, stack: AsyncExitStack
) -> WheelsWatch:
    """Make what stops robots whose commands end."""

    async def name(robot: str, publisher: bytes) -> str | None:
        topic = settings.resolve(settings.cmd_vel_topic, robot)
        found = await bridge.call(lambda: read_topic(bridge.node, topic))
        return next((each.node for each in found.publishers if each.gid == publisher), None)

    def listen(robot: str) -> ExitStack:
        wheels = robots.get(robot).velocity
        wheels.listen()
        listener = robots.velocities.watch(settings.resolve(settings.cmd_vel_topic, robot), wheels.hear)
        wheels.catch_up = listener.catch_up
        port = ExitStack()
        port.callback(listener.close)
        port.callback(wheels.stop_listening)
        return port

    watch = WheelsWatch(actions, robots, name, settings.command_timeout)
    closed_by(stack, OnDemand(bridge, watch, "commands", listen))
    return watch


async def _claim_robots(settings: Settings, history: History, stack: AsyncExitStack) -> tuple[Share, Gateways]:
    share = Share(settings.robots, DockingCatalog(settings).homes)
    address = own_address(settings, settings.port)
    gateways = Gateways(history.documents("gateway", Claim), share, address, shared=history.shared)
    await gateways.open()
    return share, closed_by(stack, gateways)


async def _open_robots(robots: RobotRegistry, actions: ActionRegistry, share: Share, stop_of_all: StopOfAll) -> None:
    """Join the topics and docking actions of the configured robot, which need not be there yet, and the stop of all."""
    if share.covers_robot(robots.default_namespace):
        await robots.open(robots.default_namespace)
        await actions.pin("dock")
        await actions.pin("undock")
    await stop_of_all.open()


async def _map_actions(
    settings: Settings, history: History, robots: RobotRegistry, stack: AsyncExitStack
) -> tuple[Labels, RobotActions]:
    """Open the labels of robots, and make what maps robots to their actions."""
    labels = closed_by(stack, Labels(history.documents("label", RobotLabel), robots.namespaces))
    await labels.open()
    return labels, RobotActions(settings, robots, labels, history)


def _make_fanout(settings: Settings, history: History) -> Fanout:
    """Make the fan-out, which publishes in the order of all gateways that share the history."""
    fanout = Fanout(
        queue_limit=settings.subscriber_queue,
        keep=history.record_event,
        newest=history.newest,
    )
    fanout.line.on_want = history.follow(fanout.line.allow)
    return fanout


def _make_interlock(settings: Settings, fanout: Fanout) -> Interlock:
    catalog = DockingCatalog(settings)
    return Interlock(fanout, LatchFile(settings.stop_file), catalog.shared, catalog.homes)


def _make_publishing(settings: Settings, bridge: Bridge, interlock: Interlock, stopper: Stopper) -> Publishing:
    """Make what publishes for clients; it leaves the topics of a robot as soon as that is stopped."""
    publishing = Publishing(settings, bridge, interlock)
    stopper.on_stop.append(publishing.withdraw)
    interlock.on_latch.append(publishing.withdraw)
    return publishing


def _read_topics(bridge: Bridge, stack: AsyncExitStack) -> tuple[GraphCache, Relays, Work]:
    """Make what reads the graph, and the messages of any topic, and what decodes them."""
    stack.push_async_callback(in_turn.close)
    graph, work = closed_by(stack, GraphCache(bridge)), closed_by(stack, Work())
    return graph, closed_by(stack, Relays(bridge, graph, work)), work


def _make_graph_watch(
    settings: Settings, bridge: Bridge, robots: RobotRegistry, actions: ActionRegistry, robot_actions: RobotActions
) -> GraphWatch:
    """Watch the graph for mistakes, which are also named where a goal is aborted because of them."""
    watch = GraphWatch(settings, bridge, robots, robot_actions)
    actions.remark = watch.remark
    return watch


def _make_approvals(settings: Settings, fanout: Fanout, actions: ActionRegistry, simulators: Simulators) -> Approvals:
    """Make what the goals of agents wait for."""
    approvals = Approvals(settings, fanout, actions.verb_of, simulators.__contains__)
    actions.before_send.append(approvals.require)
    return approvals


def _follow_docking(
    actions: ActionRegistry, robot_actions: RobotActions, last_goals: LastGoals, fanout: Fanout
) -> None:
    """Note and publish which actions dock and undock a robot, whenever that changes."""

    def changed(robot: str) -> None:
        last_goals.watch(*robot_actions.docking_pair(robot))
        fanout.publish(system_event("docking", actions.servers_of(robot)._asdict(), utc_now(), robot=robot))

    robot_actions.on_change.append(changed)
    actions.on_end.append(last_goals.take)


def _observe(parts: Parts, further: Further, stack: AsyncExitStack) -> None:
    """Measure the parts."""
    registry = CollectorRegistry()
    GoalMetrics(registry, parts)
    parts.add(Metrics, closed_by(stack, Metrics(GatewayCollector(parts, further), registry)))


def _subscribe_on_demand(
    settings: Settings, bridge: Bridge, fanout: Fanout, robots: RobotRegistry, stack: AsyncExitStack
) -> None:
    """Set up the topics that are subscribed to only on demand."""

    def scene(robot: str) -> ScenePort:
        resolve = partial(settings.resolve, namespace=robot)
        return ScenePort(robots.topics, robot, resolve, fanout.publish, stop_topic=resolve(settings.stop_topic))

    def velocity(robot: str) -> VelocityListener:
        def hear(message: Json, stamp_ns: int) -> None:
            fanout.publish(message_event("cmd_vel", message, fanout.clock.stamp(stamp_ns), stamp_ns, robot=robot))

        return robots.velocities.listen(settings.resolve(settings.cmd_vel_topic, robot), hear)

    closed_by(stack, OnDemand(bridge, fanout, "scene", scene))
    closed_by(stack, OnDemand(bridge, fanout, "cmd_vel", velocity))


def _listen_to_poses(
    settings: Settings,
    robots: RobotRegistry,
    kind: type[PosePort],
    hearers: PoseRecorder | SceneBoard,
    stack: AsyncExitStack,
) -> None:
    """Subscribe to the poses of the robots that are wanted."""

    def port(robot: str) -> PosePort:
        resolve = partial(settings.resolve, namespace=robot)
        return kind(robots.topics, robot, resolve, hearers.hear, stop_topic=resolve(settings.stop_topic))

    closed_by(stack, OnDemand(robots.topics.bridge, hearers, "poses", port))


async def _watch_graph(bridge: Bridge, *steps: Callable[[Scan], Awaitable[bool | None]]) -> None:
    """Scan the graph periodically, and tell those who follow it."""
    while True:
        more = False
        with _logged():
            found = await bridge.call(lambda: scan(bridge.node))
            for step in steps:
                with _logged():
                    more = bool(await step(found)) or more
        await asyncio.sleep(PAUSE if more else SCAN_INTERVAL)


def _following(departures: Departures) -> Callable[[Scan], Awaitable[None]]:
    return lambda found: departures.check(found, time.monotonic())


@contextmanager
def _logged() -> Iterator[None]:
    """Log an exception instead of raising it, so that a failure does not affect the rest."""
    try:
        yield
    except GatewayError as error:
        log.warning("cannot read the ROS graph: %s", error.detail)
    except Exception:
        log.exception("while reading the ROS graph")
