"""Sends the beginning and the end of each alert to the webhooks, once for all gateways that share the history."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Mapping
from contextlib import ExitStack

import orjson

from dock_gateway.core.alerts import SETTLED_AFTER, Alerts
from dock_gateway.core.cursor import Cursor, newest
from dock_gateway.core.errors import Conflict
from dock_gateway.core.event import utc_now
from dock_gateway.core.share import EVERYTHING, Share
from dock_gateway.core.tasks import Tasks
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.webhooks.delivery import Delivery, DeliveryState, EventType
from dock_gateway.extensions.webhooks.outbox import Document, Outbox, delivery_document
from dock_gateway.extensions.webhooks.sender import new_secret
from dock_gateway.extensions.webhooks.webhook import WebhookEntry
from dock_gateway.robots.labels import NO_LABEL, RobotLabel
from dock_gateway.robots.robots import RobotLabels
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries

log = logging.getLogger(__name__)

MAX_WEBHOOKS = 20
# Seconds between two scans of the alerts.
INTERVAL = 1.0
# Looks between two reads of the webhooks, which other gateways may have changed, and of the deliveries, in which what
# is outdated is deleted: a multiple.
READ_EVERY, TIDY_EVERY = 2, 30


class Notifier:
    """Holds the webhooks, and sends them the alerts that they want.

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
        *,
        webhooks: SharedBook[WebhookEntry],
        outbox: Outbox,
        share: Share = EVERYTHING,
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
        self._testing: set[str] = set()
        self._tasks = Tasks("notifying webhooks")
        self._tasks.spawn(self._run())
        self._listening = ExitStack()
        self._listening.enter_context(alerts.on_change.adding(self._compare))

    @property
    def attempts(self) -> Mapping[DeliveryState, int]:
        """Number of attempts to send, by the state of the delivery after it."""
        return self._outbox.attempts

    # ------------------------------------------------------------------ webhooks

    async def documents(self) -> list[Document]:
        """Return the webhooks as `GET /webhooks` shows them, by name.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        webhooks = await self._read()
        await self._outbox.read()
        ordered = sorted(webhooks.items(), key=lambda item: (item[1].name.casefold(), item[0]))
        return [self._document(webhook_id, webhook) for webhook_id, webhook in ordered]

    async def document(self, webhook_id: str) -> Document:
        """Return a webhook as `GET /webhooks/{webhook_id}` shows it.

        Raises:
            NotFound: `webhook_not_found`.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        webhook = (await self._read()).get(webhook_id)
        if webhook is None:
            raise self._webhooks.missing(webhook_id)
        await self._outbox.read()
        return self._document(webhook_id, webhook)

    async def replace(
        self, webhook_id: str, webhook: WebhookEntry, condition: Condition = UNCONDITIONAL
    ) -> tuple[Document, bool]:
        """Store a webhook, new or changed; return it, with its secret if that was made now, and whether it is new.

        Args:
            webhook_id: Its id.
            webhook: The webhook; with an empty secret, it keeps the one that it has, or gets a random one.
            condition: The version that it must have.

        Raises:
            ChangedMeanwhile: The condition is not true.
            Conflict: `limit_reached`.
            Unavailable: The history does not answer (`history_unavailable`); the webhook is what it was.
        """
        known = (await self._read()).get(webhook_id)
        made = None
        if not webhook.secret:
            made = None if known is not None else new_secret()
            secret = made or (known.secret if known is not None else "")
            webhook = webhook.model_copy(update={"secret": secret})
        new = await self._webhooks.replace(webhook_id, webhook, condition=condition)
        state = "on" if webhook.enabled else "off"
        log.info("webhook %s (%r): %s, by %s", webhook_id, webhook.name, state, webhook.changed_by)
        await self._outbox.tidy()
        self._compare()
        return self._document(webhook_id, webhook) | {"secret": made}, new

    async def remove(self, webhook_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a webhook with its deliveries.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: `webhook_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the webhook is still there.
        """
        await self._webhooks.remove(webhook_id, condition)
        log.info("webhook %s removed", webhook_id)
        await self._outbox.tidy()

    async def _read(self) -> Mapping[str, WebhookEntry]:
        webhooks = await self._webhooks.read()
        self._compare()
        return webhooks

    def _document(self, webhook_id: str, webhook: WebhookEntry) -> Document:
        own = self._outbox.of(webhook_id)
        tried = [(each.tried_at, identity, each) for identity, each in own if each.tried_at is not None]
        _, identity, last = max(tried, key=lambda each: each[0], default=(None, "", None))
        return {
            "id": webhook_id,
            "etag": self._webhooks.etag(webhook),
            **webhook.model_dump(exclude={"secret"}),
            "pending": sum(each.state is DeliveryState.PENDING for _, each in own),
            "last_delivery": None if last is None else delivery_document(identity, last),
        }

    async def deliveries(
        self, webhook_id: str, limit: int, end: Cursor | None = None
    ) -> tuple[list[Document], Cursor | None]:
        """Return the deliveries of a webhook as `GET /webhooks/{webhook_id}/deliveries` shows them, newest first.

        Args:
            webhook_id: Its id.
            limit: The length of a page.
            end: Where the page before ended; None for the first one.

        Returns:
            The page, and where it ends; None if it is the last one.

        Raises:
            NotFound: `webhook_not_found`.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        if webhook_id not in await self._read():
            raise self._webhooks.missing(webhook_id)
        await self._outbox.read()
        found = dict(self._outbox.of(webhook_id))
        places, end = newest((Cursor(each.created_at, identity) for identity, each in found.items()), limit, end)
        return [delivery_document(each.id, found[each.id]) for each in places], end

    async def test(self, webhook_id: str) -> Document:
        """Send a test now, once, also to a webhook that is off; return the delivery.

        Raises:
            NotFound: `webhook_not_found`.
            Conflict: Another test is being sent (`test_running`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        webhook = (await self._read()).get(webhook_id)
        if webhook is None:
            raise self._webhooks.missing(webhook_id)
        if webhook_id in self._testing:
            raise Conflict("another test is being sent to this webhook", code="test_running")
        self._testing.add(webhook_id)
        try:
            return await self._outbox.send_test(webhook_id, webhook)
        finally:
            self._testing.discard(webhook_id)

    # ------------------------------------------------------------------ scanning

    async def _run(self) -> None:
        while True:
            try:
                await self._scan()
            except Exception:
                log.exception("while checking which alerts to send")
            await asyncio.sleep(self._interval)

    async def _scan(self) -> None:
        if self._scans % self._read_every == 0:
            answers = await self._webhooks.sync()
            if answers and self._scans % self._tidy_every == 0:
                await self._outbox.tidy()
        self._scans += 1
        self._compare()
        while self._news:
            await self._outbox.add(*self._news.popleft())
        if not self._settled and time.monotonic() >= self._settled_at:
            await self._clear_earlier()
        await self._outbox.send_due()

    @property
    def _on(self) -> dict[str, WebhookEntry]:
        return {webhook_id: webhook for webhook_id, webhook in self._webhooks.all().items() if webhook.enabled}

    def _compare(self) -> None:
        """Compare the alerts with those that were sent, and queue the differences."""
        on = self._on
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
        return NO_LABEL if alert["robot"] is None else self._labels.of(alert["robot"])

    async def _clear_earlier(self) -> None:
        """Send the end of alerts that were raised before this gateway started, and have not come again."""
        earlier = await self._outbox.open_before(self._started)
        if earlier is None:
            return
        self._settled = True
        alerts = {alert["id"] for alert in self._alerts.documents()}
        for delivery in earlier:
            if delivery.alert_id is not None and delivery.alert_id not in alerts:
                alert = orjson.loads(delivery.body)["data"]
                if alert["robot"] is not None and not self._share.covers_robot(alert["robot"]):
                    continue
                event = self._event(EventType.CLEARED, alert)
                await self._outbox.add(EventType.CLEARED, delivery.webhook_id, delivery.alert_id, event)

    def _event(self, event_type: EventType, alert: Document) -> Document:
        label = self._label_of(alert)
        title = f"{alert['title']} ({label.display_name or alert['robot'] or 'the gateway'})"
        text = f"Cleared: {title}" if event_type is EventType.CLEARED else f"{title}: {alert['detail']}"
        return {"text": text, "data": alert | vars(label)}

    async def close(self) -> None:
        """Stop sending. Pending deliveries are sent after the next start."""
        self._listening.close()
        await self._tasks.close()
        await self._outbox.close()


def make_notifier(history: History, alerts: Alerts, labels: RobotLabels, share: Share = EVERYTHING) -> Notifier:
    """Make the notifier of the webhooks that a history has; arguments as for `Notifier`."""
    webhooks = SharedBook(history.documents("webhook", WebhookEntry), "webhook", MAX_WEBHOOKS)
    outbox = Outbox(webhooks, SharedEntries(history.documents("delivery", Delivery)))
    return Notifier(alerts, labels, webhooks=webhooks, outbox=outbox, share=share)
