"""The latest robots and alerts of all sites, and the hub's alerts about its sites."""

import asyncio
import logging
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from typing import Any

import orjson

from dock_gateway.core.alerts import SETTLED_AFTER
from dock_gateway.core.errors import NotFound, not_covered
from dock_gateway.core.event import Event, Narrow, fleet_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter, is_under
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.listeners import Hooks, Listeners
from dock_gateway.core.namespace import read_namespace
from dock_gateway.core.narrowing import narrow_alerts, narrow_approvals, narrow_robots
from dock_gateway.core.tasks import Tasks
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.acknowledgements import acknowledge
from dock_gateway.fleet.alert import Acknowledgement, Alert
from dock_gateway.goals.goals import Goals
from dock_gateway.sites.names import site_grant
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SYNC_INTERVAL, SharedEntries
from dock_gateway.streams.current_state import snapshot_of
from dock_hub.directory import SILENT_AFTER, SiteState
from dock_hub.sites import Sites

log = logging.getLogger(__name__)

# Seconds between two publications of what has changed.
INTERVAL = 0.2
# Bytes of robots of one site in a publication: a site whose robots change all the time is not all that readers get.
MAX_PUBLISHED = 512 * 1024
# The fields of a site that change all the time. A change of the others is published.
RESTLESS = frozenset({"lag_ms", "round_trip_ms", "clock_offset_s", "cursor"})
Document = dict[str, Any]
NO_STOP: Document = {"latched": False, "stopped_at": None, "by": None, "robots": [], "persisted": True}
NO_SERVER: Document = {"action_name": "", "action_type": "", "available": False, "answering": False, "duplicate": False}
# A hub has the batteries of robots in `robots`, and publishes none.
NO_BATTERY: Document = {
    "state": None,
    "percentage": None,
    "implausible": [],
    "stale": True,
    "stale_after_s": 0.0,
    "low_below": 0.0,
    "received_at": None,
}
NO_PUBLISHER: Document = {
    "active": False,
    "state": None,
    "rate_hz": None,
    "published_count": 0,
    "started_at": None,
}


class Overview:
    """The robots, the alerts and the snapshot of all sites of a hub.

    Args:
        fanout: Receives changes, and knows the subscribers.
        sites: The sites.
        goals: Their goals.
        history: Stores the acknowledgements of the hub's own alerts, and knows whether it has lost something.

    Attributes:
        default_namespace: Every robot: a hub is set up for none.
        own_robot: False: a hub has no robot of its own.
        on_change: Called when an alert begins or ends.
        sources: Return further alerts of the hub itself, which are active.
    """

    default_namespace = "/"
    own_robot = False

    def __init__(self, fanout: Fanout, sites: Sites, goals: Goals, history: History) -> None:
        self._fanout = fanout
        self._sites = sites
        self._goals = goals
        self._history = history
        self._acknowledgements = SharedEntries(history.documents("acknowledgement", Acknowledgement))
        self._own: dict[str, Alert] = {}
        self._ids: set[str] = set()
        self._published: dict[str, bytes] = {}
        self.on_change = Listeners[[]]("an alert begins or ends")
        self.sources = Hooks[Callable[[], Iterable[Alert]]]()
        self._tasks = Tasks("updating the overview of sites")
        self._tasks.spawn(self._run())
        self._tasks.spawn(self._sync())

    async def close(self) -> None:
        """Publish nothing any longer."""
        await self._tasks.close()

    # ------------------------------------------------------------------ robots

    def namespaces(self) -> list[str]:
        """Return the namespaces of all robots, sorted."""
        return self._sites.namespaces()

    def find(self, namespace: str | None = None) -> str:
        """Return the namespace of a robot, or of robots: `/berlin`.

        Raises:
            NotFound: `robot_not_found`.
        """
        name = "/" if namespace is None else read_namespace(namespace)
        known = name == "/" or any(is_under(each, name) for each in self.namespaces())
        if not known and name[1:].partition("/")[0] not in self._sites.names():
            raise NotFound(f"there is no robot {name}", code="robot_not_found")
        return name

    def robots(self, grant: Grant = UNLIMITED, namespace: str = "/") -> list[Document]:
        """Return the robots of a grant in a namespace, by name."""
        return [
            view.robots[name] | {"site_state": self._sites.state(view.site)}
            for view in sorted(self._sites.views(), key=lambda view: view.site)
            for name in sorted(view.robots)
            if grant.covers_robot(name) and is_under(name, namespace)
        ]

    def find_robots(self, grant: Grant, namespace: str | None) -> list[Document]:
        """Return a robot and those below it, as far as a grant covers them; all robots of a grant by default.

        Raises:
            NotFound: `robot_not_found`.
            NotAllowed: The grant covers none of them (`not_allowed`).
        """
        name = self.find(namespace)
        robots = self.robots(grant, name)
        if namespace is not None and not robots and not grant.covers_robot(name):
            raise not_covered(f"the robot {name}")
        return robots

    def approvals(self, grant: Grant = UNLIMITED) -> list[Document]:
        """Return the goals of agents that wait at sites for a person."""
        waiting = (each for view in self._sites.views() for each in view.approvals)
        return [each for each in waiting if grant.covers_action(each["action_name"])]

    # ------------------------------------------------------------------ alerts

    def documents(self, grant: Grant = UNLIMITED) -> list[Document]:
        """Return the alerts of a grant: critical ones first, then oldest first."""
        found = [alert for view in self._sites.views() for alert in view.alerts]
        found += [self._document(alert) for alert in self._own.values()]
        covered = [alert for alert in found if grant.covers_alert(alert["robot"])]
        return sorted(
            covered, key=lambda alert: (alert["severity"] != "critical", _text(alert["started_at"]), alert["id"])
        )

    def get(self, alert_id: str, grant: Grant = UNLIMITED) -> Document:
        """Return an alert.

        Raises:
            NotFound: There is none, or the grant does not cover it (`alert_not_found`).
        """
        alert = next((each for each in self.documents(grant) if each["id"] == alert_id), None)
        if alert is None:
            raise NotFound(f"there is no alert {alert_id[:60]}; it may have cleared", code="alert_not_found")
        return alert

    def is_own(self, alert_id: str) -> bool:
        """Return whether an alert is one of the hub itself, and not of a site."""
        return alert_id in self._own

    async def acknowledge(self, alert_id: str, by: str | None, condition: Condition = UNCONDITIONAL) -> Document:
        """Acknowledge an alert of the hub itself, or withdraw that with None; return the alert.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            Unavailable: There is a condition, and the history does not answer (`history_unavailable`).
        """
        alert = self._own[alert_id]
        acknowledgement = None if by is None else Acknowledgement(by, utc_now())
        await acknowledge(self._acknowledgements, alert, acknowledgement, condition)
        self._publish_alerts()
        return self._document(alert)

    def _document(self, alert: Alert) -> Document:
        site = None if alert.robot is None else alert.robot[1:]
        return alert.document(self._acknowledgements.get(alert.id)) | {"site": site}

    def _check(self) -> None:
        own = [alert for source in self.sources for alert in source()]
        if (incident := self._history.incident) is not None:
            own.append(Alert(alert_kinds.HISTORY_LOST, None, incident.since, "History lost", incident.detail))
        for name in self._sites.names():
            site, state = self._sites.find(name), self._sites.state(name)
            since = datetime.fromtimestamp(site.since, UTC)
            if state is SiteState.REFUSED:
                detail = site.detail or "It was refused."
                own.append(Alert(alert_kinds.SITE_REFUSED, f"/{name}", since, "Site refused", detail))
            elif state is SiteState.UNREACHABLE and self._sites.silent_for(name) >= SILENT_AFTER:
                detail = (
                    f"The hub does not reach {name}. Its robots go on as the site says; check that its gateway runs "
                    "and is connected to the NATS server."
                )
                own.append(Alert(alert_kinds.SITE_UNREACHABLE, f"/{name}", since, "Site unreachable", detail))
        self._own = {alert.id: alert for alert in own}

    async def _sync(self) -> None:
        """Read the acknowledgements; forget those of alerts that have not come again since the start."""
        waited = 0.0
        while True:
            answered = await self._acknowledgements.sync()
            if answered and waited >= SETTLED_AFTER:
                for ended in self._acknowledgements.keys() - self._own.keys():
                    self._acknowledgements.put(ended, None)
            await asyncio.sleep(SYNC_INTERVAL)
            waited += SYNC_INTERVAL

    # ------------------------------------------------------------------ streams

    async def snapshot(self, event_filter: EventFilter, position: str) -> Event:
        """Return recent goals; robots, alerts, approvals and sites if asked for."""
        goals = await self._goals.recent(event_filter)
        return snapshot_of(goals, self._states_of(event_filter), event_filter, position)

    def events(self, event_filter: EventFilter) -> list[Event]:
        """Return the current robots, alerts, approvals and sites that the reader wants."""
        now = utc_now()
        return [
            fleet_event(kind, now, NARROW[kind], **{kind: state}, **({"gone": []} if kind == "robots" else {}))
            for kind, state in self._states_of(event_filter).items()
            if kind in NARROW
        ]

    def _states_of(self, event_filter: EventFilter) -> Document:
        """Return the state of what a reader asked for, by the type of the events that change it."""
        grant, asked = event_filter.grant or UNLIMITED, event_filter.topics
        states: dict[str, Callable[[], Any]] = {
            "stop": lambda: stop_of(self.robots(grant, event_filter.robot)),
            "docking": lambda: servers_of(self.robots(grant, event_filter.robot), event_filter.robot),
            "battery": lambda: NO_BATTERY,
            "battery_publisher": lambda: NO_PUBLISHER,
            "simulator": lambda: None,
            "robots": lambda: self.robots(grant),
            "alerts": lambda: self.documents(grant),
            "approvals": lambda: self.approvals(grant),
            "sites": lambda: self.site_documents(grant),
        }
        if "action_server" in asked:
            asked |= {"docking"}
        return {kind: state() for kind, state in states.items() if kind in asked}

    def site_documents(self, grant: Grant = UNLIMITED) -> list[Document]:
        """Return the sites of a grant, by name."""
        return [self._sites.document(name, grant) for name in self._sites.names(grant)]

    async def _run(self) -> None:
        while True:
            await asyncio.sleep(INTERVAL)
            try:
                self._check()
                self._publish()
            except Exception:
                log.exception("while updating the overview of sites")

    def _publish(self) -> None:
        views = self._sites.views()
        ids = {alert["id"] for view in views for alert in view.alerts} | self._own.keys()
        if ids != self._ids:
            self._ids = ids
            self.on_change()
        if not any(map(self._fanout.watched, NARROW)):
            self._published.clear()
            for view in views:
                view.changed.clear()
            return
        robots: list[Document] = []
        gone: list[str] = []
        for view in views:
            state = self._sites.state(view.site)
            changed = view.take_changed(MAX_PUBLISHED)
            robots += [view.robots[name] | {"site_state": state} for name in changed if name in view.robots]
            gone += [name for name in changed if name not in view.robots]
        if robots or gone:
            self._fanout.publish(fleet_event("robots", utc_now(), narrow_robots, robots=robots, gone=gone))
        self._publish_alerts()
        self._publish_if_changed("approvals", self.approvals())
        sites = self.site_documents()
        settled = [{name: value for name, value in site.items() if name not in RESTLESS} for site in sites]
        self._publish_if_changed("sites", sites, settled)

    def _publish_alerts(self) -> None:
        self._publish_if_changed("alerts", self.documents())

    def _publish_if_changed(self, kind: str, documents: list[Document], settled: list[Document] | None = None) -> None:
        encoded = encode(documents if settled is None else settled)
        if self._published.get(kind) != encoded:
            self._published[kind] = encoded
            shown = encoded if settled is None else encode(documents)
            self._fanout.publish(fleet_event(kind, utc_now(), NARROW[kind], **{kind: orjson.Fragment(shown)}))


def stop_of(robots: Iterable[Document]) -> Document:
    """Return the latches of robots as one. No robot of a site that is not connected counts as stopped."""
    stops = [robot["stop"] if robot["site_state"] is SiteState.CONNECTED else NO_STOP for robot in robots]
    latched = bool(stops) and all(stop["latched"] for stop in stops)
    first = min(stops, key=lambda stop: str(stop["stopped_at"])) if latched else NO_STOP
    return {
        "latched": latched,
        "stopped_at": first["stopped_at"],
        "by": first["by"],
        "robots": sorted({robot for stop in stops for robot in stop["robots"]}),
        "persisted": all(stop["persisted"] for stop in stops),
    }


def servers_of(robots: Iterable[Document], namespace: str) -> Document:
    """Return the docking and the undocking server of a robot. One of a site that is not connected has none."""
    for robot in robots:
        if robot["name"] == namespace and robot["site_state"] is SiteState.CONNECTED:
            return {verb: robot[verb] or NO_SERVER for verb in ("dock", "undock")}
    return {"dock": NO_SERVER, "undock": NO_SERVER}


def narrow_sites(document: Document, grant: Grant) -> Document:
    """Return the sites that a grant reaches, without the names of robots that it does not cover."""
    sites = [
        site | {"stop": {**site["stop"], "robots": [*filter(grant.covers_robot, site["stop"]["robots"])]}}
        for site in document["sites"]
        if site_grant(grant, site["name"]) is not None
    ]
    return {**document, "sites": sites}


NARROW: dict[str, Narrow] = {
    "robots": narrow_robots,
    "alerts": narrow_alerts,
    "approvals": narrow_approvals,
    "sites": narrow_sites,
}


def _text(since: object) -> str:
    return since.isoformat().replace("+00:00", "Z") if isinstance(since, datetime) else str(since)
