"""Sends the beginning and the end of each alert to the webhooks, once for all gateways that share the history."""

import logging
import time
from collections import deque

from dock_gateway.core.alerts import SETTLED_AFTER, Alerts
from dock_gateway.core.event import utc_now
from dock_gateway.core.share import EVERYTHING, Share
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.webhooks.delivery import Document, EventType
from dock_gateway.extensions.webhooks.outbox import Outbox
from dock_gateway.extensions.webhooks.webhook import WebhookEntry
from dock_gateway.robots.labels import NO_LABEL, RobotLabel
from dock_gateway.robots.robots import RobotLabels
from dock_gateway.storage.shared_entries import SharedBook

log = logging.getLogger(__name__)

# Seconds between two scans of the alerts.
INTERVAL = 1.0
# Scans between two reads of the webhooks, which other gateways may have changed, and of the deliveries, of which those
# that no longer count are deleted: a multiple.
READ_EVERY, TIDY_EVERY = 2, 30


class Notifier:
    """Compares the alerts with those that were sent, and sends each webhook what it wants.

    Args:
        alerts: The alerts.
        labels: The names and groups of the robots.
        webhooks: The webhooks, by id.
        outbox: Sends to them.
        share: The robots whose alerts these are.
        settled_after: Seconds after the start after which an alert that has not recurred counts as ended.
        interval: See `INTERVAL`.
        read_every: See `READ_EVERY`.
        tidy_every: See `TIDY_EVERY`.
    """

    def __init__(
        self,
        alerts: Alerts,
        labels: RobotLabels,
        webhooks: SharedBook[WebhookEntry],
        outbox: Outbox,
        share: Share = EVERYTHING,
        *,
        settled_after: float = SETTLED_AFTER,
        interval: float = INTERVAL,
        read_every: int = READ_EVERY,
        tidy_every: int = TIDY_EVERY,
    ) -> None:
        self._interval = interval
        self._read_every = read_every
        self._tidy_every = tidy_every
        self._alerts = alerts
        self._labels = labels
        self._webhooks = webhooks
        self._outbox = outbox
        self._share = share
        self._started, self._settled = utc_now(), False
        self._settled_at = time.monotonic() + settled_after
        self._scans = 0
        self._raised: dict[tuple[str, str], Document] = {}  # alerts that were sent, by webhook and alert
        self._news: deque[tuple[EventType, str, str, Document]] = deque()  # to be stored, then sent
        self._tasks = Tasks("notifying webhooks")

    def start(self) -> None:
        """Scan the alerts from now on."""
        self._tasks.repeat(self._scan, self._interval, "checking which alerts to send")

    async def close(self) -> None:
        """Scan no more."""
        await self._tasks.close()

    async def _scan(self) -> None:
        if self._scans % self._read_every == 0:
            answers = await self._webhooks.sync()
            if answers and self._scans % self._tidy_every == 0:
                await self._outbox.tidy()
        self._scans += 1
        self.compare()
        while self._news:
            await self._outbox.add(*self._news.popleft())
        if not self._settled and time.monotonic() >= self._settled_at:
            await self._clear_earlier()
        await self._outbox.send_due()

    def compare(self) -> None:
        """Compare the alerts with those that were sent, and queue the differences."""
        on = {webhook_id: webhook for webhook_id, webhook in self._webhooks.all().items() if webhook.enabled}
        self._raised = {key: alert for key, alert in self._raised.items() if key[0] in on}
        if not on:
            return
        alerts = {alert["id"]: alert for alert in self._alerts.documents()}
        for webhook_id, webhook in on.items():
            for alert_id, alert in alerts.items():
                if (webhook_id, alert_id) not in self._raised and self._wants(webhook, alert):
                    self._raised[webhook_id, alert_id] = alert
                    self._news.append((EventType.RAISED, webhook_id, alert_id, self._event(EventType.RAISED, alert)))
        for key in [key for key in self._raised if key[1] not in alerts]:
            self._news.append((EventType.CLEARED, *key, self._event(EventType.CLEARED, self._raised.pop(key))))

    def _wants(self, webhook: WebhookEntry, alert: Document) -> bool:
        return webhook.wants(alert["severity"], alert["robot"], self._label_of(alert).groups)

    def _label_of(self, alert: Document) -> RobotLabel:
        """Return the label of an alert's robot; an empty one if the alert concerns the gateway."""
        return NO_LABEL if alert["robot"] is None else self._labels.get(alert["robot"])

    async def _clear_earlier(self) -> None:
        """Send the end of alerts that were raised before this gateway started, and have not come again."""
        earlier = await self._outbox.open_before(self._started)
        if earlier is None:
            return
        self._settled = True
        alerts = {alert["id"] for alert in self._alerts.documents()}
        for delivery in earlier:
            if delivery.alert_id is not None and delivery.alert_id not in alerts:
                alert = delivery.event["data"]
                if alert["robot"] is not None and not self._share.covers_robot(alert["robot"]):
                    continue
                event = self._event(EventType.CLEARED, alert)
                await self._outbox.add(EventType.CLEARED, delivery.webhook_id, delivery.alert_id, event)

    def _event(self, event_type: EventType, alert: Document) -> Document:
        label = self._label_of(alert)
        title = f"{alert['title']} ({label.display_name or alert['robot'] or 'the gateway'})"
        text = f"Cleared: {title}" if event_type is EventType.CLEARED else f"{title}: {alert['detail']}"
        return {"text": text, "data": alert | vars(label)}
