"""Assembles the gateway: opens its features in order and closes them in reverse order."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

from prometheus_client import CollectorRegistry

from dock_gateway.access.opening import open_access
from dock_gateway.audit.record import RequestRecord
from dock_gateway.audit.subjects import Subjects
from dock_gateway.core.dock_adapters.catalog import DockingCatalog
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.own_topics import OwnTopics
from dock_gateway.core.share import Claim, Share
from dock_gateway.core.tasks import Tasks, closed_by
from dock_gateway.extension import Installed
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.graph_scan import scan_graph
from dock_gateway.fleet.opening import open_fleet
from dock_gateway.gateways.gateways import Gateways
from dock_gateway.gateways.machine import own_address
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.goals.opening import open_goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.unfinished import take_over_unfinished
from dock_gateway.graph.opening import open_graph
from dock_gateway.http.further_ways import FurtherWays
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.observability.gateway_collector import GatewayCollector
from dock_gateway.observability.goal_metrics import GoalMetrics
from dock_gateway.observability.metrics import Metrics
from dock_gateway.robots.opening import open_robots
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings
from dock_gateway.stop.opening import open_stop
from dock_gateway.stop.stop_of_all import StopOfAll
from dock_gateway.storage import History, open_history
from dock_gateway.streams.current_state import CurrentState
from dock_gateway.streams.gateway_state import GatewayState
from dock_gateway.streams.includes import Includes


@asynccontextmanager
async def open_gateway(settings: Settings, installed: Installed, limits: GoalLimits = LIMITS) -> AsyncIterator[Parts]:
    """Open the history, join the ROS graph and run the gateway until the block ends.

    Args:
        settings: The settings.
        installed: The extensions.
        limits: How long goals wait.
    """
    parts = Parts({Settings: settings, Installed: installed, GoalLimits: limits})
    async with AsyncExitStack() as stack:
        parts.add(History, await stack.enter_async_context(open_history(settings)))
        stack.callback(parts.add(RequestRecord, RequestRecord()).end_period)
        await _claim_robots(parts, stack)  # before anything of a robot is touched
        _join_ros(parts, stack)
        await open_robots(parts, stack)
        parts[Gateways].robots = parts[RobotRegistry].namespaces
        await open_goals(parts, stack)
        open_graph(parts, stack)
        open_stop(parts, stack)
        open_fleet(parts, stack)
        await open_access(parts, stack)
        parts.add(Subjects, Subjects(settings, parts[ActionRegistry].action_of, parts[RobotRegistry].namespaces))
        parts.add(CurrentState, GatewayState(parts))
        parts.add(FurtherWays, FurtherWays())
        await _open_extensions(parts, stack)
        await _begin(parts, stack)
        yield parts


async def _claim_robots(parts: Parts, stack: AsyncExitStack) -> None:
    settings, history = parts[Settings], parts[History]
    share = parts.add(Share, Share(settings.serve_robots, DockingCatalog(settings).homes))
    address = own_address(settings, settings.port)
    gateways = Gateways(history.documents("gateway", Claim), share, address, shared=history.shared)
    await gateways.open()
    parts.add(Gateways, closed_by(stack, gateways))


def _join_ros(parts: Parts, stack: AsyncExitStack) -> None:
    """Join the ROS graph, and make what publishes events in the order of all gateways that share the history."""
    settings, history, catalog = parts[Settings], parts[History], DockingCatalog(parts[Settings])
    fanout = Fanout(queue_limit=settings.subscriber_queue, keep=history.record_event, newest=history.newest)
    fanout.line.on_want.append(history.follow(fanout.line.allow))
    parts.add(Fanout, fanout)
    bridge = Bridge(settings.node_name, settings.namespace, settings.max_message_bytes, own_topics=OwnTopics(settings))
    bridge.start()
    stack.push_async_callback(asyncio.to_thread, bridge.close)
    parts.add(Bridge, bridge)
    interlock = Interlock(fanout, LatchFile(settings.stop_file), catalog.shared, catalog.homes)
    parts.add(Interlock, closed_by(stack, interlock))


async def _open_extensions(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the extensions, with what users share of them and what measures them."""
    settings, installed, alerts = parts[Settings], parts[Installed], parts[AlertBoard]
    parts.add(Quotas, Quotas(settings, installed.limits(settings)))
    parts.add(Includes, Includes(installed.events))
    await installed.open(parts, stack)
    alerts.sources.append(installed.alerts)
    alerts.kinds.update(installed.kinds)
    registry = CollectorRegistry()
    GoalMetrics(registry, parts)
    parts.add(Metrics, closed_by(stack, Metrics(GatewayCollector(parts, installed.metrics), registry)))


async def _begin(parts: Parts, stack: AsyncExitStack) -> None:
    """Join the topics and docking actions of the configured robot, which need not be there yet, and scan the graph."""
    robots, actions = parts[RobotRegistry], parts[ActionRegistry]
    if parts[Share].covers_robot(robots.default_namespace):
        await robots.open(robots.default_namespace)
        await actions.pin("dock")
        await actions.pin("undock")
    await parts[StopOfAll].open()
    tasks = closed_by(stack, Tasks("running the gateway"))
    tasks.spawn(scan_graph(parts))
    tasks.spawn(take_over_unfinished(actions, parts[History]))
    stack.callback(parts[Fanout].close)
