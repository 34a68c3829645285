"""Assembles the hub: makes its parts in order and closes them in reverse order. No ROS."""

from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

from prometheus_client import CollectorRegistry

from dock_gateway.access.opening import open_access
from dock_gateway.audit.record import RequestRecord
from dock_gateway.audit.subjects import Subjects
from dock_gateway.core.alerts import Alerts
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal
from dock_gateway.core.grant import Grant
from dock_gateway.core.share import EVERYTHING, Share
from dock_gateway.core.tasks import closed_by
from dock_gateway.extension import Installed
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.known_robots import KnownRobots
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
from dock_gateway.storage import History, open_history
from dock_gateway.streams.current_state import CurrentState
from dock_gateway.streams.includes import Includes
from dock_hub.collector import HubCollector
from dock_hub.labels import SiteLabels
from dock_hub.limits import hub_limits
from dock_hub.mirror import Mirror
from dock_hub.overview import Overview
from dock_hub.schema import GOAL_FIELDS, INCLUDES, SitesEvent
from dock_hub.settings import HubSettings
from dock_hub.shares import BY_SITE
from dock_hub.sites import Sites
from dock_hub.stop_requests import StopEntry
from dock_hub.stops import Stops
from dock_hub.store import HubStore


class NoLiveGoals:
    """A hub has the goals of its history, and no others."""

    def goal(self, goal_id: str) -> Goal | None:
        """Return None."""

    def running(self) -> list[Goal]:
        """Return none."""
        return []


class SiteGoalDocuments(GoalDocuments):
    """Makes the documents of goals without their tags, notes and recordings, which only their sites have."""

    async def full(self, goals: Sequence[Goal], grant: Grant) -> list[dict[str, Any]]:
        """Return goals; the fields for all that is not known here are null."""
        return [self.brief(goal) for goal in goals]


@asynccontextmanager
async def open_hub(settings: HubSettings, installed: Installed) -> AsyncIterator[Parts]:
    """Open the history, connect to the NATS server in the background, and run the hub until the block ends.

    Args:
        settings: The settings.
        installed: The extensions.
    """
    parts = Parts({Settings: settings, Installed: installed, Share: EVERYTHING, FurtherWays: FurtherWays()})
    async with AsyncExitStack() as stack:
        parts.add(History, await stack.enter_async_context(open_history(settings)))
        stack.callback(parts.add(RequestRecord, RequestRecord()).end_period)
        await _connect(settings, parts, stack)
        _open_sites(settings, parts, stack)
        _open_overview(settings, parts, stack)
        await open_access(parts, stack)
        parts.add(Subjects, Subjects(settings, lambda _: None, parts[Overview].namespaces))
        await _open_extensions(parts, stack)
        parts[Stops].open()
        await parts[Sites].open()
        stack.callback(parts[Fanout].close)
        yield parts


async def _connect(settings: HubSettings, parts: Parts, stack: AsyncExitStack) -> None:
    """Connect to the NATS server, and be ready to call sites over it."""
    options = BrokerOptions(
        urls=settings.nats,
        credentials=settings.nats_credentials,
        ca=settings.nats_ca,
        name="dock-gateway-hub",
        inbox=inbox(HUB),
    )
    broker = parts.add(Broker, await stack.enter_async_context(open_broker(options)))
    caller = parts.add(Caller, Caller(broker))
    await caller.open()
    stack.push_async_callback(caller.close)


def _open_sites(settings: HubSettings, parts: Parts, stack: AsyncExitStack) -> None:
    """Open what is known of the sites, and their stops."""
    history = parts[History]
    fanout = parts.add(Fanout, Fanout(queue_limit=settings.subscriber_queue, newest=history.newest))
    store = closed_by(stack, HubStore(Mirror(history), fanout))
    signer = Signer.load_or_create(settings.hub_key_file)
    sites = parts.add(Sites, closed_by(stack, Sites(parts[Broker], parts[Caller], signer, history, store)))
    stops = parts.add(Stops, closed_by(stack, Stops(sites, history.documents("stop", StopEntry))))
    sites.pending_stop = stops.pending
    history.on_loss.append(sites.read_again)
    history.retention.goals_by_size = BY_SITE


def _open_overview(settings: HubSettings, parts: Parts, stack: AsyncExitStack) -> None:
    """Open what spans the sites: labels, goals, robots and alerts."""
    history, sites = parts[History], parts[Sites]
    labels = parts.add(RobotLabels, SiteLabels(sites))
    robot_actions = parts.add(RobotActions, RobotActions(settings, sites, labels, history))
    goals = parts.add(Goals, Goals(NoLiveGoals(), robot_actions, history))
    documents = parts.add(GoalDocuments, SiteGoalDocuments(history))
    documents.fields |= dict.fromkeys(GOAL_FIELDS)
    overview = parts.add(Overview, closed_by(stack, Overview(parts[Fanout], sites, goals, history)))
    parts.add(Robots, overview)
    parts.add(KnownRobots, KnownRobots(settings, overview, labels, robot_actions, history))
    parts.add(Alerts, overview)
    parts.add(CurrentState, overview)


async def _open_extensions(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the extensions, with what measures them."""
    installed = parts[Installed]
    parts.add(Quotas, Quotas(parts[Settings], hub_limits(parts[Settings])))
    parts.add(Includes, Includes((SitesEvent,), also=INCLUDES))
    await installed.open(parts, stack)
    parts[Overview].sources.append(installed.alerts)
    parts.add(Metrics, closed_by(stack, Metrics(HubCollector(parts, installed.metrics), CollectorRegistry())))
