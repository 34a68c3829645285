"""The alerts of now: told to whoever asks, as they come, end and are acknowledged."""

import asyncio
import logging
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from dock_gateway.core.errors import NotFound, Unavailable
from dock_gateway.core.event import fleet_event, utc_now
from dock_gateway.core.goal import Goal, encode
from dock_gateway.core.hub import Hub
from dock_gateway.core.tasks import cancel
from dock_gateway.fleet.alert_rules import NO_DUPLICATES, Alert, AlertRules
from dock_gateway.fleet.robot_state import RobotState
from dock_gateway.history import Acknowledgement, AcknowledgementStore, Incident


class Acknowledgements:
    """Acknowledgements by the id of the alert. While the history does not answer, they are in this process alone.

    Args:
        store: Where they are kept.
    """

    def __init__(self, store: AcknowledgementStore) -> None:
        self._store = store
        self._known: dict[str, Acknowledgement] = {}
        self._unsaved: dict[str, Acknowledgement | None] = {}
        self._changes = 0
        self._saving = asyncio.Lock()

    @property
    def unsaved(self) -> bool:
        """Whether there is something that is not kept yet."""
        return bool(self._unsaved)

    def get(self, alert_id: str) -> Acknowledgement | None:
        """That of an alert, where there is one."""
        return self._known.get(alert_id)

    def ids(self) -> set[str]:
        """The alerts that are acknowledged."""
        return set(self._known)

    def put(self, alert_id: str, acknowledgement: Acknowledgement | None) -> None:
        """Take up an acknowledgement, or that there is none; `sync` keeps it."""
        if acknowledgement is None:
            self._known.pop(alert_id, None)
        else:
            self._known[alert_id] = acknowledgement
        self._unsaved[alert_id] = acknowledgement
        self._changes += 1

    async def sync(self) -> bool:
        """Keep what is not kept yet, and learn what other gateways have kept; False where the history is away."""
        try:
            await self._save()
            changes = self._changes
            kept = await self._store.read()
        except Unavailable:
            return False
        if changes == self._changes:  # else what was read may be older
            self._known = kept
        return True

    async def save(self) -> None:
        """Keep what is not kept yet, where the history answers."""
        with suppress(Unavailable):
            await self._save()

    async def _save(self) -> None:
        async with self._saving:
            for alert_id, acknowledgement in list(self._unsaved.items()):
                await self._store.write(alert_id, acknowledgement)
                if self._unsaved[alert_id] is acknowledgement:
                    del self._unsaved[alert_id]


log = logging.getLogger(__name__)

TOPIC = "robots"
# What other gateways have been told of the alerts is looked up so often, in seconds, while there are any.
SYNC_INTERVAL = 2.0
# An alert that has not shown up again so many seconds after the start has ended while we were away.
SETTLED_AFTER = 60.0


class AlertBoard:
    """Keeps the alerts and who has acknowledged them.

    Args:
        hub: Where events go, and who wants them.
        acknowledgements: Who has acknowledged what.
        low_battery: Percentage (0 to 1) below which a battery is low.
        incident: Tells what happened to the history.
    """

    def __init__(
        self,
        hub: Hub,
        acknowledgements: Acknowledgements,
        *,
        low_battery: float,
        incident: Callable[[], Incident | None] = lambda: None,
    ) -> None:
        self._hub = hub
        self._acknowledgements = acknowledgements
        self._watch = AlertRules(low_battery)
        self._incident = incident
        self._alerts: dict[str, Alert] = {}
        self._told: bytes | None = None
        self._task = asyncio.create_task(self._sync())

    def look(
        self, states: list[RobotState], strays: list[Goal], duplicates: Mapping[str, list[str]] = NO_DUPLICATES
    ) -> None:
        """Find out what is wrong now, and tell whoever wants to hear of it where that is something else than before.

        Args:
            states: The robots.
            strays: Lost goals on actions that belong to no robot.
            duplicates: By robot, the actions that have more than one server.
        """
        found = self._watch.look(
            states, strays, utc_now(), time.monotonic(), incident=self._incident(), duplicates=duplicates
        )
        alerts = {alert.id: alert for alert in found}
        for ended in self._alerts.keys() - alerts.keys():
            log.info("alert over: %s of %s", self._alerts[ended].kind, self._alerts[ended].robot or "the gateway")
            self._acknowledgements.put(ended, None)
        for came in alerts.keys() - self._alerts.keys():
            robot = alerts[came].robot or "the gateway"
            log.warning("alert: %s of %s. %s", alerts[came].kind, robot, alerts[came].detail)
        self._alerts = alerts
        self._tell()

    def documents(self) -> list[dict[str, Any]]:
        """The alerts as `GET /alerts` shows them: critical ones first, then the oldest first."""
        return [self._document(alert) for alert in self._alerts.values()]

    def _document(self, alert: Alert) -> dict[str, Any]:
        return alert.document(self._acknowledgements.get(alert.id))

    def _tell(self) -> None:
        if not self._hub.watched(TOPIC):
            self._told = None
            return
        now = encode(documents := self.documents())
        if now != self._told:
            self._told = now
            self._hub.publish(fleet_event("alerts", utc_now(), alerts=documents))

    # ------------------------------------------------------------------ acknowledgements

    async def acknowledge(self, alert_id: str, by: str) -> dict[str, Any]:
        """Somebody has seen an alert; returns it.

        Raises:
            NotFound: `alert_not_found`.
        """
        return await self._change(alert_id, Acknowledgement(by, utc_now()))

    async def withdraw(self, alert_id: str) -> dict[str, Any]:
        """Nobody has seen it after all; returns the alert.

        Raises:
            NotFound: `alert_not_found`.
        """
        return await self._change(alert_id, None)

    async def _change(self, alert_id: str, acknowledgement: Acknowledgement | None) -> dict[str, Any]:
        alert = self._alerts.get(alert_id)
        if alert is None:
            raise NotFound(f"there is no alert {alert_id}; it may be over", code="alert_not_found")
        self._acknowledgements.put(alert_id, acknowledgement)
        self._tell()
        await self._acknowledgements.save()
        return self._document(alert)

    async def _sync(self) -> None:
        settled_at = time.monotonic() + SETTLED_AFTER
        settled = False
        while True:
            try:
                if not settled or self._alerts or self._acknowledgements.unsaved:
                    answered = await self._acknowledgements.sync()
                    if answered and not settled and time.monotonic() >= settled_at:
                        settled = True
                        self._forget_others()
            except Exception:
                log.exception("while the acknowledgements were looked up")
            await asyncio.sleep(SYNC_INTERVAL)

    def _forget_others(self) -> None:
        for alert_id in self._acknowledgements.ids() - self._alerts.keys():
            self._acknowledgements.put(alert_id, None)

    async def close(self) -> None:
        """Look no more."""
        await cancel(self._task)
