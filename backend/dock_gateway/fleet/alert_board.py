"""The current alerts: publishes them when they begin, end or are acknowledged."""

import asyncio
import logging
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from dock_gateway.core.alerts import SETTLED_AFTER
from dock_gateway.core.errors import NotFound
from dock_gateway.core.event import fleet_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, encode
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.listeners import Hooks, Listeners
from dock_gateway.core.narrowing import narrow_alerts
from dock_gateway.core.tasks import cancel
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.fleet.acknowledgements import acknowledge
from dock_gateway.fleet.alert import Acknowledgement, Alert, alert_id
from dock_gateway.fleet.alert_kinds import CORE_KINDS, AlertKind
from dock_gateway.fleet.alert_rules import NO_DUPLICATES, AlertRules
from dock_gateway.fleet.findings import Finding
from dock_gateway.fleet.robot_state import RobotState
from dock_gateway.goals.hints import Join
from dock_gateway.storage import Incident
from dock_gateway.storage.shared_entries import SYNC_INTERVAL, SharedEntries

log = logging.getLogger(__name__)

Source = Callable[[], Iterable[Alert]]


class AlertBoard:
    """Holds the alerts and their acknowledgements.

    Args:
        fanout: Receives events, and knows the subscribers.
        acknowledgements: The acknowledgements.
        low_battery: Charge (0 to 1) below which a battery is low.
        incident: Returns the incident of the history, or None.
        findings: Returns the faults on the ROS graph, once for each kind and robot.
        only: Returns the robots of this gateway, where others on the same database have alerts of other robots.
        sync_interval: Seconds between two reads of what other gateways have acknowledged.
        settled_after: See `SETTLED_AFTER`.
    """

    def __init__(
        self,
        fanout: Fanout,
        acknowledgements: SharedEntries[Acknowledgement],
        *,
        low_battery: float,
        incident: Callable[[], Incident | None] = lambda: None,
        findings: Callable[[], Iterable[Finding]] = tuple,
        only: Callable[[], Iterable[str]] | None = None,
        sync_interval: float = SYNC_INTERVAL,
        settled_after: float = SETTLED_AFTER,
    ) -> None:
        self._fanout = fanout
        self._acknowledgements = acknowledgements
        self._rules = AlertRules(low_battery)
        self._incident = incident
        self._findings = findings
        self._only = only
        self._sync_interval = sync_interval
        self._settled_after = settled_after
        self._alerts: dict[str, Alert] = {}
        self._published: bytes | None = None
        self.on_change = Listeners[[]]("an alert begins or ends")
        self.sources = Hooks[Source]()  # return further alerts, which are active
        self._failing: list[Source] = []
        self.kinds: set[AlertKind] = {*CORE_KINDS}  # a source returns alerts of these
        self._task = asyncio.create_task(self._sync())

    def update(
        self,
        states: list[RobotState],
        strays: list[Goal],
        duplicates: Mapping[str, list[str]] = NO_DUPLICATES,
        split: Iterable[Join] = (),
    ) -> None:
        """Update the alerts, and publish them to subscribers if they changed.

        Args:
            states: The robots.
            strays: Lost goals on actions that belong to no robot.
            duplicates: By robot, the actions that have more than one server.
            split: Robots that are probably in two namespaces.
        """
        found = self._rules.evaluate(
            states,
            strays,
            utc_now(),
            time.monotonic(),
            incident=self._incident(),
            duplicates=duplicates,
            findings=self._findings(),
            split=split,
            further=[alert for source in self.sources for alert in self._ask(source)],
        )
        alerts = {alert.id: alert for alert in found}
        for ended in self._alerts.keys() - alerts.keys():
            log.info("alert cleared: %s of %s", self._alerts[ended].kind, self._alerts[ended].robot or "the gateway")
            self._acknowledgements.put(ended, None)
        for came in alerts.keys() - self._alerts.keys():
            robot = alerts[came].robot or "the gateway"
            log.warning("alert: %s of %s. %s", alerts[came].kind, robot, alerts[came].detail)
        changed = alerts.keys() != self._alerts.keys()
        self._alerts = alerts
        self._publish()
        if changed:
            self.on_change()

    def _ask(self, source: Source) -> Iterable[Alert]:
        """Return the alerts of a source. One that fails has none, and the log says so once."""
        try:
            alerts = list(source())
        except Exception:
            if source not in self._failing:
                log.exception("alerts cannot be read")
                self._failing.append(source)
            return []
        if source in self._failing:
            self._failing.remove(source)
        return alerts

    def documents(self, grant: Grant = UNLIMITED) -> list[dict[str, Any]]:
        """Return the alerts of a grant as `GET /alerts` shows them: critical ones first, then oldest first."""
        return [self._document(alert) for alert in self._alerts.values() if grant.covers_alert(alert.robot)]

    def of_graph(self, robot: str) -> list[Alert]:
        """Return the alerts about faults on the ROS graph, of a robot or of the gateway."""
        return [alert for alert in self._alerts.values() if alert.kind.on_graph and alert.robot in (robot, None)]

    def get(self, alert_id: str, grant: Grant = UNLIMITED) -> Alert:
        """Return an alert.

        Raises:
            NotFound: There is none, or the grant does not cover it (`alert_not_found`).
        """
        alert = self._alerts.get(alert_id)
        if alert is None or not grant.covers_alert(alert.robot):
            raise NotFound(f"there is no alert {alert_id}; it may have cleared", code="alert_not_found")
        return alert

    def _document(self, alert: Alert) -> dict[str, Any]:
        return alert.document(self._acknowledgements.get(alert.id))

    def _publish(self) -> None:
        if not self._fanout.watched("alerts"):
            self._published = None
            return
        now = encode(documents := self.documents())
        if now != self._published:
            self._published = now
            self._fanout.publish(fleet_event("alerts", utc_now(), narrow_alerts, alerts=documents))

    # ------------------------------------------------------------------ acknowledgements

    def document(self, alert_id: str, grant: Grant = UNLIMITED) -> dict[str, Any]:
        """Return an alert as `GET /alerts/{alert_id}` shows it.

        Raises:
            NotFound: There is none, or the grant does not cover it (`alert_not_found`).
        """
        return self._document(self.get(alert_id, grant))

    async def acknowledge(self, alert_id: str, by: str | None, condition: Condition = UNCONDITIONAL) -> dict[str, Any]:
        """Acknowledge an alert, or with `by` None withdraw that; return it.

        While the history does not answer, that applies to this process only, unless it depends on a version.

        Raises:
            NotFound: `alert_not_found`.
            ChangedMeanwhile: It has not the version of the condition.
            Unavailable: There is a condition, and the history does not answer (`history_unavailable`).
        """
        alert = self.get(alert_id)
        acknowledgement = None if by is None else Acknowledgement(by, utc_now())
        await acknowledge(self._acknowledgements, alert, acknowledgement, condition)
        self._publish()
        return self._document(alert)

    async def _sync(self) -> None:
        settled_at = time.monotonic() + self._settled_after
        settled = False
        while True:
            try:
                if not settled or self._alerts or self._acknowledgements.unsaved:
                    answered = await self._acknowledgements.sync()
                    if answered and not settled and time.monotonic() >= settled_at:
                        settled = True
                        self._forget_others()
            except Exception:
                log.exception("while reading the acknowledgements")
            await asyncio.sleep(self._sync_interval)

    def _forget_others(self) -> None:
        ended = self._acknowledgements.keys() - self._alerts.keys()
        if self._only is not None:
            ended &= {alert_id(kind, robot) for kind in self.kinds for robot in self._only()}
        for each in ended:
            self._acknowledgements.put(each, None)

    async def close(self) -> None:
        """Stop the synchronization with the history."""
        await cancel(self._task)
