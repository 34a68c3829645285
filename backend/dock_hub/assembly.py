"""Assembles the hub: makes its parts in order and closes them in reverse order. No ROS."""

import logging
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

from prometheus_client import CollectorRegistry

from dock_gateway.access.opening import open_access
from dock_gateway.audit.log import AuditLog
from dock_gateway.audit.subjects import Subjects
from dock_gateway.core.alerts import Alerts
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal
from dock_gateway.core.share import EVERYTHING, Share
from dock_gateway.core.tasks import closed_by
from dock_gateway.extension import Core, Installed
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.further_ways import FurtherWays
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.observability.metrics import Metrics
from dock_gateway.robots.robots import RobotLabels, Robots
from dock_gateway.settings import Settings
from dock_gateway.sites.broker import Broker, BrokerOptions, open_broker
from dock_gateway.sites.identity import Signer
from dock_gateway.sites.subjects import HUB, inbox
from dock_gateway.sites.tunnel.caller import Caller
from dock_gateway.storage import AuditSpool, History, open_history
from dock_gateway.streams.present import Present
from dock_gateway.streams.queries import Includes
from dock_hub.collector import HubCollector
from dock_hub.labels import SiteLabels
from dock_hub.mirror import Mirror
from dock_hub.overview import Overview
from dock_hub.settings import HubSettings
from dock_hub.shares import BY_SITE
from dock_hub.sites import Sites
from dock_hub.stop_requests import StopEntry
from dock_hub.stops import Stops
from dock_hub.store import HubStore

log = logging.getLogger(__name__)


class NoLiveGoals:
    """A hub has the goals of its history, and no others."""

    def goal(self, goal_id: str) -> Goal | None:
        """Return None."""

    def running(self) -> list[Goal]:
        """Return none."""
        return []


@asynccontextmanager
async def open_hub(settings: HubSettings, installed: Installed) -> AsyncIterator[Parts]:
    """Open the history, connect to the NATS server in the background, and run the hub until the block ends.

    Args:
        settings: The settings.
        installed: The extensions.
    """
    async with AsyncExitStack() as stack:
        history = await stack.enter_async_context(open_history(settings))
        audit = closed_by(stack, AuditLog(history.audit, AuditSpool(settings.spool_folder / "audit")))
        await audit.open()
        options = BrokerOptions(
            urls=settings.nats,
            credentials=settings.nats_credentials,
            ca=settings.nats_ca,
            name="dock-gateway-hub",
            inbox=inbox(HUB),
        )
        broker = await stack.enter_async_context(open_broker(options))
        yield await _open(settings, installed, history, audit, broker, stack)


async def _open(  # noqa: PLR0917 - one after another
    settings: HubSettings,
    installed: Installed,
    history: History,
    audit: AuditLog,
    broker: Broker,
    stack: AsyncExitStack,
) -> Parts:
    fanout = Fanout(queue_limit=settings.subscriber_queue, newest=history.newest)
    signer = Signer.load_or_create(settings.hub_key_file)
    caller = Caller(broker)
    await caller.open()
    stack.push_async_callback(caller.close)
    store = closed_by(stack, HubStore(Mirror(history), fanout))
    sites = closed_by(stack, Sites(broker, caller, signer, history, store))
    stops = closed_by(stack, Stops(sites, history.documents("stop", StopEntry)))
    sites.pending_stop = stops.pending
    labels = SiteLabels(sites)
    robot_actions = RobotActions(settings, sites, labels, history)
    goals = Goals(NoLiveGoals(), robot_actions, history)
    overview = closed_by(stack, Overview(fanout, sites, goals, history))
    history.on_loss = sites.read_again
    history.retention.goals_by_size = BY_SITE
    parts = Parts(
        {
            Settings: settings,
            Installed: installed,
            Fanout: fanout,
            History: history,
            Broker: broker,
            Sites: sites,
            Stops: stops,
            Overview: overview,
            Robots: overview,
            Alerts: overview,
            Present: overview,
            Goals: goals,
            RobotActions: robot_actions,
            RobotLabels: labels,
            Share: EVERYTHING,
            FurtherWays: FurtherWays(),
            Includes: Includes(),
            Quotas: Quotas(settings),
            AuditLog: audit,
            Subjects: Subjects(settings, lambda _: None, overview.namespaces),
        }
    )
    await open_access(parts, stack)
    core = Core(settings, history, fanout, overview, labels, EVERYTHING, audit)
    await installed.open(core, parts, stack)
    overview.sources.append(installed.alerts)
    parts.add(Metrics, closed_by(stack, Metrics(HubCollector(parts, installed.metrics), CollectorRegistry())))
    stops.open()
    await sites.open()
    stack.callback(fanout.close)
    return parts
